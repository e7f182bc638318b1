import { expect, test } from 'vitest';
import { SlotMesh } from '../src/model/slot_mesh.js';
import { Survey } from '../src/model/survey.js';

const none = new Uint32Array(0);

function meshOf(dimension: number, coordinates: number[], cells: number[][]): SlotMesh {
  const count = coordinates.length / dimension;
  const ids = Array.from({ length: count }, (_, i) => i + 1);
  const words = (rows: number[]): Uint32Array => Uint32Array.from(rows.flatMap((id) => [id, 0]));
  const mesh = new SlotMesh(dimension);
  mesh.apply(
    [],
    [
      {
        vertices: {
          ids: words(ids),
          coordinates: Float64Array.from(coordinates),
          containingDimensions: new Uint8Array(count),
          owners: new Uint32Array(2 * count),
        },
        subsegments: { ids: none, owners: none },
        subfacets: { ids: none, owners: none },
        simplices: { ids: words(cells.flat()), regions: none },
      },
    ],
    0,
  );
  return mesh;
}

test('a regular tetrahedron and a corner of a cube have their figures', () => {
  const regular = [1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1];
  const corner = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1];
  for (const [places, quality, angle] of [
    [regular, Math.sqrt(6) / 4, Math.acos(1 / 3)],
    [corner, Math.sqrt(3) / 2, Math.acos(1 / Math.sqrt(3))],
  ] as const) {
    const survey = new Survey(meshOf(3, [...places], [[1, 2, 3, 4]]), 2);
    expect(survey.advance(1000)).toBe(true);
    const [q, a] = survey.histograms;
    expect(q.least).toBeCloseTo(quality, 12);
    expect(a.least).toBeCloseTo((angle * 180) / Math.PI, 9);
    expect([...q.bins].reduce((sum, bin) => sum + bin)).toBe(1);
  }
});

test('triangles are counted by quality and least angle', () => {
  const survey = new Survey(
    meshOf(
      2,
      [0, 0, 4, 0, 0, 3, 2, 2 * Math.sqrt(3)],
      [
        [1, 2, 3],
        [1, 2, 4],
      ],
    ),
    2,
  );
  expect(survey.advance(1000)).toBe(true);
  const [q, a] = survey.histograms;
  expect(q.least).toBeCloseTo(1 / Math.sqrt(3), 12);
  expect(q.most).toBeCloseTo(2.5 / 3, 12);
  expect(a.least).toBeCloseTo((Math.atan2(3, 4) * 180) / Math.PI, 9);
  expect(a.bins[23]).toBe(1);
});
