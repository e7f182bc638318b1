import { create, toBinary } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { beforeEach, expect, test, vi } from 'vitest';
import { EditSchema, type Edit } from '../gen/dynmesh/v1/geometry_pb.js';
import { MeshDiffSchema, type MeshDiff } from '../gen/dynmesh/v1/mesh_pb.js';
import { ErrorInfoSchema } from '../gen/dynmesh/v1/status_details_pb.js';
import type { Service } from '../src/service/client.js';
import { Editor, joined, renamed, type EditInit } from '../src/service/editor.js';

function move(id: bigint, x: number): Edit {
  return create(EditSchema, { action: { case: 'move', value: { id, to: { x, y: 0 } } } });
}

function add(id: bigint): EditInit {
  const geometry = { case: 'point' as const, value: { x: 0, y: 0 } };
  return { action: { case: 'add', value: { id, geometry } } };
}

interface EditRequest {
  edits: Edit[];
  requestId: string;
}

interface RevertRequest {
  revision: bigint;
  expectedRevision: bigint;
}

/** A server that has the ids of the features at each revision. */
class FakeServer {
  readonly states: bigint[][] = [[]];
  readonly calls: string[] = [];
  /** Answers that get lost, before or after the batch was applied. */
  lose: ('before' | 'after')[] = [];
  readonly #answered = new Map<string, MeshDiff>();

  get present(): bigint[] {
    return this.states[this.states.length - 1];
  }

  /** An edit of another client. */
  add(id: bigint): void {
    this.#next([...this.present, id]);
  }

  service(): Service {
    return {
      applyEdits: (request: EditRequest) => this.#answer(() => this.#apply(request)),
      revertTo: (request: RevertRequest) => this.#answer(() => this.#revert(request)),
    } as unknown as Service;
  }

  async *#answer(make: () => MeshDiff): AsyncGenerator<MeshDiff> {
    await Promise.resolve();
    const lost = this.lose.shift();
    if (lost === 'before') throw new TypeError('network error');
    const diff = make();
    if (lost === 'after') throw new TypeError('network error');
    yield diff;
  }

  #apply({ edits, requestId }: EditRequest): MeshDiff {
    this.calls.push('edit');
    const answered = this.#answered.get(requestId);
    if (answered !== undefined) return answered;
    let ids = this.present;
    for (const { action } of edits) {
      if (action.case === 'remove') ids = ids.filter((id) => id !== action.value);
      if (action.case !== 'add') continue;
      const { id } = action.value;
      if (ids.includes(id)) throw inUse(id);
      ids = [...ids, id];
    }
    const diff = this.#next(ids);
    this.#answered.set(requestId, diff);
    return diff;
  }

  #revert({ revision, expectedRevision }: RevertRequest): MeshDiff {
    this.calls.push('revert');
    if (Number(expectedRevision) !== this.states.length - 1) {
      throw new ConnectError('the mesh is at another revision', Code.Aborted);
    }
    return this.#next(this.states[Number(revision)]);
  }

  #next(ids: bigint[]): MeshDiff {
    const fromRevision = BigInt(this.states.length - 1);
    this.states.push(ids);
    return create(MeshDiffSchema, { fromRevision, toRevision: fromRevision + 1n });
  }
}

function inUse(id: bigint): ConnectError {
  const info = create(ErrorInfoSchema, { reason: 'ID_IN_USE', metadata: { features: `${id}` } });
  const error = new ConnectError(`${id} is in use`, Code.AlreadyExists);
  error.details = [{ type: 'google.rpc.ErrorInfo', value: toBinary(ErrorInfoSchema, info) }];
  return error;
}

let server: FakeServer;
let editor: Editor;
let refusals: string[];
let names: bigint[][];

beforeEach(() => {
  vi.stubGlobal('requestAnimationFrame', (run: () => void) => setTimeout(run, 0));
  server = new FakeServer();
  refusals = [];
  names = [];
  editor = new Editor(server.service(), 'meshes/a', {
    applied: () => undefined,
    refused: ({ message }) => refusals.push(message),
    renamed: (from, to) => names.push([from, to]),
  });
});

/** Waits until the editor has nothing more to do. */
async function rest(): Promise<void> {
  for (let quiet = 0, calls = -1; quiet < 5; ++quiet) {
    if (calls !== server.calls.length) quiet = 0;
    calls = server.calls.length;
    await new Promise((resolve) => setTimeout(resolve, 1));
  }
}

async function press(...keys: ('undo' | 'redo')[]): Promise<void> {
  for (const key of keys) editor[key]();
  await rest();
}

test('of the moves of a point only the last is left', () => {
  const remove = create(EditSchema, { action: { case: 'remove', value: 9n } });
  let edits: Edit[] = [];
  for (const edit of [move(1n, 1), move(2n, 1), remove, move(1n, 2), move(1n, 3)]) {
    edits = joined(edits, edit);
  }
  expect(edits).toEqual([move(2n, 1), remove, move(1n, 3)]);
});

