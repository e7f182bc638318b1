import { create } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import { MeshDiffSchema, SnapshotChunkSchema } from '../gen/dynmesh/v1/mesh_pb.js';
import { WatchEventSchema, type WatchEvent } from '../gen/dynmesh/v1/mesh_service_pb.js';
import { addedBy } from '../src/model/difference.js';
import { Replica } from '../src/model/replica.js';
import { SlotMesh } from '../src/model/slot_mesh.js';
import type { Service } from '../src/service/client.js';
import { Watch } from '../src/service/watch.js';

const hash = '0'.repeat(32);

function snapshot(): WatchEvent {
  const value = create(SnapshotChunkSchema, { dimension: 2, hash });
  return create(WatchEventSchema, { event: { case: 'snapshot', value } });
}

/** The first part of a diff, with all that it brings, and the last one. */
function parts(): WatchEvent[] {
  const both = { dimension: 2, toRevision: 1n };
  const first = create(MeshDiffSchema, {
    ...both,
    more: true,
    addedVertices: {
      ids: Uint8Array.from([7, 0, 0, 0, 0, 0, 0, 0]),
      coordinates: new Uint8Array(16),
      containingDimensions: Uint8Array.from([2]),
      owners: Uint8Array.from([0]),
    },
  });
  const mesh = new SlotMesh(2);
  mesh.apply([], [addedBy(first)], 1);
  const last = create(MeshDiffSchema, { ...both, hash: mesh.hash() });
  return [first, last].map((value) => create(WatchEventSchema, { event: { case: 'diff', value } }));
}

test('a run that was stopped leaves the parts alone that another one takes', async () => {
  const frames: (() => void)[] = [];
  vi.stubGlobal('requestAnimationFrame', (run: () => void) => frames.push(run));
  // Every event uses up its frame's time.
  let now = 0;
  vi.spyOn(performance, 'now').mockImplementation(() => (now += 100));
  const turn = () => new Promise((resolve) => setTimeout(resolve, 5));
  const states: string[] = [];
  const streams: WatchEvent[][] = [[snapshot(), ...parts()], parts()];
  const service = {
    async *watch(_: unknown, { signal }: { signal: AbortSignal }) {
      for (const event of streams.shift() ?? []) {
        await Promise.resolve();
        yield event;
      }
      if (signal.aborted) return;
      await new Promise((resolve) => signal.addEventListener('abort', resolve));
    },
  } as unknown as Service;
  const replica = new Replica();
  const watch = new Watch(
    service,
    'meshes/a',
    replica,
    {
      changed: () => undefined,
      connection: (state) => states.push(state),
      loading: () => undefined,
    },
    () => 1,
  );
  watch.start();
  await turn();
  frames.shift()?.(); // the snapshot was taken, and then a part of the diff
  await turn();
  watch.stop();
  watch.start();
  await turn(); // the other run has taken its first part
  expect(frames.length).toBe(2);
  frames.shift()?.(); // the old run goes on, and ends
  await turn();
  frames.shift()?.();
  await turn();
  expect(replica.revision).toBe(1n);
  expect(states).toEqual(['connecting', 'live', 'connecting', 'live']);
  watch.stop();
  await turn();
  frames.shift()?.();
  await turn();
  expect(states.at(-1)).toBe('asleep');
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
});
