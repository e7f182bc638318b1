// The meshes of the server, with figures that are read again while the page is seen.
import type { MeshStats } from '../../gen/dynmesh/v1/mesh_service_pb.js';
import type { Service } from '../service/client.js';
import { count, element } from './dom.js';

const INTERVAL_MS = 2000;
/** Meshes whose figures are asked for; others have their revision only. */
const FIGURES = 20;

export class MeshList {
  #current = '';
  #stats = new Map<string, MeshStats>();
  #isBusy = false;
  /** Something has changed since the refresh that is under way began. */
  #isDue = false;

  constructor(
    private readonly service: Service,
    private readonly parent: HTMLElement,
    private readonly listener: {
      failed(error: unknown): void;
      /** The list is that of the server. */
      refreshed(): void;
      /** The server has one mesh alone. */
      only(mesh: string): void;
    },
  ) {
    setInterval(() => {
      if (!document.hidden && !this.#isBusy) void this.refresh();
    }, INTERVAL_MS);
  }

  select(mesh: string): void {
    this.#current = mesh;
    void this.refresh();
  }

  /** Reads the list again; one at a time, as a slow server may take longer than the interval. */
  async refresh(): Promise<void> {
    this.#isDue = this.#isBusy;
    if (this.#isBusy) return;
    this.#isBusy = true;
    try {
      await this.#read();
    } finally {
      this.#isBusy = false;
    }
    if (this.#isDue) await this.refresh();
  }

  async #read(): Promise<void> {
    try {
      const { meshes, nextPageToken } = await this.service.listMeshes({ pageSize: 1000 });
      const shown = meshes.filter(({ owner }) => owner === '').slice(0, FIGURES);
      // A mesh that is damaged, or was just deleted, has none.
      const answers = await Promise.allSettled(
        shown.map(({ name }) => this.service.getStats({ mesh: name })),
      );
      this.#stats = new Map();
      answers.forEach((answer, i) => {
        const mesh = answer.status === 'fulfilled' ? answer.value.mesh : undefined;
        if (mesh) this.#stats.set(shown[i].name, mesh);
      });
      if (meshes.length === 1) this.listener.only(idOf(meshes[0].name));
      this.#show(
        meshes.map(({ name, revision }) => ({ name, revision })),
        nextPageToken !== '',
      );
      this.listener.refreshed();
    } catch (error) {
      this.listener.failed(error);
    }
  }

  #show(meshes: readonly { name: string; revision: bigint }[], hasMore: boolean): void {
    const rows = meshes.map(({ name, revision }) => {
      const id = idOf(name);
      const link = element('a', { href: `#${new URLSearchParams({ mesh: id }).toString()}` }, id);
      if (id === this.#current) link.setAttribute('aria-current', 'page');
      link.append(element('small', {}, figuresOf(revision, this.#stats.get(name))));
      return element('li', {}, link);
    });
    // What has the focus keeps it.
    const focused = document.activeElement?.getAttribute('href');
    this.parent.replaceChildren(
      element('h2', {}, 'Meshes'),
      rows.length === 0 ? element('p', {}, 'The server has no mesh.') : element('ul', {}, ...rows),
    );
    if (hasMore) this.parent.append(element('p', {}, 'There are more.'));
    if (!focused) return;
    for (const link of this.parent.querySelectorAll('a')) {
      if (link.getAttribute('href') === focused) link.focus();
    }
  }
}

function idOf(name: string): string {
  return name.replace(/^meshes\//, '');
}

function figuresOf(revision: bigint, stats: MeshStats | undefined): string {
  if (stats === undefined) return `revision ${count(revision)}`;
  const kind = stats.dimension === 3 ? 'tetrahedra' : 'triangles';
  return `${count(stats.simplices)} ${kind} · revision ${count(stats.revision)}`;
}
