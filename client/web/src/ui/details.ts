// What is at a place, in words.
import { wordAt } from '../model/columns.js';
import { triangleFigures } from '../model/figures.js';
import type { SlotMesh } from '../model/slot_mesh.js';
import { count, short } from './dom.js';

const BORDER = 2n ** 64n - 1n;
const DEGREES = 180 / Math.PI;

/** Names and values of a triangle of a 2D mesh. */
export function triangleDetails(mesh: SlotMesh, row: number): [string, string][] {
  const { cells, vertices } = mesh;
  if (row < 0 || !cells.isLive(row)) return [];
  const corners = [0, 1, 2].map((k) => cells.corners[3 * row + k]);
  const [a, b, c] = corners;
  const figures = triangleFigures(vertices.coordinates, 2, a, b, c);
  const region = wordAt(cells.tags, row);
  return [
    [
      'region',
      region === 0n ? 'none' : region < 2n ** 63n ? `polygon ${region}` : 'several polygons',
    ],
    ['quality', short(figures.quality)],
    ['angles', [angleAt(mesh, a, b, c), angleAt(mesh, b, c, a), angleAt(mesh, c, a, b)].join(' ')],
    ['longest edge', short(figures.longestEdge)],
    ['area', short(figures.area)],
    ...corners.map((slot, k): [string, string] => [
      `corner ${k + 1}`,
      `${vertices.coordinates[2 * slot]}, ${vertices.coordinates[2 * slot + 1]} · ${ownerOf(mesh, slot)} · ${idOf(mesh, slot)}`,
    ]),
  ];
}

/** The mesh's size. */
export function meshDetails(mesh: SlotMesh): [string, string][] {
  const rows: [string, string][] = [
    ['vertices', count(mesh.vertices.count)],
    [mesh.dimension === 3 ? 'tetrahedra' : 'triangles', count(mesh.cells.count)],
    ['subsegments', count(mesh.subsegments.count)],
  ];
  if (mesh.dimension === 3) rows.push(['subfacets', count(mesh.subfacets.count)]);
  return rows;
}

function angleAt(mesh: SlotMesh, a: number, b: number, c: number): string {
  const { coordinates } = mesh.vertices;
  const [px, py] = [
    coordinates[2 * b] - coordinates[2 * a],
    coordinates[2 * b + 1] - coordinates[2 * a + 1],
  ];
  const [qx, qy] = [
    coordinates[2 * c] - coordinates[2 * a],
    coordinates[2 * c + 1] - coordinates[2 * a + 1],
  ];
  return `${(Math.atan2(px * qy - py * qx, px * qx + py * qy) * DEGREES).toFixed(2)}°`;
}

function ownerOf(mesh: SlotMesh, slot: number): string {
  const owner = wordAt(mesh.vertices.owners, slot);
  if (owner === 0n) return 'free';
  if (owner === BORDER) return 'border';
  return mesh.vertices.containingDimensions[slot] === 0 ? `point ${owner}` : `on ${owner}`;
}

function idOf(mesh: SlotMesh, slot: number): string {
  return wordAt(mesh.vertices.words, slot).toString(16).padStart(16, '0');
}
