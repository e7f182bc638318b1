import { expect, test } from 'vitest';
import { HashSum } from '../src/model/hash.js';

function idWords(...ids: string[]): Uint32Array {
  return Uint32Array.from(
    ids.flatMap((id) => [parseInt(id.slice(8), 16), parseInt(id.slice(0, 8), 16)]),
  );
}

function small(...numbers: number[]): Uint32Array {
  return Uint32Array.from(numbers.flatMap((number) => [number, 0]));
}

// The two examples of proto/dynmesh/v1/mesh.proto.

test('the mesh of the contract in 2D has its hash', () => {
  const [a, b, c, d] = [
    '85f1b8a8f4424aec',
    '0c5d0380e075fca5',
    '21f15be1b53f8c5d',
    '2de6ea44ea8504cf',
  ];
  const sum = new HashSum();
  const coordinates = Float64Array.of(0, 0, 1, 0, 0, 1, 0.5, -0);
  for (let row = 0; row < 4; ++row) {
    sum.vertex(1, 2, coordinates, Uint8Array.of(0, 0, 0, 1), small(1, 2, 3, 4), row);
  }
  const triangles = idWords(c, a, d, b, c, d);
  sum.simplex(1, 2, triangles, 0, 0x16f31dce, 0xf889be95);
  sum.simplex(1, 2, triangles, 1, 7, 0);
  const ends = idWords(d, a, b, d);
  for (const row of [0, 1]) sum.constraint(1, 2, ends, small(4, 4), row);
  expect(sum.toHex()).toBe('5ad29ad96e559f27c02d86611221fbc6');

  // What is added and subtracted leaves the sum as it was, whatever it carries.
  for (let i = 0; i < 1000; ++i) {
    const row = idWords(a, b, c).map((half) => half ^ Math.imul(i, 0x9e3779b1));
    sum.simplex(1, 2, row, 0, i, i);
    sum.simplex(-1, 2, row, 0, i, i);
  }
  expect(sum.toHex()).toBe('5ad29ad96e559f27c02d86611221fbc6');
});

test('the mesh of the contract in 3D has its hash', () => {
  const a = '5324d289463fc3c8';
  const b = 'e83426687ff6b57c';
  const c = 'e42b560f90f3a2c1';
  const d = 'f27884b062cede64';
  const e = 'c65e708b60c8584a';
  const sum = new HashSum();
  const coordinates = Float64Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.25, 0.25, -1.5);
  for (let row = 0; row < 5; ++row) {
    sum.vertex(1, 3, coordinates, Uint8Array.of(0, 0, 0, 0, 3), small(1, 2, 3, 4, 0), row);
  }
  const tetrahedra = idWords(a, c, d, b, a, e, c, b);
  sum.simplex(1, 3, tetrahedra, 0, 20, 0);
  sum.simplex(1, 3, tetrahedra, 1, 0, 0);
  const ends = idWords(a, c, a, b, c, b);
  for (const row of [0, 1, 2]) sum.constraint(1, 2, ends, small(20, 20, 20), row);
  sum.constraint(1, 3, idWords(a, c, b), small(20), 0);
  expect(sum.toHex()).toBe('1d85220eb926333326933084c857d4e2');
});
