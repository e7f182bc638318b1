import { expect, test } from 'vitest';
import { Cutter, type CutTriangles, type Patch } from '../src/cut/cutter.js';

function patch(coordinates: number[], corners: number[][], regions: number[]): Patch {
  return {
    slots: Int32Array.from({ length: coordinates.length / 3 }, (_, i) => i),
    coordinates: Float64Array.from(coordinates),
    rows: Int32Array.from(corners.keys()),
    corners: Int32Array.from(corners.flat()),
    regions: Uint8Array.from(regions),
  };
}

/** In the plane across z. */
function area({ positions }: CutTriangles): number {
  let sum = 0;
  for (let i = 0; i < positions.length; i += 9) {
    const [ax, ay, , bx, by, , cx, cy] = positions.subarray(i, i + 9);
    sum += Math.abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 2;
  }
  return sum;
}

// A cube in six tetrahedra around its diagonal.
const cube = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((i) => [i & 1, (i >> 1) & 1, i >> 2]);
const six = [
  [0, 1, 3, 7],
  [0, 3, 2, 7],
  [0, 2, 6, 7],
  [0, 6, 4, 7],
  [0, 4, 5, 7],
  [0, 5, 1, 7],
];

test('cuts of a cube cover its square, wherever they are', () => {
  const cutter = new Cutter();
  cutter.patch(patch(cube, six, [1, 2, 3, 4, 5, 6]));
  for (const offset of [0, 0.1, 0.37, 0.5, 0.9]) {
    const triangles = cutter.cut(2, offset, [0, 0, 0]);
    expect(area(triangles)).toBeCloseTo(1, 6);
    for (let i = 2; i < triangles.positions.length; i += 3) {
      expect(triangles.positions[i]).toBeCloseTo(offset, 6);
    }
  }
  expect(cutter.cut(2, 1.5, [0, 0, 0]).positions.length).toBe(0);
  expect(cutter.cut(2, 0.5, [0, 0, 0.5]).positions[2]).toBeCloseTo(0, 6);
});

test('a patch replaces rows, and frees them', () => {
  const cutter = new Cutter();
  cutter.patch(patch(cube, six, [1, 2, 3, 4, 5, 6]));
  const none = { slots: new Int32Array(0), coordinates: new Float64Array(0) };
  cutter.patch({
    ...none,
    rows: Int32Array.of(0, 1, 2),
    corners: new Int32Array(12).fill(-1),
    regions: new Uint8Array(3),
  });
  const { figures } = cutter.cut(2, 0.5, [0, 0, 0]);
  const regions = new Set(figures.filter((_, i) => i % 4 === 3));
  expect([...regions].sort()).toEqual([4, 5, 6]);
});
