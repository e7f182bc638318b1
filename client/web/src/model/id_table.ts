// From ids of 64 bits to rows, by open addressing in typed arrays: a Map of BigInts would take ten
// times the memory, and garbage with every id that is looked up.

/** Rows by id; ids are kept by the caller, two numbers a row. */
export class IdTable {
  /** Row + 1; 0 is free. At most half are used. */
  #rows: Int32Array;
  #count = 0;

  constructor(private readonly ids: { words: Uint32Array }) {
    this.#rows = new Int32Array(16);
  }

  reserve(count: number): void {
    let size = this.#rows.length;
    while (size < 2 * count) size *= 2;
    if (size === this.#rows.length) return;
    const before = this.#rows;
    this.#rows = new Int32Array(size);
    for (const row of before) if (row !== 0) this.#place(row);
  }

  /** The row of the id; -1 if there is none. */
  find(lo: number, hi: number): number {
    const rows = this.#rows;
    const words = this.ids.words;
    const mask = rows.length - 1;
    for (let at = start(lo, hi) & mask; ; at = (at + 1) & mask) {
      const row = rows[at] - 1;
      if (row < 0) return -1;
      if (words[2 * row] === lo && words[2 * row + 1] === hi) return row;
    }
  }

  /** Adds a row, whose id is not there yet. */
  add(row: number): void {
    if (2 * ++this.#count > this.#rows.length) this.reserve(2 * this.#count);
    this.#place(row + 1);
  }

  /** Removes a row that is there, by its id. */
  remove(row: number): void {
    const rows = this.#rows;
    const words = this.ids.words;
    const mask = rows.length - 1;
    let hole = start(words[2 * row], words[2 * row + 1]) & mask;
    while (rows[hole] !== row + 1) hole = (hole + 1) & mask;
    --this.#count;
    // What follows moves up, so that no search stops at the hole before it.
    for (let at = (hole + 1) & mask; rows[at] !== 0; at = (at + 1) & mask) {
      const home = start(words[2 * rows[at] - 2], words[2 * rows[at] - 1]) & mask;
      if (((at - home) & mask) < ((at - hole) & mask)) continue;
      rows[hole] = rows[at];
      hole = at;
    }
    rows[hole] = 0;
  }

  #place(entry: number): void {
    const rows = this.#rows;
    const words = this.ids.words;
    const mask = rows.length - 1;
    let at = start(words[2 * entry - 2], words[2 * entry - 1]) & mask;
    while (rows[at] !== 0) at = (at + 1) & mask;
    rows[at] = entry;
  }
}

/** Ids are hashes of coordinates: any bits of them will do. */
function start(lo: number, hi: number): number {
  return lo ^ (hi << 7);
}
