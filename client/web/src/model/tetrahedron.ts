// Figures of a tetrahedron.

export interface TetrahedronFigures {
  /** Circumradius / shortest edge. */
  quality: number;
  /** The least dihedral angle, in degrees. */
  leastAngle: number;
  longestEdge: number;
}

/** Of the tetrahedron whose corners stand at `first` and after, rows of `coordinates`. */
export function tetrahedronFigures(
  coordinates: Float64Array,
  corners: Int32Array,
  first: number,
  result: TetrahedronFigures,
): void {
  const origin = 3 * corners[first];
  for (let k = 0; k < 4; ++k) {
    const from = 3 * corners[first + k];
    for (let i = 0; i < 3; ++i) at[3 * k + i] = coordinates[from + i] - coordinates[origin + i];
  }
  let shortest = Infinity;
  let longest = 0;
  for (let k = 0; k < 4; ++k) {
    for (let j = k + 1; j < 4; ++j) {
      const length = distance(k, j);
      shortest = Math.min(shortest, length);
      longest = Math.max(longest, length);
    }
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
  result.quality = circumradius() / shortest;
  result.leastAngle = (Math.acos(Math.min(1, greatest)) * 180) / Math.PI;
  result.longestEdge = longest;
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