test('edits of this page are undone and done again, those of others are not', async () => {
  editor.apply(add(1n));
  await rest();
  server.add(99n);
  editor.apply(add(2n));
  await rest();
  await press('undo');
  expect(server.present).toEqual([1n, 99n]);
  expect(editor.canUndo).toBe(false);
  await press('undo');
  expect(server.present).toEqual([1n, 99n]);
  expect(refusals).toEqual([expect.stringMatching(/^Another client/)]);
  await press('redo');
  expect(server.present).toEqual([1n, 99n, 2n]);
});

test('an edit of another client, which is the last one, is not undone', async () => {
  editor.apply(add(1n));
  await rest();
  server.add(99n);
  await press('undo');
  expect(server.present).toEqual([1n, 99n]);
  expect(refusals).toEqual([expect.stringMatching(/^Another client/)]);
});

test('a gesture is undone at once, but not what came in between', async () => {
  editor.beginGesture();
  for (const id of [1n, 2n]) {
    editor.apply(add(id));
    await rest();
  }
  editor.endGesture();
  editor.apply(add(3n));
  await rest();
  await press('undo');
  expect(server.present).toEqual([1n, 2n]);
  await press('undo');
  expect(server.present).toEqual([]);

  editor.beginGesture();
  editor.apply(add(4n));
  await rest();
  server.add(99n);
  editor.apply(add(5n));
  await rest();
  editor.endGesture();
  await press('undo', 'undo', 'undo');
  expect(server.present).toEqual([4n, 99n]);
});

test('an undo within a gesture ends its change', async () => {
  editor.beginGesture();
  editor.apply(add(1n));
  await press('undo');
  editor.apply(add(2n));
  await rest();
  expect(server.present).toEqual([2n]);
  await press('undo');
  expect(server.present).toEqual([]);
  await press('redo', 'redo');
  expect(server.present).toEqual([2n]);
});

test('undo and redo wait for what is under way', async () => {
  editor.apply(add(1n));
  editor.undo();
  editor.apply(add(2n));
  editor.apply(add(3n));
  await rest();
  expect(server.present).toEqual([2n, 3n]);
  await press('undo', 'redo', 'undo');
  expect(server.present).toEqual([]);
  expect(refusals).toEqual([]);
});

test('an edit whose answer is lost is sent again, and applied once', async () => {
  server.lose = ['before', 'after'];
  editor.apply(add(1n));
  await vi.waitFor(() => expect(editor.canUndo).toBe(true), 5000);
  expect(server.states).toEqual([[], [1n]]);
  expect(server.calls).toEqual(['edit', 'edit']);
  await press('undo');
  expect(server.present).toEqual([]);
  expect(refusals).toEqual([]);
});

test('an edit that is never answered is said to be lost, and nothing before it is undone', async () => {
  vi.useFakeTimers();
  try {
    editor.apply(add(1n));
    await vi.advanceTimersByTimeAsync(100);
    server.lose = Array.from({ length: 20 }, () => 'before');
    editor.apply(add(2n));
    await vi.advanceTimersByTimeAsync(60_000);
    expect(refusals).toEqual(['TypeError: network error']);
    server.lose = [];
    editor.undo();
    await vi.advanceTimersByTimeAsync(100);
    expect(refusals[1]).toMatch(/^The answer to an edit is lost/);
    expect(server.present).toEqual([1n]);
  } finally {
    vi.useRealTimers();
  }
});

test('a feature whose id is taken gets another one, and so does what names it', async () => {
  server.add(7n);
  editor.apply(add(7n));
  editor.apply({ action: { case: 'remove', value: 7n } });
  editor.beginGesture();
  editor.apply(add(8n));
  await rest();
  expect(names).toEqual([[7n, expect.any(BigInt)]]);
  expect(server.present).toEqual([7n, 8n]);
  expect(refusals).toEqual([]);

  const ring = create(EditSchema, {
    action: {
      case: 'add',
      value: {
        id: 5n,
        geometry: { case: 'polygon', value: { rings: [{ points: [1n, 2n, 3n] }] } },
      },
    },
  });
  const other = renamed(renamed(ring, 2n, 20n), 5n, 50n).action.value;
  expect(other).toMatchObject({
    id: 50n,
    geometry: { value: { rings: [{ points: [1n, 20n, 3n] }] } },
  });
});

test('an editor that was closed sends and says nothing more', async () => {
  server.lose = ['before'];
  editor.apply(add(1n));
  editor.apply(add(2n));
  editor.close();
  await rest();
  expect(server.present).toEqual([]);
  expect(refusals).toEqual([]);
});
