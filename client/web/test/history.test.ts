import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { WatchEventSchema, type WatchEvent } from '../gen/dynmesh/v1/mesh_service_pb.js';
import { MeshDiffSchema, SnapshotChunkSchema } from '../gen/dynmesh/v1/mesh_pb.js';
import type { Added, Removed } from '../src/model/difference.js';
import { History, rowsOf } from '../src/model/history.js';
import { Replica } from '../src/model/replica.js';
import { DataLoss, SlotMesh } from '../src/model/slot_mesh.js';

const none = new Uint32Array(0);
const nothing = { ids: none, owners: none };
const EMPTY_HASH = '0'.repeat(32);

function small(...ids: number[]): Uint32Array {
  return Uint32Array.from(ids.flatMap((id) => [id, 0]));
}

function added(vertices: number[], triangles: number[][], owner = 0): Added {
  return {
    vertices: {
      ids: small(...vertices),
      coordinates: Float64Array.from(vertices.flatMap((id) => [id, id * id])),
      containingDimensions: Uint8Array.from(vertices.map(() => 2)),
      owners: small(...vertices.map(() => owner)),
    },
    subsegments: nothing,
    subfacets: nothing,
    simplices: { ids: small(...triangles.flat()), regions: small(...triangles.map(() => 3)) },
  };
}

function removed(vertices: number[], triangles: number[][]): Removed {
  return {
    vertices: small(...vertices),
    subsegments: nothing,
    subfacets: nothing,
    simplices: { ids: small(...triangles.flat()), regions: small(...triangles.map(() => 3)) },
  };
}

test('steps are taken back and applied again, to the same hashes', () => {
  const mesh = new SlotMesh(2);
  const history = new History();
  const hashes = [mesh.hash()];
  const steps: [Removed, Added][] = [
    [
      removed([], []),
      added(
        [1, 2, 3, 4],
        [
          [1, 2, 3],
          [1, 3, 4],
        ],
      ),
    ],
    [removed([4], [[1, 3, 4]]), added([5], [[1, 3, 5]])],
    [removed([2], []), added([2], [], 9)],
    [
      removed(
        [1, 2, 3, 5],
        [
          [1, 2, 3],
          [1, 3, 5],
        ],
      ),
      added([], []),
    ],
  ];
  steps.forEach(([goes, comes], i) => {
    const gone = rowsOf(mesh, [goes]);
    mesh.apply([goes], [comes], 1);
    history.push({ from: BigInt(i), to: BigInt(i + 1), removed: [goes], added: [comes], gone });
    hashes.push(mesh.hash());
  });
  for (let round = 0; round < 2; ++round) {
    for (let i = 4; i > 0; --i) {
      expect(history.back(mesh, 1)).toBe(BigInt(i - 1));
      expect(mesh.hash()).toBe(hashes[i - 1]);
    }
    expect(history.back(mesh, 1)).toBeUndefined();
    for (let i = 1; i <= 4; ++i) {
      expect(history.forward(mesh, 1)).toBe(BigInt(i));
      expect(mesh.hash()).toBe(hashes[i]);
    }
    expect(history.forward(mesh, 1)).toBeUndefined();
  }
  // Another future than the one that was taken back.
  history.back(mesh, 1);
  history.push({ from: 3n, to: 7n, removed: [], added: [], gone: rowsOf(mesh, []) });
  expect([history.before, history.behind]).toEqual([4, 0]);
});

test('the oldest steps go when there are too many bytes', () => {
  const history = new History(10_000);
  const mesh = new SlotMesh(2);
  for (let i = 0n; i < 100n; ++i) {
    history.push({ from: i, to: i + 1n, removed: [], added: [], gone: rowsOf(mesh, []) });
  }
  expect(history.before).toBe(20);
});

function snapshot(revision: bigint, index: number, more: boolean): WatchEvent {
  const value = create(SnapshotChunkSchema, {
    dimension: 2,
    revision,
    index,
    more,
    hash: EMPTY_HASH,
  });
  return create(WatchEventSchema, { event: { case: 'snapshot', value } });
}

function diff(from: bigint, to: bigint, hash = EMPTY_HASH, more = false): WatchEvent {
  const value = create(MeshDiffSchema, {
    dimension: 2,
    fromRevision: from,
    toRevision: to,
    hash,
    more,
  });
  return create(WatchEventSchema, { event: { case: 'diff', value } });
}

test('a copy takes what continues it, and refuses a gap, a lost chunk and another hash', () => {
  const replica = new Replica();
  expect(() => replica.take(diff(0n, 1n), 1)).toThrow(DataLoss);
  expect(replica.take(snapshot(4n, 0, true), 1)).toBe('nothing');
  expect(() => replica.take(snapshot(4n, 2, false), 1)).toThrow(DataLoss);
  replica.endOfStream();
  expect(() => replica.take(snapshot(4n, 1, false), 1)).toThrow(DataLoss);
  replica.take(snapshot(4n, 0, true), 1);
  expect(replica.take(snapshot(4n, 1, false), 1)).toBe('snapshot');
  expect(replica.take(diff(4n, 6n, EMPTY_HASH, true), 1)).toBe('nothing');
  expect(replica.take(diff(4n, 6n), 1)).toBe('diff');
  expect(replica.revision).toBe(6n);
  expect(() => replica.take(diff(4n, 7n), 1)).toThrow(DataLoss);
  expect(() => replica.take(diff(6n, 7n, '1'.repeat(32)), 1)).toThrow(/hash/);
});
