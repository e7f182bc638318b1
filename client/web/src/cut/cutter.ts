// The cut of a 3D mesh by a plane across an axis: of each tetrahedron that it meets a triangle or a
// quadrilateral.
import { grown } from '../model/grown.js';
import { tetrahedronFigures, type TetrahedronFigures } from '../model/tetrahedron.js';

/** Rows that have changed, with what they are now. */
export interface Patch {
  slots: Int32Array;
  coordinates: Float64Array;
  rows: Int32Array;
  /** Four a row; -1: the row is free. */
  corners: Int32Array;
  /** The number of the region's colour, one a row. */
  regions: Uint8Array;
}

/** Triangles; columns have values for each of their corners. */
export interface CutTriangles {
  /** From the origin of the picture. */
  positions: Float32Array;
  /** Quality, least dihedral angle, log2 of the longest edge, number of the region. */
  figures: Float32Array;
  /** Distances from the edges, as barycentric coordinates; above 1 if there is no edge to draw. */
  edges: Float32Array;
}

const EDGES = [
  [0, 1],
  [0, 2],
  [0, 3],
  [1, 2],
  [1, 3],
  [2, 3],
] as const;

export class Cutter {
  #coordinates = new Float64Array(0);
  #corners = new Int32Array(0);
  #regions = new Uint8Array(0);
  #rows = 0;

  patch({ slots, coordinates, rows, corners, regions }: Patch): void {
    slots.forEach((slot, i) => {
      if (3 * slot + 3 > this.#coordinates.length) {
        this.#coordinates = grown(this.#coordinates, 6 * slot + 300);
      }
      this.#coordinates.set(coordinates.subarray(3 * i, 3 * i + 3), 3 * slot);
    });
    rows.forEach((row, i) => {
      if (row >= this.#regions.length) {
        this.#corners = grown(this.#corners, 8 * row + 400);
        this.#regions = grown(this.#regions, 2 * row + 100);
      }
      this.#corners.set(corners.subarray(4 * i, 4 * i + 4), 4 * row);
      this.#regions[row] = regions[i];
      this.#rows = Math.max(this.#rows, row + 1);
    });
  }

  /** By the plane where the coordinate of that axis (0 to 2) is `offset`. */
  cut(axis: number, offset: number, origin: readonly number[]): CutTriangles {
    // The mesh around the polygons would hide what is in them.
    const met = this.#rowsAt(axis, offset);
    const inside = met.filter((row) => this.#regions[row] !== 0);
    const found = inside.length > 0 ? inside : met;
    const result = {
      positions: new Float32Array(18 * found.length),
      figures: new Float32Array(24 * found.length),
      edges: new Float32Array(18 * found.length),
    };
    let corner = 0;
    const put = (place: readonly number[], edge: readonly number[]): void => {
      result.positions.set(place, 3 * corner);
      result.edges.set(edge, 3 * corner);
      result.figures.set(of, 4 * corner);
      ++corner;
    };
    const of = new Float32Array(4);
    const figures: TetrahedronFigures = { quality: 0, leastAngle: 0, longestEdge: 0 };
    for (const row of found) {
      const polygon = this.#polygonOf(row, axis, offset, origin);
      if (polygon.length < 3) continue;
      tetrahedronFigures(this.#coordinates, this.#corners, 4 * row, figures);
      of.set([
        figures.quality,
        figures.leastAngle,
        Math.log2(figures.longestEdge),
        this.#regions[row],
      ]);
      const isQuadrilateral = polygon.length === 4;
      put(polygon[0], [1, 0, 0]);
      put(polygon[1], [0, isQuadrilateral ? 2 : 1, 0]);
      put(polygon[2], [0, isQuadrilateral ? 1 : 0, 1]);
      if (!isQuadrilateral) continue;
      // The diagonal from 0 to 2 is no edge: the distance from it is never small.
      put(polygon[0], [1, 0, 1]);
      put(polygon[2], [0, 1, 1]);
      put(polygon[3], [0, 0, 2]);
    }
    return {
      positions: result.positions.subarray(0, 3 * corner),
      figures: result.figures.subarray(0, 4 * corner),
      edges: result.edges.subarray(0, 3 * corner),
    };
  }

  #rowsAt(axis: number, offset: number): number[] {
    const corners = this.#corners;
    const coordinates = this.#coordinates;
    const found: number[] = [];
    for (let row = 0; row < this.#rows; ++row) {
      if (corners[4 * row] < 0) continue;
      let above = 0;
      for (let k = 0; k < 4; ++k) {
        if (coordinates[3 * corners[4 * row + k] + axis] > offset) ++above;
      }
      if (above > 0 && above < 4) found.push(row);
    }
    return found;
  }

  /** In order around it. */
  #polygonOf(row: number, axis: number, offset: number, origin: readonly number[]): number[][] {
    const height = (corner: number): number =>
      this.#coordinates[3 * this.#corners[4 * row + corner] + axis] - offset;
    const isAbove = [0, 1, 2, 3].map((corner) => height(corner) > 0);
    const crossed = EDGES.filter(([p, q]) => isAbove[p] !== isAbove[q]);
    // Of four, the second and third are not opposite to each other: they share no corner.
    if (crossed.length === 4) {
      const opposite = crossed.findIndex(
        ([p, q]) => ![p, q].some((c) => crossed[0].includes(c as never)),
      );
      if (opposite !== 2) [crossed[2], crossed[opposite]] = [crossed[opposite], crossed[2]];
    }
    return crossed.map(([p, q]) => {
      const share = height(p) / (height(p) - height(q));
      const a = 3 * this.#corners[4 * row + p];
      const b = 3 * this.#corners[4 * row + q];
      return [0, 1, 2].map((i) => {
        const from = this.#coordinates[a + i];
        return from + share * (this.#coordinates[b + i] - from) - origin[i];
      });
    });
  }
}
