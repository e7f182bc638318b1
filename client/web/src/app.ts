// The page: which mesh is shown, its copy, its watch, and the parts that show them.
import { Code, ConnectError } from '@connectrpc/connect';
import type { MeshOptions } from '../gen/dynmesh/v1/mesh_pb.js';
import type { Place } from './draw/camera.js';
import { colourAt, mixed, ramps, themes, type Colour, type ThemeName } from './draw/palette.js';
import { fills, type Look } from './draw/picture.js';
import { Replica } from './model/replica.js';
import { placesOf } from './model/picking.js';
import type { SlotMesh } from './model/slot_mesh.js';
import { connect, setToken, token, type Service } from './service/client.js';
import { Editor, type Refusal } from './service/editor.js';
import { mayRetry, messageOf, Pauses, sleep } from './service/retry.js';
import { Watch, type Connection } from './service/watch.js';
import { Controls } from './ui/controls.js';
import { save, svgOf } from './ui/download.js';
import { keyHelp, listenTo, type Keys } from './ui/keys.js';
import { Overlay } from './ui/overlay.js';
import { Statistics } from './ui/statistics.js';
import { Timeline } from './ui/timeline.js';
import { meshDetails, triangleDetails } from './ui/details.js';
import { byId, definitions, element } from './ui/dom.js';
import { readLink, writeLink, type Link } from './ui/link.js';
import { MeshList } from './ui/mesh_list.js';
import { Tools } from './ui/tools.js';
import { View, type Box } from './view.js';

const FADE_SECONDS = 3;

/** What a notice is about; there is one of each at most. */
type Topic = 'edit' | 'picture' | 'connection' | 'list';

export class App {
  readonly service: Service = connect();
  readonly view: View;
  replica = new Replica();
  connection: Connection = 'ended';
  watch: Watch | undefined;
  link: Link;

  readonly #status = byId('status', HTMLElement);
  readonly #notice = byId('notice', HTMLElement);
  readonly #title = byId('title', HTMLElement);
  readonly #list: MeshList;
  readonly #controls: Controls;
  readonly #figures = element('section', { hidden: true });
  readonly #place = element('section', { hidden: true });
  readonly #timeline: Timeline;
  readonly #tools: Tools;
  readonly #overlay: Overlay;
  readonly #notices = new Map<Topic, string>();
  #editor: Editor | undefined;
  /** Meshes that were chosen: what comes for one before the last is dropped. */
  #generation = 0;
  /** Where the last edit was. */
  #editedAt: Place | undefined;
  readonly #statistics: Statistics;
  #theme: ThemeName = 'light';
  isPaused = false;
  #options: MeshOptions | undefined;
  /** The mesh that the view has. */
  #shown: SlotMesh | undefined;
  #selected = -1;
  #figuresAreOld = false;

