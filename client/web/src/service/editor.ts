// Edits of this page: one batch under way at a time. What comes meanwhile is joined into the next one,
// and of the moves of a point only the last is left, so that a drag is as fast as the server is. Undo
// and redo wait for their turn, too.
import { clone, create, fromBinary, type MessageInitShape } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { EditSchema, type Edit } from '../../gen/dynmesh/v1/geometry_pb.js';
import type { MeshDiff } from '../../gen/dynmesh/v1/mesh_pb.js';
import { ErrorInfoSchema } from '../../gen/dynmesh/v1/status_details_pb.js';
import { randomId } from '../model/ids.js';
import type { Service } from './client.js';
import { messageOf, Pauses, sleep } from './retry.js';

export type EditInit = MessageInitShape<typeof EditSchema>;

/** Why an edit was refused, and the features that the server names. */
export interface Refusal {
  message: string;
  reason: string;
  features: bigint[];
}

export interface EditorListener {
  applied(): void;
  refused(refusal: Refusal): void;
  /** A new feature has got another id: the server had the first one already. */
  renamed(from: bigint, to: bigint): void;
}

/** What undo and redo go between. */
interface Change {
  before: bigint;
  after: bigint;
}

interface Gesture {
  change?: Change;
}

/** What is to be done, in the order in which it was asked for. */
type Job =
  | { kind: 'edits'; edits: Edit[]; gesture: Gesture | undefined }
  | { kind: 'undo' }
  | { kind: 'redo' };

const FOREIGN = 'Another client has changed the mesh since: its changes would go, too.';
const LOST = 'The answer to an edit is lost: what came before it cannot be undone.';

/** Attempts to get an answer, some 17 seconds with the pauses between. */
const ATTEMPTS = 12;
/** Attempts to find an id that is free. */
const RENAMES = 3;

export class Editor {
  #jobs: Job[] = [];
  #isBusy = false;
  #isClosed = false;
  readonly #done: Change[] = [];
  readonly #undone: Change[] = [];
  /** The revision that this page's last edit made; undo is only from there. */
  #last = -1n;
  /** Why there is nothing to undo, if there was something. */
  #barrier = '';
  /** While one gesture lasts, its batches are one change. */
  #gesture: Gesture | undefined;

  constructor(
    private readonly service: Service,
    private readonly mesh: string,
    private readonly listener: EditorListener,
  ) {}

  get canUndo(): boolean {
    return this.#done.length > 0;
  }

  get canRedo(): boolean {
    return this.#undone.length > 0;
  }

  /** All edits up to `endGesture` are undone at once. */
  beginGesture(): void {
    this.#gesture = {};
  }

  endGesture(): void {
    this.#gesture = undefined;
  }

  apply(...edits: EditInit[]): void {
    const gesture = this.#gesture;
    let last = this.#jobs.at(-1);
    if (last?.kind !== 'edits' || last.gesture !== gesture) {
      last = { kind: 'edits', edits: [], gesture };
      this.#jobs.push(last);
    }
    for (const init of edits) last.edits = joined(last.edits, create(EditSchema, init));
    void this.#run();
  }

  undo(): void {
    this.#jobs.push({ kind: 'undo' });
    void this.#run();
  }

  redo(): void {
    this.#jobs.push({ kind: 'redo' });
    void this.#run();
  }

  /** Sends nothing more, and says nothing more. */
  close(): void {
    this.#isClosed = true;
    this.#jobs = [];
  }

  async #run(): Promise<void> {
    if (this.#isBusy) return;
    this.#isBusy = true;
    for (let job = this.#jobs.shift(); job !== undefined; job = this.#jobs.shift()) {
      if (job.kind === 'edits') await this.#send(job.edits, job.gesture);
      else await this.#revert(job.kind);
      // One batch a frame at most.
      if (this.#jobs.length > 0) await new Promise((resolve) => requestAnimationFrame(resolve));
    }
    this.#isBusy = false;
  }

  async #send(edits: Edit[], gesture: Gesture | undefined): Promise<void> {
    for (let renames = 0; ; ++renames) {
      const requestId = newRequestId();
      try {
        const { mesh } = this;
        const change = await this.#answer(() =>
          this.service.applyEdits({ mesh, edits, omitColumns: true, requestId }),
        );
        this.#note(change, gesture);
        if (!this.#isClosed) this.listener.applied();
        return;
      } catch (error) {
        const refusal = refusalOf(error);
        const taken = refusal.reason === 'ID_IN_USE' ? addedOf(edits, refusal.features) : undefined;
        if (taken === undefined || renames === RENAMES || this.#isClosed) {
          this.#refused(error, refusal);
          return;
        }
        edits = this.#rename(edits, taken);
      }
    }
  }

