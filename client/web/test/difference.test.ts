import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { MeshDiffSchema } from '../gen/dynmesh/v1/mesh_pb.js';
import { addedBy, removedBy } from '../src/model/difference.js';
import { bytesOf, rowsOf } from '../src/model/history.js';
import { SlotMesh } from '../src/model/slot_mesh.js';

test('columns keep nothing of the message, and a step counts all of them', () => {
  // As protobuf-es reads fields of bytes: views into the message.
  const message = new Uint8Array(1_000_000);
  const diff = create(MeshDiffSchema, {
    dimension: 2,
    addedVertices: {
      ids: message.subarray(0, 16),
      coordinates: message.subarray(16, 48),
      containingDimensions: message.subarray(48, 50),
      owners: message.subarray(50, 52),
    },
    removedVertices: message.subarray(100, 900),
  });
  const added = addedBy(diff);
  const removed = removedBy(diff);
  const { ids, coordinates, containingDimensions, owners } = added.vertices;
  for (const column of [ids, coordinates, containingDimensions, owners, removed.vertices]) {
    expect(column.buffer.byteLength).toBe(column.byteLength);
  }
  const gone = rowsOf(new SlotMesh(2), []);
  const step = { from: 0n, to: 1n, removed: [removed], added: [added], gone };
  const empty = { ...step, removed: [], added: [] };
  expect(bytesOf(step) - bytesOf(empty)).toBe(800 + 16 + 32 + 2 + 16);
});
