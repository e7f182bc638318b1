// Edits of this page: one batch under way at a time. What comes meanwhile is joined into the next one,
// and of the moves of a point only the last is left, so that a drag is as fast as the server is.
import { create, fromBinary, type MessageInitShape } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { EditSchema, type Edit } from '../../gen/dynmesh/v1/geometry_pb.js';
import type { MeshDiff } from '../../gen/dynmesh/v1/mesh_pb.js';
import { ErrorInfoSchema } from '../../gen/dynmesh/v1/status_details_pb.js';
import type { Service } from './client.js';
import { messageOf } from './watch.js';

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
}

/** What undo and redo go between. */
interface Change {
  before: bigint;
  after: bigint;
}

interface Gesture {
  change?: Change;
}

export class Editor {
  #pending: Edit[] = [];
  #isBusy = false;
  readonly #done: Change[] = [];
  readonly #undone: Change[] = [];
  /** The revision that this page's last edit made; undo is only from there. */
  #last = -1n;
  /** While one gesture lasts, its batches are one change. */
  #gesture: Gesture | undefined;
  /** Of the pending edits. */
  #pendingGesture: Gesture | undefined;

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
    for (const init of edits) this.#pending = joined(this.#pending, create(EditSchema, init));
    this.#pendingGesture = this.#gesture;
    if (!this.#isBusy) void this.#send();
  }

  undo(): void {
    const change = this.#done.at(-1);
    if (change === undefined || this.#isBusy) return;
    void this.#revert(change.before, () => {
      this.#done.pop();
      this.#undone.push(change);
    });
  }

  redo(): void {
    const change = this.#undone.at(-1);
    if (change === undefined || this.#isBusy) return;
    void this.#revert(change.after, () => {
      this.#undone.pop();
      this.#done.push(change);
    });
  }

  async #send(): Promise<void> {
    this.#isBusy = true;
    while (this.#pending.length > 0) {
      const edits = this.#pending;
      this.#pending = [];
      const gesture = this.#pendingGesture;
      try {
        const change = await this.#answer(
          this.service.applyEdits({
            mesh: this.mesh,
            edits,
            omitColumns: true,
            requestId: newRequestId(),
          }),
        );
        this.#note(change, gesture);
      } catch (error) {
        this.listener.refused(refusalOf(error));
      }
      // One batch a frame at most.
      await new Promise((resolve) => requestAnimationFrame(resolve));
    }
    this.#isBusy = false;
  }

  async #revert(revision: bigint, done: () => void): Promise<void> {
    this.#isBusy = true;
    try {
      const { after } = await this.#answer(
        this.service.revertTo({
          mesh: this.mesh,
          revision,
          expectedRevision: this.#last,
          omitColumns: true,
          requestId: newRequestId(),
        }),
      );
      this.#last = after;
      done();
      this.listener.applied();
    } catch (error) {
      const refusal = refusalOf(error);
      if (ConnectError.from(error).code === Code.Aborted) {
        refusal.message = 'Another client has changed the mesh since: its changes would go, too.';
      }
      this.listener.refused(refusal);
    }
    this.#isBusy = false;
    if (this.#pending.length > 0) void this.#send();
  }

  async #answer(diffs: AsyncIterable<MeshDiff>): Promise<Change> {
    let change: Change = { before: 0n, after: 0n };
    for await (const { fromRevision, toRevision } of diffs) {
      change = { before: fromRevision, after: toRevision };
    }
    return change;
  }

  #note(change: Change, gesture: Gesture | undefined): void {
    this.#last = change.after;
    if (change.after === change.before) return;
    if (gesture?.change !== undefined) {
      gesture.change.after = change.after;
    } else {
      this.#done.push(change);
      if (gesture !== undefined) gesture.change = change;
    }
    this.#undone.length = 0;
    this.listener.applied();
  }
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
