// The triangle at a place. The last answer is asked first: a pointer mostly stays in it. Else all
// triangles are: some milliseconds for a million, when the pointer moves, and nothing when the mesh
// changes.
import type { SlotMesh } from './slot_mesh.js';

/** The row of a triangle of a 2D mesh that contains the place; -1 if there is none. */
export function triangleAt(mesh: SlotMesh, x: number, y: number, guess: number): number {
  const { corners, length } = mesh.cells;
  const { coordinates } = mesh.vertices;
  if (guess >= 0 && guess < length && contains(corners, coordinates, guess, x, y)) return guess;
  for (let row = 0; row < length; ++row) {
    if (contains(corners, coordinates, row, x, y)) return row;
  }
  return -1;
}

function contains(
  corners: Int32Array,
  coordinates: Float64Array,
  row: number,
  x: number,
  y: number,
): boolean {
  const a = 2 * corners[3 * row];
  if (a < 0) return false;
  const b = 2 * corners[3 * row + 1];
  const ax = coordinates[a] - x;
  const ay = coordinates[a + 1] - y;
  const bx = coordinates[b] - x;
  const by = coordinates[b + 1] - y;
  if (ax * by < ay * bx) return false;
  const c = 2 * corners[3 * row + 2];
  const cx = coordinates[c] - x;
  const cy = coordinates[c + 1] - y;
  return bx * cy >= by * cx && cx * ay >= cy * ax;
}

/** The slot of the vertex of that triangle that is nearest to the place. */
export function nearestCorner(mesh: SlotMesh, row: number, x: number, y: number): number {
  const { corners } = mesh.cells;
  const { coordinates } = mesh.vertices;
  let best = -1;
  let least = Infinity;
  for (let k = 0; k < 3; ++k) {
    const slot = corners[3 * row + k];
    const distance = Math.hypot(coordinates[2 * slot] - x, coordinates[2 * slot + 1] - y);
    if (distance >= least) continue;
    least = distance;
    best = slot;
  }
  return best;
}

const RESERVED = 0xffffffff;

/** The slot of the input point of a 2D mesh that is nearest to the place, within `radius`; or -1. */
export function inputPointAt(mesh: SlotMesh, x: number, y: number, radius: number): number {
  const { coordinates, containingDimensions, isLive, owners, length } = mesh.vertices;
  let best = -1;
  let least = radius;
  for (let slot = 0; slot < length; ++slot) {
    if (containingDimensions[slot] !== 0 || isLive[slot] === 0) continue;
    if (owners[2 * slot + 1] === RESERVED) continue; // the border
    const distance = Math.hypot(coordinates[2 * slot] - x, coordinates[2 * slot + 1] - y);
    if (distance > least) continue;
    least = distance;
    best = slot;
  }
  return best;
}

/** Places of a feature of a 2D mesh: its vertices and the ends of its subsegments, some at most. */
export function placesOf(mesh: SlotMesh, id: bigint, most: number): { x: number; y: number }[] {
  const lo = Number(id & 0xffffffffn);
  const hi = Number(id >> 32n);
  const { coordinates, owners, isLive, length } = mesh.vertices;
  const slots = new Set<number>();
  for (let slot = 0; slot < length && slots.size < most; ++slot) {
    if (isLive[slot] !== 0 && owners[2 * slot] === lo && owners[2 * slot + 1] === hi) {
      slots.add(slot);
    }
  }
  const { corners, tags, length: rows } = mesh.subsegments;
  for (let row = 0; row < rows && slots.size < most; ++row) {
    if (corners[2 * row] < 0 || tags[2 * row] !== lo || tags[2 * row + 1] !== hi) continue;
    slots.add(corners[2 * row]).add(corners[2 * row + 1]);
  }
  return [...slots].map((slot) => ({ x: coordinates[2 * slot], y: coordinates[2 * slot + 1] }));
}
