// A copy of the server's mesh that events of a watch keep up to date, as dynmesh::client::MeshReplica.
// While it is live, it is the server's mesh at `revision`, and the hash was right after each diff.
import type { MeshDiff, SnapshotChunk } from '../../gen/dynmesh/v1/mesh_pb.js';
import type { WatchEvent } from '../../gen/dynmesh/v1/mesh_service_pb.js';
import { addedBy, addedByChunk, removedBy } from './difference.js';
import { History, rowsOf } from './history.js';
import { DataLoss, SlotMesh } from './slot_mesh.js';

export type Change = 'nothing' | 'snapshot' | 'diff';

/** The stamp of what a snapshot has: it is not known when that came. */
const UNCHANGED = 0;

export class Replica {
  /** Undefined before the first whole snapshot. */
  mesh: SlotMesh | undefined;
  revision = 0n;
  /** The hash of `mesh`, computed here and compared with the server's. */
  hash = '';
  /** Diffs applied, each of one revision or, coalesced, of several. */
  diffs = 0;
  /** What changed up to this revision does not glow: it was so when the page was opened. */
  openedAt = 0n;
  /** The share of a snapshot that has come, from 0 to 1. */
  loaded = 0;

  /** Diffs up to the present one, and those that were taken back. */
  readonly history = new History();

  #loading: { mesh: SlotMesh; next: number; simplices: number } | undefined;
  #fragments: MeshDiff[] = [];

  /** Takes the next event of a watch. A DataLoss means: watch again, from a snapshot. */
  take(event: WatchEvent, stamp: number): Change {
    switch (event.event.case) {
      case 'snapshot':
        return this.#takeChunk(event.event.value);
      case 'diff':
        return this.#takeFragment(event.event.value, stamp);
      case 'progress':
        if (event.event.value.revision !== this.revision) {
          throw new DataLoss('the server has sent a revision that did not come');
        }
        this.#compare(event.event.value.hash);
        return 'nothing';
      case undefined:
        return 'nothing'; // of a newer server
    }
  }

  /** Goes along the kept past: back by -1, forward by 1, or further. */
  move(steps: number, stamp: number): void {
    const { mesh, history } = this;
    if (mesh === undefined) return;
    for (let i = 0; i < Math.abs(steps); ++i) {
      const revision = steps < 0 ? history.back(mesh, stamp) : history.forward(mesh, stamp);
      if (revision === undefined) break;
      this.revision = revision;
    }
    this.hash = mesh.hash();
  }

  /** Drops parts of what a stream that has ended did not finish. */
  endOfStream(): void {
    this.#loading = undefined;
    this.#fragments = [];
  }

  /** Drops the mesh: the next watch takes a snapshot. */
  reset(): void {
    this.endOfStream();
    this.mesh = undefined;
    this.history.clear();
    this.revision = 0n;
    this.hash = '';
  }

  #takeChunk(chunk: SnapshotChunk): Change {
    if (chunk.index === 0) {
      const mesh = new SlotMesh(chunk.dimension);
      mesh.reserve({
        // Some more, so that the first diffs do not make the arrays grow.
        vertices: withSpare(chunk.vertexCount),
        simplices: withSpare(chunk.simplexCount),
        subsegments: withSpare(chunk.subsegmentCount),
        subfacets: withSpare(chunk.subfacetCount),
      });
      this.#loading = { mesh, next: 0, simplices: Number(chunk.simplexCount) };
    }
    const loading = this.#loading;
    if (loading?.next !== chunk.index) throw new DataLoss('a chunk of a snapshot is lost');
    ++loading.next;
    loading.mesh.apply([], [addedByChunk(chunk)], UNCHANGED);
    this.loaded = loading.mesh.cells.count / Math.max(1, loading.simplices);
    if (chunk.more) return 'nothing';
    this.#loading = undefined;
    this.history.clear();
    this.mesh = loading.mesh;
    this.revision = chunk.revision;
    this.#compare(chunk.hash);
    return 'snapshot';
  }

  #takeFragment(fragment: MeshDiff, stamp: number): Change {
    const { mesh } = this;
    if (mesh === undefined || fragment.fromRevision !== this.revision) {
      throw new DataLoss('a diff does not continue the mesh');
    }
    if (fragment.columnsOmitted) throw new DataLoss('a diff came without its columns');
    this.#fragments.push(fragment);
    if (fragment.more) return 'nothing';
    const fragments = this.#fragments;
    this.#fragments = [];
    const since = fragment.toRevision > this.openedAt ? stamp : UNCHANGED;
    const removed = fragments.map(removedBy);
    const added = fragments.map(addedBy);
    const gone = rowsOf(mesh, removed);
    mesh.apply(removed, added, since);
    this.history.push({
      from: fragment.fromRevision,
      to: fragment.toRevision,
      removed,
      added,
      gone,
    });
    this.revision = fragment.toRevision;
    ++this.diffs;
    this.#compare(fragment.hash);
    return 'diff';
  }

  #compare(hash: string): void {
    this.hash = this.mesh?.hash() ?? '';
    if (hash !== this.hash) {
      throw new DataLoss(`the server's mesh has the hash ${hash}, this copy ${this.hash}`);
    }
  }
}

function withSpare(count: bigint): number {
  return Math.ceil(Number(count) * 1.25) + 64;
}