  /** Gives a new feature another id, here and in what waits. */
  #rename(edits: readonly Edit[], from: bigint): Edit[] {
    const to = randomId();
    for (const job of this.#jobs) {
      if (job.kind === 'edits') job.edits = job.edits.map((edit) => renamed(edit, from, to));
    }
    this.listener.renamed(from, to);
    return edits.map((edit) => renamed(edit, from, to));
  }

  async #revert(kind: 'undo' | 'redo'): Promise<void> {
    const [from, to] = kind === 'undo' ? [this.#done, this.#undone] : [this.#undone, this.#done];
    const change = from.at(-1);
    if (change === undefined) {
      if (this.#barrier !== '' && kind === 'undo') this.#say(this.#barrier);
      return;
    }
    const requestId = newRequestId();
    try {
      const { after } = await this.#answer(() =>
        this.service.revertTo({
          mesh: this.mesh,
          revision: kind === 'undo' ? change.before : change.after,
          expectedRevision: this.#last,
          omitColumns: true,
          requestId,
        }),
      );
      this.#last = after;
      from.pop();
      to.push(change);
      if (!this.#isClosed) this.listener.applied();
    } catch (error) {
      const refusal = refusalOf(error);
      if (ConnectError.from(error).code === Code.Aborted) refusal.message = FOREIGN;
      this.#refused(error, refusal);
    }
  }

  /** Sends a request until it is answered: the server applies it once. */
  async #answer(send: () => AsyncIterable<MeshDiff>): Promise<Change> {
    const pauses = new Pauses();
    for (let attempt = 1; ; ++attempt) {
      try {
        let change: Change | undefined;
        for await (const { fromRevision, toRevision } of send()) {
          change = { before: fromRevision, after: toRevision };
        }
        if (change !== undefined) return change;
        throw new ConnectError('the server has not answered', Code.Unavailable);
      } catch (error) {
        if (!mayBeLost(error) || attempt === ATTEMPTS || this.#isClosed) throw error;
        await sleep(pauses.next());
      }
    }
  }

  #refused(error: unknown, refusal: Refusal): void {
    // It may have been applied or not, and nothing that follows is known to be of this page alone.
    if (mayBeLost(error)) this.#forget(LOST);
    if (!this.#isClosed) this.listener.refused(refusal);
  }

  #note(change: Change, gesture: Gesture | undefined): void {
    // To go back past what others have changed would undo it.
    if (change.before !== this.#last && this.#last >= 0n) this.#forget(FOREIGN);
    this.#last = change.after;
    if (change.after === change.before) return;
    this.#undone.length = 0;
    const last = this.#done.at(-1);
    if (last !== undefined && gesture?.change === last) {
      last.after = change.after;
      return;
    }
    this.#done.push(change);
    if (gesture !== undefined) gesture.change = change;
  }

  #forget(why: string): void {
    if (this.#done.length > 0 || this.#undone.length > 0) this.#barrier = why;
    this.#done.length = this.#undone.length = 0;
  }

  #say(message: string): void {
    if (!this.#isClosed) this.listener.refused({ message, reason: '', features: [] });
  }
}

/** The request may have been applied: its answer is lost, or the server is away. */
function mayBeLost(error: unknown): boolean {
  return [Code.Unavailable, Code.Unknown, Code.Internal, Code.DeadlineExceeded].includes(
    ConnectError.from(error).code,
  );
}

/** The one of these ids that a new feature of the batch has. */
function addedOf(edits: readonly Edit[], ids: readonly bigint[]): bigint | undefined {
  return ids.find((id) => edits.some((e) => e.action.case === 'add' && e.action.value.id === id));
}

/** The edit with another id in the place of this one. */
export function renamed(edit: Edit, from: bigint, to: bigint): Edit {
  const result = clone(EditSchema, edit);
  const other = (id: bigint): bigint => (id === from ? to : id);
  const { action } = result;
  if (action.case === 'remove') action.value = other(action.value);
  else if (action.case !== undefined) action.value.id = other(action.value.id);
  if (action.case !== 'add' && action.case !== 'set') return result;
  const { geometry } = action.value;
  if (geometry.case === 'segment') {
    geometry.value.p = other(geometry.value.p);
    geometry.value.q = other(geometry.value.q);
  } else if (geometry.case === 'polygon') {
    for (const ring of geometry.value.rings) ring.points = ring.points.map(other);
  }
  return result;
}

/** A page that did not come from this machine or by TLS has no crypto.randomUUID. */
function newRequestId(): string {
  return Array.from(crypto.getRandomValues(new Uint32Array(4)), (part) => part.toString(36)).join(
    '-',
  );
}

/** The edits with one more; a move replaces the moves of the same point. */
export function joined(edits: readonly Edit[], edit: Edit): Edit[] {
  const { action } = edit;
  if (action.case !== 'move') return [...edits, edit];
  const { id } = action.value;
  const others = edits.filter((e) => e.action.case !== 'move' || e.action.value.id !== id);
  return [...others, edit];
}

export function refusalOf(error: unknown): Refusal {
  const message = messageOf(error);
  if (!(error instanceof ConnectError)) return { message, reason: '', features: [] };
  for (const detail of error.details) {
    // google.rpc.ErrorInfo, which status_details.proto has under another name.
    if (!('type' in detail) || !detail.type.endsWith('.ErrorInfo')) continue;
    if (!(detail.value instanceof Uint8Array)) continue;
    const { reason, metadata } = fromBinary(ErrorInfoSchema, detail.value);
    const named = 'features' in metadata ? metadata.features : '';
    return { message, reason, features: (named.match(/\d+/g) ?? []).map(BigInt) };
  }
  return { message, reason: '', features: [] };
}
