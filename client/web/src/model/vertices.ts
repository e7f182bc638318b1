// The vertices, in slots that stay while the vertex lives, found by their ids.
import { grown } from './grown.js';
import { IdTable } from './id_table.js';

export class Vertices {
  /** Ids, two numbers a slot. */
  words = new Uint32Array(0);
  /** `dimension` a slot. */
  coordinates = new Float64Array(0);
  /** 0: an input point; 1: on a segment; 2 in 3D: on a polygon; the dimension: free. */
  containingDimensions = new Uint8Array(0);
  /** The feature that a vertex lies on, two numbers a slot. */
  owners = new Uint32Array(0);
  isLive = new Uint8Array(0);
  count = 0;
  /** Slots, those that are free included. */
  length = 0;
  /** Slots that have changed since `settle`, each once. */
  readonly changed: number[] = [];

  #isChanged = new Uint8Array(0);
  readonly #free: number[] = [];
  readonly #slots = new IdTable(this);

  constructor(readonly dimension: number) {}

  reserve(count: number): void {
    this.#grow(count);
    this.#slots.reserve(count);
  }

  /** The slot of the id; -1 if there is none. */
  find(lo: number, hi: number): number {
    return this.#slots.find(lo, hi);
  }

  /** A slot for a new id, to be `set`. */
  add(lo: number, hi: number): number {
    const slot = this.#free.pop() ?? this.length++;
    if (this.length > this.isLive.length) this.#grow(2 * this.length);
    this.words[2 * slot] = lo;
    this.words[2 * slot + 1] = hi;
    this.isLive[slot] = 1;
    this.#slots.add(slot);
    ++this.count;
    return slot;
  }

  /** Notes that the slot's columns have changed. */
  note(slot: number): void {
    if (this.#isChanged[slot] !== 0) return;
    this.#isChanged[slot] = 1;
    this.changed.push(slot);
  }

  remove(slot: number): void {
    this.#slots.remove(slot);
    this.isLive[slot] = 0;
    --this.count;
    this.#free.push(slot);
    this.note(slot);
  }

  settle(): void {
    for (const slot of this.changed) this.#isChanged[slot] = 0;
    this.changed.length = 0;
  }

  #grow(count: number): void {
    if (count <= this.isLive.length) return;
    this.words = grown(this.words, 2 * count);
    this.coordinates = grown(this.coordinates, this.dimension * count);
    this.containingDimensions = grown(this.containingDimensions, count);
    this.owners = grown(this.owners, 2 * count);
    this.isLive = grown(this.isLive, count);
    this.#isChanged = grown(this.#isChanged, count);
  }
}
