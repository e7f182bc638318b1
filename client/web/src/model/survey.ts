// Figures of all triangles or tetrahedra, for histograms. A survey takes some time for a large mesh, so
// it is made in slices between frames.
import type { SlotMesh } from './slot_mesh.js';
import { tetrahedronFigures, type TetrahedronFigures } from './tetrahedron.js';

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
    tetrahedronFigures(this.mesh.vertices.coordinates, corners, 4 * row, figures);
    count(this.#quality, figures.quality);
    count(this.#angle, figures.leastAngle);
  }
}

const figures: TetrahedronFigures = { quality: 0, leastAngle: 0, longestEdge: 0 };
