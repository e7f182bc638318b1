// The worker's side of the page: it gets what has changed in the mesh, one order at a time.
import { regionNumber } from '../draw/picture.js';
import type { SlotMesh } from '../model/slot_mesh.js';
import type { Patch } from './cutter.js';
import type { Answer, Order } from './worker.js';

export interface Plane {
  axis: number;
  offset: number;
}

export class CutClient {
  #worker: Worker | undefined;
  #mesh: SlotMesh | undefined;
  readonly #slots = new Set<number>();
  readonly #rows = new Set<number>();
  #plane: Plane | undefined;
  #isBusy = false;
  #isDue = false;
  #isOther = false;

  constructor(
    private readonly origin: () => readonly number[],
    private readonly cut: (triangles: Answer) => void,
  ) {}

  get isOn(): boolean {
    return this.#plane !== undefined;
  }

  /** Cuts this mesh by this plane, or nothing any more. */
  set(mesh: SlotMesh | undefined, plane: Plane | undefined): void {
    const isWanted = mesh?.dimension === 3 && plane !== undefined;
    if (!isWanted) {
      this.#plane = this.#mesh = undefined;
      this.#worker?.terminate();
      this.#worker = undefined;
      this.#isBusy = this.#isDue = false;
      return;
    }
    if (mesh !== this.#mesh) {
      this.#mesh = mesh;
      this.#isOther = true;
      this.#slots.clear();
      this.#rows.clear();
      for (let slot = 0; slot < mesh.vertices.length; ++slot) this.#slots.add(slot);
      for (let row = 0; row < mesh.cells.length; ++row) this.#rows.add(row);
    }
    this.#plane = plane;
    this.#order();
  }

  /** Takes note of what has changed, before a picture settles it. */
  changed(): void {
    if (this.#mesh === undefined) return;
    for (const slot of this.#mesh.vertices.changed) this.#slots.add(slot);
    for (const row of this.#mesh.cells.changed) this.#rows.add(row);
    this.#order();
  }

  #order(): void {
    const plane = this.#plane;
    const mesh = this.#mesh;
    if (plane === undefined || mesh === undefined) return;
    this.#isDue = this.#isBusy;
    if (this.#isBusy) return;
    this.#isBusy = true;
    const worker = this.#started();
    const order: Order = {
      reset: this.#isOther,
      patch: this.#patchOf(mesh),
      ...plane,
      origin: this.origin(),
    };
    this.#isOther = false;
    worker.postMessage(order);
  }

  #started(): Worker {
    if (this.#worker !== undefined) return this.#worker;
    const worker = new Worker(new URL('./worker.ts', import.meta.url), { type: 'module' });
    worker.onmessage = ({ data }: MessageEvent<Answer>) => {
      this.#isBusy = false;
      this.cut(data);
      if (this.#isDue) this.#order();
    };
    this.#worker = worker;
    return worker;
  }

  #patchOf(mesh: SlotMesh): Patch {
    const { vertices, cells } = mesh;
    const slots = Int32Array.from(this.#slots);
    const rows = Int32Array.from(this.#rows);
    const patch: Patch = {
      slots,
      coordinates: new Float64Array(3 * slots.length),
      rows,
      corners: new Int32Array(4 * rows.length),
      regions: new Uint8Array(rows.length),
    };
    slots.forEach((slot, i) => {
      patch.coordinates.set(vertices.coordinates.subarray(3 * slot, 3 * slot + 3), 3 * i);
    });
    rows.forEach((row, i) => {
      patch.corners.set(cells.corners.subarray(4 * row, 4 * row + 4), 4 * i);
      patch.regions[i] = regionNumber(cells.tags[2 * row], cells.tags[2 * row + 1]);
    });
    this.#slots.clear();
    this.#rows.clear();
    return patch;
  }
}
