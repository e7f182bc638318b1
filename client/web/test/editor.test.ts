import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { EditSchema, type Edit } from '../gen/dynmesh/v1/geometry_pb.js';
import { joined } from '../src/service/editor.js';

function move(id: bigint, x: number): Edit {
  return create(EditSchema, { action: { case: 'move', value: { id, to: { x, y: 0 } } } });
}

test('of the moves of a point only the last is left', () => {
  const remove = create(EditSchema, { action: { case: 'remove', value: 9n } });
  let edits: Edit[] = [];
  for (const edit of [move(1n, 1), move(2n, 1), remove, move(1n, 2), move(1n, 3)]) {
    edits = joined(edits, edit);
  }
  expect(edits).toEqual([move(2n, 1), remove, move(1n, 3)]);
});
