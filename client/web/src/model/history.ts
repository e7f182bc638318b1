// The past that the page keeps: diffs that it has applied, with what they removed, so that they can be
// taken back and applied again. The oldest go when there are too many of them, or too many bytes.
import type { Added, Removed, VertexRows } from './difference.js';
import type { SlotMesh } from './slot_mesh.js';

export interface Step {
  from: bigint;
  to: bigint;
  removed: readonly Removed[];
  added: readonly Added[];
  /** The rows of the removed vertices. */
  gone: VertexRows;
}

export class History {
  readonly #steps: Step[] = [];
  #bytes = 0;
  /** Steps that are applied; those behind them were taken back. */
  #applied = 0;

  constructor(
    private readonly mostBytes = 32 << 20,
    private readonly mostSteps = 1000,
  ) {}

  /** Steps that can be taken back. */
  get before(): number {
    return this.#applied;
  }

  /** Steps that can be applied again. */
  get behind(): number {
    return this.#steps.length - this.#applied;
  }

  /** Adds a step after the last applied one. Those behind it are another future: they go. */
  push(step: Step): void {
    for (const lost of this.#steps.splice(this.#applied)) this.#bytes -= bytesOf(lost);
    this.#steps.push(step);
    this.#applied = this.#steps.length;
    this.#bytes += bytesOf(step);
    while (
      (this.#bytes > this.mostBytes || this.#steps.length > this.mostSteps) &&
      this.#steps.length > 1
    ) {
      const oldest = this.#steps.shift();
      if (oldest) this.#bytes -= bytesOf(oldest);
      --this.#applied;
    }
  }

  clear(): void {
    this.#steps.length = 0;
    this.#applied = 0;
    this.#bytes = 0;
  }

  /** Takes the last applied step back; the revision before it, undefined if there is none. */
  back(mesh: SlotMesh, stamp: number): bigint | undefined {
    if (this.#applied === 0) return undefined;
    const step = this.#steps[--this.#applied];
    mesh.apply(...inverse(step), stamp);
    return step.from;
  }

  /** Applies the next step again; the revision after it, undefined if there is none. */
  forward(mesh: SlotMesh, stamp: number): bigint | undefined {
    if (this.behind === 0) return undefined;
    const step = this.#steps[this.#applied++];
    mesh.apply(step.removed, step.added, stamp);
    return step.to;
  }
}

/** The rows of the vertices that a diff removes, before it does. */
export function rowsOf(mesh: SlotMesh, removed: readonly Removed[]): VertexRows {
  const { vertices, dimension } = mesh;
  const count = removed.reduce((sum, part) => sum + part.vertices.length / 2, 0);
  const rows: VertexRows = {
    ids: new Uint32Array(2 * count),
    coordinates: new Float64Array(dimension * count),
    containingDimensions: new Uint8Array(count),
    owners: new Uint32Array(2 * count),
  };
  let row = 0;
  for (const part of removed) {
    for (let i = 0; i < part.vertices.length; i += 2, ++row) {
      const slot = vertices.find(part.vertices[i], part.vertices[i + 1]);
      if (slot < 0) continue; // `apply` will refuse the diff
      rows.ids.set(part.vertices.subarray(i, i + 2), 2 * row);
      const from = slot * dimension;
      rows.coordinates.set(vertices.coordinates.subarray(from, from + dimension), row * dimension);
      rows.containingDimensions[row] = vertices.containingDimensions[slot];
      rows.owners.set(vertices.owners.subarray(2 * slot, 2 * slot + 2), 2 * row);
    }
  }
  return rows;
}

const none = new Uint32Array(0);
const noVertices: VertexRows = {
  ids: none,
  coordinates: new Float64Array(0),
  containingDimensions: new Uint8Array(0),
  owners: none,
};

function inverse({ removed, added, gone }: Step): [Removed[], Added[]] {
  return [
    added.map(({ vertices, subsegments, subfacets, simplices }) => ({
      vertices: vertices.ids,
      subsegments,
      subfacets,
      simplices,
    })),
    [
      {
        vertices: gone,
        subsegments: { ids: none, owners: none },
        subfacets: { ids: none, owners: none },
        simplices: { ids: none, regions: none },
      },
      ...removed.map(({ subsegments, subfacets, simplices }) => ({
        vertices: noVertices,
        subsegments,
        subfacets,
        simplices,
      })),
    ],
  ];
}

/** Memory that a step keeps. */
export function bytesOf({ removed, added, gone }: Step): number {
  const size = (columns: object): number =>
    Object.values(columns).reduce<number>(
      (sum, column: ArrayBufferView) => sum + column.byteLength,
      0,
    );
  let bytes = 500 + size(gone);
  for (const part of removed) {
    bytes += size(part.simplices) + size(part.subsegments) + size(part.subfacets);
    bytes += part.vertices.byteLength;
  }
  for (const part of added) {
    bytes += size(part.simplices) + size(part.subsegments) + size(part.subfacets);
    bytes += size(part.vertices);
  }
  return bytes;
}
