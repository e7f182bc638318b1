import { expect, test } from 'vitest';
import type { Added, Removed } from '../src/model/difference.js';
import { DataLoss, SlotMesh } from '../src/model/slot_mesh.js';

const none = new Uint32Array(0);
const nothing = { ids: none, owners: none };

/** Words of small ids. */
function small(...ids: number[]): Uint32Array {
  return Uint32Array.from(ids.flatMap((id) => [id, 0]));
}

function added(vertices: number[], triangles: number[][], edges: number[][] = []): Added {
  return {
    vertices: {
      ids: small(...vertices),
      coordinates: Float64Array.from(vertices.flatMap((id) => [id, id * id])),
      containingDimensions: Uint8Array.from(vertices.map(() => 2)),
      owners: small(...vertices.map(() => 0)),
    },
    subsegments: { ids: small(...edges.flat()), owners: small(...edges.map(() => 9)) },
    subfacets: nothing,
    simplices: { ids: small(...triangles.flat()), regions: none },
  };
}

function removed(vertices: number[], triangles: number[][], edges: number[][] = []): Removed {
  return {
    vertices: small(...vertices),
    subsegments: { ids: small(...edges.flat()), owners: small(...edges.map(() => 9)) },
    subfacets: nothing,
    simplices: { ids: small(...triangles.flat()), regions: none },
  };
}

function idsOf(mesh: SlotMesh): number[][] {
  const { cells, vertices } = mesh;
  const result: number[][] = [];
  for (let row = 0; row < cells.length; ++row) {
    if (!cells.isLive(row)) continue;
    result.push([0, 1, 2].map((k) => vertices.words[2 * cells.corners[3 * row + k]]));
  }
  return result.sort((a, b) => a[0] - b[0] || a[1] - b[1] || a[2] - b[2]);
}

test('what stays keeps its slot, what comes takes the slots of what went', () => {
  const mesh = new SlotMesh(2);
  mesh.apply(
    [],
    [
      added(
        [1, 2, 3, 4],
        [
          [1, 2, 3],
          [2, 4, 3],
        ],
        [[1, 2]],
      ),
    ],
    7,
  );
  mesh.settle();
  const kept = mesh.cells.find(
    Int32Array.of(...[1, 2, 3].map((id) => mesh.vertices.find(id, 0))),
    0,
    0,
    0,
  );
  mesh.apply([removed([4], [[2, 4, 3]])], [added([5], [[2, 5, 3]])], 8);
  expect(idsOf(mesh)).toEqual([
    [1, 2, 3],
    [2, 5, 3],
  ]);
  expect(mesh.cells.stamps[kept]).toBe(7);
  expect(mesh.cells.changed.length).toBe(1);
  expect(mesh.cells.changed[0]).not.toBe(kept);
  expect(mesh.cells.stamps[mesh.cells.changed[0]]).toBe(8);
  expect(mesh.cells.length).toBe(2);
});

test('a vertex that changes its owner keeps its slot, and so do the triangles around it', () => {
  const mesh = new SlotMesh(2);
  mesh.apply([], [added([1, 2, 3], [[1, 2, 3]])], 0);
  const before = mesh.hash();
  const slot = mesh.vertices.find(2, 0);
  const owned = added([2], []);
  owned.vertices.owners[0] = 77;
  mesh.apply([removed([2], [])], [owned], 1);
  expect(mesh.vertices.find(2, 0)).toBe(slot);
  expect(mesh.vertices.owners[2 * slot]).toBe(77);
  expect(mesh.hash()).not.toBe(before);
  mesh.apply([removed([2], [])], [added([2], [])], 2);
  expect(mesh.hash()).toBe(before);
});

test('what does not fit is refused', () => {
  const mesh = new SlotMesh(2);
  mesh.apply([], [added([1, 2, 3], [[1, 2, 3]], [[1, 2]])], 0);
  expect(() => mesh.apply([removed([], [[3, 2, 1]])], [], 1)).toThrow(DataLoss);
  expect(() => mesh.apply([removed([4], [])], [], 1)).toThrow(DataLoss);
  expect(() => mesh.apply([], [added([], [[1, 2, 9]])], 1)).toThrow(DataLoss);
  expect(() => mesh.apply([], [added([1], [])], 1)).toThrow(DataLoss);
  expect(() => mesh.apply([removed([], [], [[2, 3]])], [], 1)).toThrow(DataLoss);
});

test('random diffs leave what a set would have, and the hash of a mesh built at once', () => {
  const seed = Number(process.env.DYNMESH_TEST_SEED ?? Date.now() % 1e6);
  console.log(`DYNMESH_TEST_SEED=${seed}`);
  let state = seed >>> 0;
  const random = (below: number): number => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
  const ids = Array.from({ length: 40 }, (_, i) => i + 1);
  const mesh = new SlotMesh(2);
  mesh.apply([], [added(ids, [])], 0);
  const model = new Map<string, number[]>();
  for (let step = 1; step <= 2000; ++step) {
    const goes = [...model.values()].filter(() => random(8) === 0);
    for (const triangle of goes) model.delete(triangle.join());
    const comes: number[][] = [];
    for (let i = random(12); i > 0; --i) {
      const triangle = [1 + random(40), 1 + random(40), 1 + random(40)];
      if (model.has(triangle.join())) continue;
      model.set(triangle.join(), triangle);
      comes.push(triangle);
    }
    mesh.apply([removed([], goes)], [added([], comes)], step);
    expect(mesh.cells.count).toBe(model.size);
  }
  const sorted = [...model.values()].sort((a, b) => a[0] - b[0] || a[1] - b[1] || a[2] - b[2]);
  expect(idsOf(mesh)).toEqual(sorted);
  const fresh = new SlotMesh(2);
  fresh.apply([], [added(ids, sorted)], 0);
  expect(mesh.hash()).toBe(fresh.hash());
});