  constructor() {
    this.link = readLink(location.hash);
    const dark = matchMedia('(prefers-color-scheme: dark)');
    dark.addEventListener('change', () => this.#setTheme(dark.matches ? 'dark' : 'light'));
    const panel = byId('panel', HTMLElement);
    this.#controls = new Controls(panel, (choice) => this.#choose(choice));
    this.#overlay = new Overlay(byId('frame', HTMLElement));
    this.#tools = new Tools(panel, {
      drafted: (draft) => {
        this.#overlay.draft = draft;
        this.#overlay.draw(this.view.plane);
      },
      editedAt: (place) => {
        this.#editedAt = place;
        this.#overlay.marks = [];
      },
    });
    panel.append(this.#figures, this.#place);
    this.#statistics = new Statistics(panel, (name, share) => this.#histogramColour(name, share));
    this.#timeline = new Timeline(byId('timeline', HTMLElement), {
      pause: (isPaused) => this.#pause(isPaused),
      move: (steps) => this.#move(steps),
    });
    this.view = new View(byId('picture', HTMLCanvasElement), this.#look(), {
      hovered: (row) => {
        if (this.#selected < 0) this.#showTriangle(row);
      },
      clicked: (row, place) => {
        this.#selected = row;
        this.#showTriangle(row);
        this.#tools.click(place, this.view.plane.scale);
      },
      drawn: () => this.#overlay.draw(this.view.plane),
      grabbed: (place) => this.#tools.down(place, this.view.plane.scale),
      dragged: (place) => this.#tools.drag(place),
      dropped: () => this.#tools.up(),
      cancelled: () => this.#tools.cancel(),
      undrawn: (reason) => this.#notify('picture', reason),
      settled: () => this.#rememberView(),
    });
    this.#list = new MeshList(this.service, byId('meshes', HTMLElement), {
      failed: (error) => this.#failed('list', error),
      refreshed: () => this.#notify('list', ''),
      only: (mesh) => {
        if (this.link.mesh !== '') return;
        history.replaceState(null, '', writeLink({ ...this.link, mesh }));
        void this.#follow(readLink(location.hash));
      },
    });
    this.#setTheme(dark.matches ? 'dark' : 'light');
    this.#offerActions();
    addEventListener('hashchange', () => void this.#follow(readLink(location.hash)));
    document.addEventListener('visibilitychange', () => this.#wakeOrSleep());
    void this.#follow(this.link);
  }

  async #follow(link: Link): Promise<void> {
    const isOther = link.mesh !== this.link.mesh || this.watch === undefined;
    this.link = link;
    this.view.setLook(this.#look());
    this.view.setClip(link.clip);
    this.#showControls();
    this.#list.select(link.mesh);
    if (!isOther) {
      this.#applyView();
      return;
    }
    const generation = ++this.#generation;
    this.watch?.stop();
    this.watch = undefined;
    this.#editor?.close();
    this.#editor = undefined;
    this.#overlay.marks = [];
    this.#notify('edit', '');
    this.#connected('ended', '');
    this.replica = new Replica();
    this.isPaused = false;
    this.#shown = undefined;
    this.#selected = -1;
    this.view.setMesh(undefined);
    this.#tools.setMesh(undefined, undefined);
    this.#showFigures();
    this.#title.textContent = link.mesh === '' ? 'No mesh chosen' : link.mesh;
    if (link.mesh !== '') await this.#open(link.mesh, generation);
  }

  /** Asks for the mesh until the server says what it is, or another one is chosen. */
  async #open(id: string, generation: number): Promise<void> {
    const name = `meshes/${id}`;
    const pauses = new Pauses();
    this.#connected('connecting', '');
    for (;;) {
      try {
        const { options, revision } = await this.service.getMesh({ mesh: name });
        if (generation !== this.#generation) return;
        this.#show(options, revision);
        break;
      } catch (error) {
        if (generation !== this.#generation) return;
        this.#connected(mayRetry(error) ? 'lost' : 'ended', messageOf(error));
        if (!mayRetry(error)) {
          this.#askForTokenAfter(error);
          return;
        }
        await sleep(pauses.next());
        if (generation !== this.#generation) return;
      }
    }
    this.#editor = new Editor(this.service, name, {
      applied: () => {
        this.#notify('edit', '');
        this.#tools.update();
      },
      refused: (refusal) => this.#refused(refusal),
      renamed: (from, to) => this.#tools.renamed(from, to),
    });
    const { replica } = this;
    this.watch = new Watch(
      this.service,
      name,
      replica,
      {
        changed: () => this.#changed(replica),
        connection: (state, reason) => {
          if (generation === this.#generation) this.#connected(state, reason);
        },
        loading: (share) => {
          if (generation === this.#generation) this.#loading(share);
        },
      },
      () => this.view.stamp(),
    );
    this.#wakeOrSleep();
  }

  #show(options: MeshOptions | undefined, revision: bigint): void {
    this.replica.openedAt = revision;
    this.#options = options;
    this.view.setBox(boxOf(options));
    this.#applyView();
    this.#showControls();
    this.view.setLook(this.#look());
  }

  /** A page that is not seen watches nothing. */
  #wakeOrSleep(): void {
    if (document.hidden || this.isPaused) this.watch?.stop();
    else this.watch?.start();
    if (!document.hidden) void this.#list.refresh();
  }

  #pause(isPaused: boolean): void {
    this.isPaused = isPaused;
    // Back to the present, from which the watch goes on.
    if (!isPaused) this.#moveBy(this.replica.history.behind);
    this.#wakeOrSleep();
    this.#showFigures();
  }

  #move(steps: number): void {
    if (!this.isPaused) this.#pause(true);
    this.#moveBy(steps);
  }

  #moveBy(steps: number): void {
    if (steps === 0 || this.replica.mesh === undefined) return;
    this.replica.move(steps, this.view.stamp());
    this.#changed(this.replica);
  }

  #changed(replica: Replica): void {
    if (replica !== this.replica || replica.mesh === undefined) return;
    if (this.#shown !== replica.mesh) {
      this.#shown = replica.mesh;
      this.#selected = -1;
      this.view.setMesh(replica.mesh);
      this.#tools.setMesh(replica.mesh, this.#editor);
    } else {
      this.view.meshChanged();
    }
    if (this.#figuresAreOld) return;
    this.#figuresAreOld = true;
    requestAnimationFrame(() => this.#showFigures());
  }

  #connected(state: Connection, reason: string): void {
    this.connection = state;
    this.#showStatus(reason);
    this.#notify('connection', state === 'ended' || state === 'lost' ? reason : '');
  }

  #loading(share: number): void {
    if (share < 1) this.#status.textContent = `loading: ${Math.floor(100 * share)} %`;
  }

  #showStatus(reason: string): void {
    const words: Record<Connection, string> = {
      connecting: 'connecting',
      live: 'live',
      lost: `connection lost, trying again`,
      asleep: this.isPaused ? 'paused' : 'asleep',
      ended: `ended: ${reason}`,
    };
    this.#status.textContent = this.link.mesh === '' ? '' : words[this.connection];
  }

  #showFigures(): void {
    this.#figuresAreOld = false;
    const { mesh, revision, hash } = this.replica;
    this.#figures.hidden = mesh === undefined;
    this.#statistics.changed(mesh, this.#bound());
    const { before, behind } = this.replica.history;
    this.#timeline.show(revision, before, behind, this.isPaused);
    if (mesh === undefined) return;
    this.#showStatus('');
    this.#figures.replaceChildren(
      element('h2', {}, 'Mesh'),
      definitions([
        ['revision', revision.toString()],
        ...meshDetails(mesh),
        ['hash, checked here', hash],
      ]),
    );
    if (this.#selected >= 0) this.#showTriangle(this.#selected);
  }

  #showTriangle(row: number): void {
    const { mesh } = this.replica;
    const rows = mesh?.dimension === 2 ? triangleDetails(mesh, row) : [];
    this.#place.hidden = rows.length === 0;
    this.#place.replaceChildren(element('h2', {}, 'Triangle'), definitions(rows));
  }

  #choose(choice: Partial<Link>): void {
    this.link = { ...this.link, ...choice };
    this.view.setLook(this.#look());
    this.view.setClip(this.link.clip);
    this.#showControls();
    this.#remember();
  }

  #showControls(): void {
    this.#controls.show(this.link, themes[this.#theme], this.#range(), this.#isSpace());
  }

  #setTheme(name: ThemeName): void {
    this.#theme = name;
    document.documentElement.dataset.theme = name;
    this.view.setLook(this.#look());
    this.#showControls();
  }

  #look(): Look {
    const { fill, ramp, edges, segments, points } = this.link;
    return {
      fill,
      ramp,
      edges,
      segments,
      points,
      theme: themes[this.#theme],
      range: this.#range(),
      fadeSeconds: FADE_SECONDS,
    };
  }

  /** What the ends of the ramp stand for: the worse end is the dark one. */
  #range(): [number, number] {
    switch (this.link.fill) {
      case 'quality':
        return [this.#bound(), this.#isSpace() ? Math.sqrt(6) / 4 : 1 / Math.sqrt(3)];
      case 'angle':
        return [0, this.#isSpace() ? 72 : 60];
      case 'size': {
        const { lo, hi } = boxOf(this.#options);
        const side = Math.log2(Math.max(...hi.map((value, k) => value - lo[k]), 1e-300));
        return [side - 12, side];
      }
      default:
        return [0, 1];
    }
  }

  #bound(): number {
    const quality = this.#options?.quality ?? 0;
    return quality > 0 ? quality : this.#isSpace() ? 2 : Math.SQRT2;
  }

  #isSpace(): boolean {
    return this.#options?.dimension === 3;
  }

  #histogramColour(name: string, share: number): Colour {
    const ramp = ramps[this.link.ramp];
    // The ramp's dark end is the worse one.
    if (name.includes('angle')) return colourAt(ramp, share);
    if (name.includes('circumradius')) return colourAt(ramp, 1 - share);
    return mixed(themes[this.#theme].plain, themes[this.#theme].segment, 0.5);
  }

  #offerActions(): void {
    const keys: Keys = {
      ArrowLeft: { does: 'move left', run: () => this.view.pan(60, 0) },
      ArrowRight: { does: 'move right', run: () => this.view.pan(-60, 0) },
      ArrowUp: { does: 'move up', run: () => this.view.pan(0, 60) },
      ArrowDown: { does: 'move down', run: () => this.view.pan(0, -60) },
      '+': { does: 'closer', run: () => this.view.zoom(1.25) },
      '-': { does: 'farther', run: () => this.view.zoom(0.8) },
      f: { does: 'fit to the window', run: () => this.view.fit() },
      ' ': { does: 'pause or resume', run: () => this.#pause(!this.isPaused) },
      '[': { does: 'one revision back', run: () => this.#move(-1) },
      ']': { does: 'one revision forward', run: () => this.#move(1) },
      e: { does: 'edges', run: () => this.#choose({ edges: !this.link.edges }) },
      s: { does: 'subsegments', run: () => this.#choose({ segments: !this.link.segments }) },
      p: { does: 'input points', run: () => this.#choose({ points: !this.link.points }) },
      t: { does: 'dark or light', run: () => this.#swapTheme() },
      u: { does: 'undo', run: () => this.#tools.undo() },
      r: { does: 'redo', run: () => this.#tools.redo() },
      Enter: { does: 'close the polygon', run: () => this.#tools.finish() },
      Escape: { does: 'choose nothing, draw nothing', run: () => this.#deselect() },
    };
    fills.forEach((fill, i) => {
      keys[String(i + 1)] = { does: `fill by ${fill}`, run: () => this.#choose({ fill }) };
    });
    const help = keyHelp(keys);
    keys['?'] = { does: 'these keys', run: () => help.showModal() };
    listenTo(keys);
    document.body.append(help);
    const actions = byId('actions', HTMLElement);
    for (const [name, run] of [
      ['Fit', () => this.view.fit()],
      ['PNG', () => this.#savePng()],
      ['SVG', () => this.#saveSvg()],
      ['Dark or light', () => this.#swapTheme()],
      ['Keys', () => help.showModal()],
    ] as const) {
      const button = element('button', { type: 'button' }, name);
      button.addEventListener('click', run);
      actions.append(button, ' ');
    }
  }

  #swapTheme(): void {
    this.#setTheme(this.#theme === 'dark' ? 'light' : 'dark');
  }

  #deselect(): void {
    this.#overlay.marks = [];
    this.#tools.cancel();
    this.#notify('edit', '');
    this.#selected = -1;
    this.#showTriangle(this.view.hovered);
  }

  #savePng(): void {
    this.view.drawNow(); // the canvas keeps its picture until the next task only
    byId('picture', HTMLCanvasElement).toBlob((blob) => {
      if (blob !== null) save(`${this.#fileName()}.png`, blob);
    });
  }

  #saveSvg(): void {
    const { mesh } = this.replica;
    if (mesh?.dimension !== 2) {
      this.#notify('edit', 'A picture of vectors is made of meshes in 2D.');
      return;
    }
    const text = svgOf(mesh, this.view.plane, this.#look());
    save(`${this.#fileName()}.svg`, new Blob([text], { type: 'image/svg+xml' }));
  }

  #fileName(): string {
    return `${this.link.mesh}-${this.replica.revision}`;
  }

  #remember(): void {
    history.replaceState(null, '', writeLink(this.link));
  }

  #rememberView(): void {
    if (this.watch === undefined) return;
    const { plane, orbit, isSpace } = this.view;
    const { centre } = plane;
    this.link = {
      ...this.link,
      view: isSpace
        ? [orbit.yaw, orbit.pitch, orbit.distance, ...orbit.target.toArray()]
        : [centre.x, centre.y, plane.scale / plane.fittedScale],
    };
    this.#remember();
  }

  #applyView(): void {
    const { view } = this.link;
    if (view.length === 3) {
      this.view.plane.centre = { x: view[0], y: view[1] };
      this.view.plane.setScale(view[2] * this.view.plane.fittedScale);
    } else if (view.length === 6) {
      this.view.orbit.yaw = view[0];
      this.view.orbit.pitch = view[1];
      this.view.orbit.distance = view[2];
      this.view.orbit.target.fromArray([...view], 3);
    }
    this.view.invalidate();
  }

  #failed(topic: Topic, error: unknown): void {
    this.#askForTokenAfter(error);
    this.#notify(topic, messageOf(error));
  }

  #askForTokenAfter(error: unknown): void {
    if (ConnectError.from(error).code !== Code.Unauthenticated) return;
    const nav = byId('meshes', HTMLElement);
    if (nav.querySelector('form') !== null) return;
    const input = element('input', { type: 'password', autocomplete: 'off' });
    input.value = token() ?? '';
    const problem = element('p', { role: 'alert', class: 'bad' });
    const form = element(
      'form',
      {},
      element('label', {}, 'Token ', input),
      element('button', { type: 'submit' }, 'Use'),
      problem,
    );
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      if (!setToken(input.value.trim())) {
        problem.textContent = 'A token has letters without accents, digits and signs only.';
        return;
      }
      form.remove();
      void this.#list.refresh();
      // A watch that has ended begins again; a mesh that was not opened is.
      if (this.watch === undefined) void this.#follow(this.link);
      else this.#wakeOrSleep();
    });
    nav.prepend(form);
  }

  /** Shows what the server says at the places of the features that it names. */
  #refused({ message, features }: Refusal): void {
    this.#notify('edit', message);
    this.#tools.refused();
    this.#tools.update();
    const { mesh } = this.replica;
    if (mesh?.dimension !== 2) return;
    const named = features.flatMap((id) => placesOf(mesh, id, 32));
    this.#overlay.marks = this.#editedAt ? [this.#editedAt, ...named] : named;
    this.view.invalidate();
  }

  /** Says this, or with an empty text nothing more of the topic. */
  #notify(topic: Topic, text: string): void {
    if ((this.#notices.get(topic) ?? '') === text) return;
    if (text === '') this.#notices.delete(topic);
    else this.#notices.set(topic, text);
    // Of one cause more than one part may complain.
    this.#notice.textContent = [...new Set(this.#notices.values())].join('\n');
    this.#notice.hidden = this.#notices.size === 0;
  }
}

function boxOf(options: MeshOptions | undefined): Box {
  const corner = (side: 'lo' | 'hi', otherwise: number): number[] => {
    const point = options?.box?.[side];
    return point ? [point.x, point.y, point.z ?? 0] : [otherwise, otherwise, 0];
  };
  return { lo: corner('lo', 0), hi: corner('hi', 1) };
}
