import { create } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import { MeshDiffSchema, SnapshotChunkSchema } from '../gen/dynmesh/v1/mesh_pb.js';
import { WatchEventSchema, type WatchEvent } from '../gen/dynmesh/v1/mesh_service_pb.js';
import { Replica } from '../src/model/replica.js';
import type { Service } from '../src/service/client.js';
import { Watch } from '../src/service/watch.js';

const hash = '0'.repeat(32);

function snapshot(): WatchEvent {
  const value = create(SnapshotChunkSchema, { dimension: 2, hash });
  return create(WatchEventSchema, { event: { case: 'snapshot', value } });
}

function diff(from: bigint, to: bigint, more: boolean): WatchEvent {
  const value = create(MeshDiffSchema, {
    dimension: 2,
    fromRevision: from,
    toRevision: to,
    hash,
    more,
  });
  return create(WatchEventSchema, { event: { case: 'diff', value } });
}

test('a run that was stopped leaves the parts alone that another one takes', async () => {
  const frames: (() => void)[] = [];
  vi.stubGlobal('requestAnimationFrame', (run: () => void) => frames.push(run));
  // Every event uses up its frame's time.
  let now = 0;
  vi.spyOn(performance, 'now').mockImplementation(() => (now += 100));
  const turn = () => new Promise((resolve) => setTimeout(resolve, 5));
  const states: string[] = [];
  const streams: WatchEvent[][] = [
    [snapshot(), diff(0n, 1n, true), diff(0n, 1n, false)],
    [diff(0n, 1n, true), diff(0n, 1n, false)],
  ];
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
