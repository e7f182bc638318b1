// What tests of the page read: figures that a person would need a stop watch for.
import type { App } from './app.js';

export interface Hooks {
  readonly revision: number;
  readonly hash: string;
  readonly connection: string;
  readonly diffs: number;
  readonly frames: number;
  /** Revisions that the page can go back. */
  readonly kept: number;
  readonly counts: { vertices: number; cells: number; slots: number };
  readonly bytesUploaded: number;
  /** Of the last diff: applying it, and uploading and drawing it. */
  readonly milliseconds: { take: number; update: number };
  /** Pixels of the canvas, from its left upper corner. */
  pixelOf(x: number, y: number): { x: number; y: number };
  /** The glow does not fade. */
  freeze(isFrozen: boolean): void;
  /** Draws what has come, and reads the colour of pixels: red, green, blue. */
  colours(pixels: readonly { x: number; y: number }[]): number[][];
}

declare global {
  interface Window {
    __dynmesh?: Hooks;
  }
}

export function setHooks(app: App): void {
  window.__dynmesh = {
    get revision() {
      return Number(app.replica.revision);
    },
    get hash() {
      return app.replica.hash;
    },
    get connection() {
      return app.connection;
    },
    get diffs() {
      return app.replica.diffs;
    },
    get frames() {
      return app.view.frames;
    },
    get kept() {
      return app.replica.history.before;
    },
    get counts() {
      const { mesh } = app.replica;
      return {
        vertices: mesh?.vertices.count ?? 0,
        cells: mesh?.cells.count ?? 0,
        slots: mesh?.cells.length ?? 0,
      };
    },
    get bytesUploaded() {
      return app.view.picture?.writer.bytes ?? 0;
    },
    get milliseconds() {
      return { take: app.watch?.takeMs ?? 0, update: app.view.updateMs };
    },
    pixelOf: (x, y) => app.view.plane.pixelOf({ x, y }),
    freeze: (isFrozen) => app.view.freeze(isFrozen),
    colours(pixels) {
      app.view.drawNow();
      const gl = app.view.picture?.renderer.getContext();
      if (gl === undefined) return [];
      const ratio = devicePixelRatio;
      return pixels.map(({ x, y }) => {
        const pixel = new Uint8Array(4);
        const row = gl.drawingBufferHeight - 1 - Math.floor(y * ratio);
        gl.readPixels(Math.floor(x * ratio), row, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
        return [...pixel.subarray(0, 3)];
      });
    },
  };
}
