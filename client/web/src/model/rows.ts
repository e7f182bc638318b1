// Rows of a kind of simplex (triangles, tetrahedra, subsegments, subfacets) in slots that stay while
// the simplex lives, found by their corners. A diff frees slots and takes the free ones again, so
// that arrays of a picture change where the mesh does and nowhere else.
import { grown } from './grown.js';

export class Rows {
  /** Slots of the corners, `width` a row; -1: the row is free. */
  corners: Int32Array = new Int32Array(0);
  /** The region of a simplex, the owner of a constraint: two numbers a row. */
  tags: Uint32Array = new Uint32Array(0);
  /** When the row was added, in the caller's unit. */
  stamps: Uint32Array = new Uint32Array(0);
  /** Rows in use. */
  count = 0;
  /** Rows, those that are free included. */
  length = 0;
  /** Rows that have changed since `changed.length` was set to 0, each once. */
  readonly changed: number[] = [];

  #isChanged = new Uint8Array(0);
  readonly #free: number[] = [];
  /** Row + 1 by open addressing; 0 is free. At most half are used. */
  #table = new Int32Array(16);

  /**
   * With `tagIsKey`, rows with the same corners and other tags are other rows: an edge may lie on
   * two features.
   */
  constructor(
    readonly width: number,
    private readonly tagIsKey: boolean,
  ) {}

  reserve(count: number): void {
    this.#growRows(count);
    this.#growTable(count);
  }

  /** The row with these corners, the first of them at `at`; -1 if there is none. */
  find(corners: Int32Array, at: number, tagLo: number, tagHi: number): number {
    const table = this.#table;
    const mask = table.length - 1;
    for (let place = this.#start(corners, at) & mask; ; place = (place + 1) & mask) {
      const row = table[place] - 1;
      if (row < 0) return -1;
      if (this.#equals(row, corners, at, tagLo, tagHi)) return row;
    }
  }

  /** Adds a row and returns it. It must not be there yet. */
  add(corners: Int32Array, at: number, tagLo: number, tagHi: number, stamp: number): number {
    const row = this.#free.pop() ?? this.length++;
    if (this.length * this.width > this.corners.length) this.#growRows(2 * this.length);
    const { width } = this;
    for (let k = 0; k < width; ++k) this.corners[row * width + k] = corners[at + k];
    this.tags[2 * row] = tagLo;
    this.tags[2 * row + 1] = tagHi;
    this.stamps[row] = stamp;
    if (2 * ++this.count > this.#table.length) this.#growTable(2 * this.count);
    else this.#place(row + 1);
    this.#note(row);
    return row;
  }

  remove(row: number): void {
    const table = this.#table;
    const mask = table.length - 1;
    const { corners, width } = this;
    let hole = this.#start(corners, row * width) & mask;
    while (table[hole] !== row + 1) hole = (hole + 1) & mask;
    for (let at = (hole + 1) & mask; table[at] !== 0; at = (at + 1) & mask) {
      const home = this.#start(corners, (table[at] - 1) * width) & mask;
      if (((at - home) & mask) < ((at - hole) & mask)) continue;
      table[hole] = table[at];
      hole = at;
    }
    table[hole] = 0;
    corners.fill(-1, row * width, (row + 1) * width);
    --this.count;
    this.#free.push(row);
    this.#note(row);
  }

  isLive(row: number): boolean {
    return this.corners[row * this.width] >= 0;
  }

  /** Forgets what has changed: a picture has it. */
  settle(): void {
    for (const row of this.changed) this.#isChanged[row] = 0;
    this.changed.length = 0;
  }

  #note(row: number): void {
    if (this.#isChanged[row] !== 0) return;
    this.#isChanged[row] = 1;
    this.changed.push(row);
  }

  #equals(row: number, corners: Int32Array, at: number, tagLo: number, tagHi: number): boolean {
    const { width } = this;
    for (let k = 0; k < width; ++k) {
      if (this.corners[row * width + k] !== corners[at + k]) return false;
    }
    return !this.tagIsKey || (this.tags[2 * row] === tagLo && this.tags[2 * row + 1] === tagHi);
  }

  #start(corners: Int32Array, at: number): number {
    let mixed = 0;
    for (let k = 0; k < this.width; ++k) {
      mixed = Math.imul(mixed ^ corners[at + k], 0x9e3779b1);
      mixed ^= mixed >>> 15;
    }
    return mixed;
  }

  #place(entry: number): void {
    const table = this.#table;
    const mask = table.length - 1;
    let at = this.#start(this.corners, (entry - 1) * this.width) & mask;
    while (table[at] !== 0) at = (at + 1) & mask;
    table[at] = entry;
  }

  #growRows(count: number): void {
    if (count * this.width <= this.corners.length) return;
    this.corners = grown(this.corners, count * this.width);
    this.tags = grown(this.tags, 2 * count);
    this.stamps = grown(this.stamps, count);
    this.#isChanged = grown(this.#isChanged, count);
  }

  #growTable(count: number): void {
    let size = this.#table.length;
    while (size < 2 * count) size *= 2;
    this.#table = new Int32Array(size);
    for (let row = 0; row < this.length; ++row) if (this.isLive(row)) this.#place(row + 1);
  }
}
