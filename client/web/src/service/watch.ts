// One watch of a mesh, for as long as the page is seen. Diffs are taken as fast as frames come: what
// the page does not take the server joins, so a slow page gets fewer and larger diffs. After a lost
// connection the watch goes on at the revision that the page has.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { WatchRequestSchema } from '../../gen/dynmesh/v1/mesh_service_pb.js';
import type { Replica } from '../model/replica.js';
import { DataLoss } from '../model/slot_mesh.js';
import type { Service } from './client.js';
import { mayRetry, messageOf, Pauses } from './retry.js';

export type Connection = 'connecting' | 'live' | 'lost' | 'asleep' | 'ended';

export interface Listener {
  /** The mesh has changed; with `whole`, it is another object. */
  changed(whole: boolean): void;
  connection(state: Connection, reason: string): void;
  /** Part of a snapshot has come. */
  loading(share: number): void;
}

/** Time for events of one frame, of 16 ms that it has. */
const BUDGET_MS = 8;
/** The same while the first mesh comes: there is nothing to draw yet. */
const LOADING_BUDGET_MS = 60;

export class Watch {
  readonly #service: Service;
  readonly #mesh: string;
  readonly #replica: Replica;
  readonly #listener: Listener;
  readonly #stamp: () => number;
  /** JavaScript time of the last event. */
  takeMs = 0;
  #call: AbortController | undefined;
  #isWanted = false;
  /** Ends the wait before the next attempt. */
  #wake: (() => void) | undefined;

  constructor(
    service: Service,
    mesh: string,
    replica: Replica,
    listener: Listener,
    stamp: () => number,
  ) {
    this.#service = service;
    this.#mesh = mesh;
    this.#replica = replica;
    this.#listener = listener;
    this.#stamp = stamp;
  }

  /** Watches until `stop`. */
  start(): void {
    if (this.#isWanted) return;
    this.#isWanted = true;
    void this.#run();
  }

  stop(): void {
    this.#isWanted = false;
    this.#call?.abort();
    this.#wake?.();
  }

  async #run(): Promise<void> {
    const call = new AbortController();
    this.#call = call;
    // Parts that a run before has left: it may still wait for a frame, and takes nothing any more.
    this.#replica.endOfStream();
    const pauses = new Pauses();
    while (!call.signal.aborted) {
      this.#listener.connection('connecting', '');
      const before = this.#replica.revision;
      const diffs = this.#replica.diffs;
      try {
        await this.#read(call.signal);
      } catch (error) {
        if (isOver(call)) break;
        if (!this.#mayGoOn(error)) {
          this.#isWanted = false;
          this.#listener.connection('ended', messageOf(error));
          return;
        }
        this.#listener.connection('lost', messageOf(error));
      }
      if (isOver(call)) break;
      this.#replica.endOfStream();
      if (this.#replica.diffs !== diffs || this.#replica.revision !== before) pauses.reset();
      await this.#wait(pauses.next(), call.signal);
    }
    if (!this.#isLast(call)) return;
    this.#replica.endOfStream();
    this.#listener.connection('asleep', '');
  }

  /** No other run has begun. */
  #isLast(call: AbortController): boolean {
    return this.#call === call;
  }

  /** One call, until it ends. */
  async #read(signal: AbortSignal): Promise<void> {
    const request = create(WatchRequestSchema, { mesh: this.#mesh });
    if (this.#replica.mesh !== undefined) {
      request.startRevision = this.#replica.revision;
      request.startHash = this.#replica.hash;
    }
    const budget = (): number => (this.#replica.mesh === undefined ? LOADING_BUDGET_MS : BUDGET_MS);
    let deadline = 0;
    for await (const event of this.#service.watch(request, { signal })) {
      if (signal.aborted) return;
      if (deadline === 0) {
        this.#listener.connection('live', '');
        deadline = performance.now() + budget();
      }
      const begin = performance.now();
      const change = this.#replica.take(event, this.#stamp());
      this.takeMs = performance.now() - begin;
      if (event.event.case === 'snapshot') this.#listener.loading(this.#replica.loaded);
      if (change !== 'nothing') this.#listener.changed(change === 'snapshot');
      if (performance.now() < deadline) continue;
      // The page draws, and what comes meanwhile waits at the server.
      await nextFrame();
      deadline = performance.now() + budget();
    }
  }

  #mayGoOn(error: unknown): boolean {
    if (error instanceof DataLoss || error instanceof RangeError) {
      this.#replica.reset();
      return true;
    }
    // The server no longer has what lies between, or has another past.
    if (ConnectError.from(error).code === Code.OutOfRange) this.#replica.reset();
    return mayRetry(error);
  }

  async #wait(milliseconds: number, signal: AbortSignal): Promise<void> {
    if (signal.aborted) return;
    await new Promise<void>((resolve) => {
      this.#wake = resolve;
      setTimeout(resolve, milliseconds);
    });
  }
}

function isOver(call: AbortController): boolean {
  return call.signal.aborted;
}

function nextFrame(): Promise<void> {
  return new Promise((resolve) => requestAnimationFrame(() => resolve()));
}
