// The mesh in slots: what lives keeps its row, and a diff costs as much as it changes. The hash of
// what is here is the server's after every diff, or something was lost.
import type { Added, Constraints, Removed, Simplices, VertexRows } from './difference.js';
import { HashSum } from './hash.js';
import { Rows } from './rows.js';
import { Vertices } from './vertices.js';

/** What was sent does not fit to the mesh. */
export class DataLoss extends Error {
  override readonly name = 'DataLoss';
}

export interface Totals {
  vertices: number;
  simplices: number;
  subsegments: number;
  subfacets: number;
}

export class SlotMesh {
  readonly vertices: Vertices;
  /** Triangles, in 3D tetrahedra. */
  readonly cells: Rows;
  readonly subsegments = new Rows(2, true);
  readonly subfacets = new Rows(3, true);

  readonly #hash = new HashSum();
  /** Vertices of a diff that went and have not come back. */
  readonly #gone = new Set<number>();
  #corners = new Int32Array(0);

  constructor(readonly dimension: number) {
    if (dimension !== 2 && dimension !== 3) throw new DataLoss('the mesh has no dimension');
    this.vertices = new Vertices(dimension);
    this.cells = new Rows(dimension + 1, false);
  }

  reserve(totals: Totals): void {
    this.vertices.reserve(totals.vertices);
    this.cells.reserve(totals.simplices);
    this.subsegments.reserve(totals.subsegments);
    this.subfacets.reserve(totals.subfacets);
  }

  hash(): string {
    return this.#hash.toHex();
  }

  /** Applies a diff, which may come in parts: all that goes, then all that comes. */
  apply(removed: readonly Removed[], added: readonly Added[], stamp: number): void {
    for (const part of removed) {
      this.#removeSimplices(part.simplices);
      this.#removeConstraints(this.subsegments, part.subsegments);
      this.#removeConstraints(this.subfacets, part.subfacets);
      this.#removeVertices(part.vertices);
    }
    for (const part of added) this.#addVertices(part.vertices);
    for (const part of added) {
      this.#addConstraints(this.subsegments, part.subsegments, stamp);
      this.#addConstraints(this.subfacets, part.subfacets, stamp);
      this.#addSimplices(part.simplices, stamp);
    }
    for (const slot of this.#gone) this.vertices.remove(slot);
    this.#gone.clear();
  }

  /** Forgets what has changed. */
  settle(): void {
    this.vertices.settle();
    this.cells.settle();
    this.subsegments.settle();
    this.subfacets.settle();
  }

  #removeSimplices({ ids, regions }: Simplices): void {
    const { cells } = this;
    const corners = this.#slotsOf(ids);
    const hasRegions = regions.length > 0;
    for (let row = 0; row < ids.length / (2 * cells.width); ++row) {
      const found = cells.find(corners, row * cells.width, 0, 0);
      if (found < 0) throw new DataLoss('a diff removes a simplex that is not there');
      const lo = hasRegions ? regions[2 * row] : 0;
      const hi = hasRegions ? regions[2 * row + 1] : 0;
      if (cells.tags[2 * found] !== lo || cells.tags[2 * found + 1] !== hi) {
        throw new DataLoss('a diff removes a simplex of another region');
      }
      this.#hash.simplex(-1, this.dimension, ids, row, lo, hi);
      cells.remove(found);
    }
  }

  #removeConstraints(rows: Rows, { ids, owners }: Constraints): void {
    const corners = this.#slotsOf(ids);
    for (let row = 0; row < owners.length / 2; ++row) {
      const at = row * rows.width;
      const found = rows.find(corners, at, owners[2 * row], owners[2 * row + 1]);
      if (found < 0) throw new DataLoss('a diff removes a constraint that is not there');
      this.#hash.constraint(-1, rows.width, ids, owners, row);
      rows.remove(found);
    }
  }

  #removeVertices(ids: Uint32Array): void {
    for (let i = 0; i < ids.length; i += 2) {
      const slot = this.vertices.find(ids[i], ids[i + 1]);
      if (slot < 0 || this.#gone.has(slot)) {
        throw new DataLoss('a diff removes a vertex that is not there');
      }
      this.#hashVertex(-1, slot);
      // A vertex that only changes its owner comes back, and simplices of it may stay.
      this.#gone.add(slot);
    }
  }

  #addVertices(rows: VertexRows): void {
    const { vertices, dimension } = this;
    for (let row = 0; row < rows.ids.length / 2; ++row) {
      const lo = rows.ids[2 * row];
      const hi = rows.ids[2 * row + 1];
      let slot = vertices.find(lo, hi);
      if (slot < 0) slot = vertices.add(lo, hi);
      else if (!this.#gone.delete(slot)) throw new DataLoss('a vertex comes twice');
      for (let k = 0; k < dimension; ++k) {
        vertices.coordinates[slot * dimension + k] = rows.coordinates[row * dimension + k];
      }
      vertices.containingDimensions[slot] = rows.containingDimensions[row];
      vertices.owners[2 * slot] = rows.owners[2 * row];
      vertices.owners[2 * slot + 1] = rows.owners[2 * row + 1];
      vertices.note(slot);
      this.#hashVertex(1, slot);
    }
  }

  #addConstraints(rows: Rows, { ids, owners }: Constraints, stamp: number): void {
    const corners = this.#slotsOf(ids);
    for (let row = 0; row < owners.length / 2; ++row) {
      rows.add(corners, row * rows.width, owners[2 * row], owners[2 * row + 1], stamp);
      this.#hash.constraint(1, rows.width, ids, owners, row);
    }
  }

  #addSimplices({ ids, regions }: Simplices, stamp: number): void {
    const { cells, dimension } = this;
    const corners = this.#slotsOf(ids);
    const hasRegions = regions.length > 0;
    for (let row = 0; row < ids.length / (2 * cells.width); ++row) {
      const lo = hasRegions ? regions[2 * row] : 0;
      const hi = hasRegions ? regions[2 * row + 1] : 0;
      cells.add(corners, row * cells.width, lo, hi, stamp);
      this.#hash.simplex(1, dimension, ids, row, lo, hi);
    }
  }

  #hashVertex(sign: 1 | -1, slot: number): void {
    const { coordinates, containingDimensions, owners } = this.vertices;
    this.#hash.vertex(sign, this.dimension, coordinates, containingDimensions, owners, slot);
  }

  /** The slots of these vertices; valid until the next call. */
  #slotsOf(ids: Uint32Array): Int32Array {
    const count = ids.length / 2;
    if (this.#corners.length < count) this.#corners = new Int32Array(2 * count);
    const corners = this.#corners;
    for (let i = 0; i < count; ++i) {
      const slot = this.vertices.find(ids[2 * i], ids[2 * i + 1]);
      if (slot < 0) throw new DataLoss('a simplex has a vertex that is not there');
      corners[i] = slot;
    }
    return corners;
  }
}
