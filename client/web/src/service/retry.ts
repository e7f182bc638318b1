// When a call is made again, and after what time.
import { Code, ConnectError } from '@connectrpc/connect';

const SHORTEST_PAUSE_MS = 100;
const LONGEST_PAUSE_MS = 2000;

/** Pauses between attempts, each twice as long as the one before. */
export class Pauses {
  #pause = SHORTEST_PAUSE_MS;

  next(): number {
    const pause = this.#pause;
    this.#pause = Math.min(2 * pause, LONGEST_PAUSE_MS);
    return pause;
  }

  /** An attempt was successful. */
  reset(): void {
    this.#pause = SHORTEST_PAUSE_MS;
  }
}

/** A read that failed like this may succeed later. */
export function mayRetry(error: unknown): boolean {
  return ![
    Code.NotFound,
    Code.Unauthenticated,
    Code.PermissionDenied,
    Code.InvalidArgument,
    Code.Unimplemented,
  ].includes(ConnectError.from(error).code);
}

export function messageOf(error: unknown): string {
  return error instanceof ConnectError ? error.rawMessage : String(error);
}

export function sleep(milliseconds: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
}
