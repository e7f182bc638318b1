// Figures of all triangles or tetrahedra, for histograms. A survey takes some time for a large mesh, so
// it is made in slices between frames.
import type { SlotMesh } from './slot_mesh.js';

export const BINS = 24;
const DEGREES = 180 / Math.PI;

export interface Histogram {
  name: string;
  unit: string;
  /** Of the first bin's begin and the last bin's end. */
  range: readonly [number, number];
  bins: Uint32Array;
  least: number;
  most: number;
}

function histogram(name: string, unit: string, range: readonly [number, number]): Histogram {
  return { name, unit, range, bins: new Uint32Array(BINS), least: Infinity, most: -Infinity };
}

function count(into: Histogram, value: number): void {
  const [low, high] = into.range;
  const bin = Math.floor(((value - low) / (high - low)) * BINS);
  ++into.bins[Math.min(Math.max(bin, 0), BINS - 1)];
  if (value < into.least) into.least = value;
  if (value > into.most) into.most = value;
}

export class Survey {
  readonly histograms: Histogram[];
  readonly #angle: Histogram;
  readonly #quality: Histogram;
  #row = 0;

  /** `bound` is the mesh's quality. */
  constructor(
    private readonly mesh: SlotMesh,
    bound: number,
  ) {
    const isSpace = mesh.dimension === 3;
    this.#quality = histogram('circumradius / shortest edge', '', [isSpace ? 0.61 : 0.57, bound]);
    this.#angle = isSpace
      ? histogram('least dihedral angle', '°', [0, 72])
      : histogram('least angle', '°', [0, 60]);
    this.histograms = [this.#quality, this.#angle];
  }

  /** Goes on for some milliseconds; true when all rows were seen. */
  advance(milliseconds: number): boolean {
    const end = performance.now() + milliseconds;
    const { cells } = this.mesh;
    while (this.#row < cells.length) {
      const last = Math.min(this.#row + 2000, cells.length);
      for (; this.#row < last; ++this.#row) {
        if (!cells.isLive(this.#row)) continue;
        if (this.mesh.dimension === 3) this.#tetrahedron(this.#row);
        else this.#triangle(this.#row);
      }
      if (performance.now() > end) break;
    }
    return this.#row >= cells.length;
  }

  #triangle(row: number): void {
    const { corners } = this.mesh.cells;
    const { coordinates } = this.mesh.vertices;
    const a = 2 * corners[3 * row];
    const b = 2 * corners[3 * row + 1];
    const c = 2 * corners[3 * row + 2];
    const ux = coordinates[b] - coordinates[a];
    const uy = coordinates[b + 1] - coordinates[a + 1];
    const vx = coordinates[c] - coordinates[a];
    const vy = coordinates[c + 1] - coordinates[a + 1];
    const n = Math.sqrt(ux * ux + uy * uy);
    const m = Math.sqrt(vx * vx + vy * vy);
    const l = Math.sqrt((vx - ux) * (vx - ux) + (vy - uy) * (vy - uy));
    const area = ux * vy - uy * vx;
    const shortest = Math.min(l, m, n);
    count(this.#quality, (l * m * n) / (2 * area * shortest));
    count(this.#angle, Math.asin(Math.min(1, (area * shortest) / (l * m * n))) * DEGREES);
  }

  #tetrahedron(row: number): void {
    const { corners } = this.mesh.cells;
    const { coordinates } = this.mesh.vertices;
    const p = corners.subarray(4 * row, 4 * row + 4);
    for (let k = 0; k < 4; ++k) {
      for (let i = 0; i < 3; ++i)
        at[3 * k + i] = coordinates[3 * p[k] + i] - coordinates[3 * p[0] + i];
    }
    let shortest = Infinity;
    for (let k = 0; k < 4; ++k) {
      for (let j = k + 1; j < 4; ++j) shortest = Math.min(shortest, distance(k, j));
      normalOpposite(k);
    }
    let greatest = -1;
    for (let k = 0; k < 4; ++k) {
      for (let j = k + 1; j < 4; ++j) {
        // Normals point outwards: the dihedral angle is the rest to 180 degrees of theirs.
        const cosine = -(
          normals[3 * k] * normals[3 * j] +
          normals[3 * k + 1] * normals[3 * j + 1] +
          normals[3 * k + 2] * normals[3 * j + 2]
        );
        greatest = Math.max(greatest, cosine);
      }
    }
    count(this.#quality, circumradius() / shortest);
    count(this.#angle, Math.acos(Math.min(1, greatest)) * DEGREES);
  }
}

/** Corners of the tetrahedron at hand, from its first one; and unit normals of the facets opposite. */
const at = new Float64Array(12);
const normals = new Float64Array(12);
const FACETS = [
  [1, 2, 3],
  [0, 3, 2],
  [0, 1, 3],
  [0, 2, 1],
];

function distance(k: number, j: number): number {
  const [x, y, z] = [0, 1, 2].map((i) => at[3 * k + i] - at[3 * j + i]);
  return Math.sqrt(x * x + y * y + z * z);
}

function normalOpposite(k: number): void {
  const [a, b, c] = FACETS[k].map((corner) => 3 * corner);
  const [ux, uy, uz] = [at[b] - at[a], at[b + 1] - at[a + 1], at[b + 2] - at[a + 2]];
  const [vx, vy, vz] = [at[c] - at[a], at[c + 1] - at[a + 1], at[c + 2] - at[a + 2]];
  const x = uy * vz - uz * vy;
  const y = uz * vx - ux * vz;
  const z = ux * vy - uy * vx;
  const length = Math.sqrt(x * x + y * y + z * z);
  normals[3 * k] = x / length;
  normals[3 * k + 1] = y / length;
  normals[3 * k + 2] = z / length;
}

/** From the first corner, which is at the origin. */
function circumradius(): number {
  const [, , , bx, by, bz, cx, cy, cz, dx, dy, dz] = at;
  const b2 = bx * bx + by * by + bz * bz;
  const c2 = cx * cx + cy * cy + cz * cz;
  const d2 = dx * dx + dy * dy + dz * dz;
  const x = b2 * (cy * dz - cz * dy) + c2 * (dy * bz - dz * by) + d2 * (by * cz - bz * cy);
  const y = b2 * (cz * dx - cx * dz) + c2 * (dz * bx - dx * bz) + d2 * (bz * cx - bx * cz);
  const z = b2 * (cx * dy - cy * dx) + c2 * (dx * by - dy * bx) + d2 * (bx * cy - by * cx);
  const volume = bx * (cy * dz - cz * dy) + by * (cz * dx - cx * dz) + bz * (cx * dy - cy * dx);
  return Math.sqrt(x * x + y * y + z * z) / Math.abs(2 * volume);
}
