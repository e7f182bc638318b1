// Random numbers from a seed, which is printed: DYNMESH_TEST_SEED repeats a test.

export class Random {
  #state;

  constructor() {
    const seed = Number(process.env.DYNMESH_TEST_SEED ?? Math.floor(Math.random() * 1e9));
    console.log(`DYNMESH_TEST_SEED=${seed}`);
    this.#state = seed >>> 0;
  }

  /** From 0 to 1, without 1. */
  next() {
    this.#state = (this.#state + 0x6d2b79f5) >>> 0;
    let z = this.#state;
    z = Math.imul(z ^ (z >>> 15), z | 1);
    z ^= z + Math.imul(z ^ (z >>> 7), z | 61);
    return ((z ^ (z >>> 14)) >>> 0) / 2 ** 32;
  }

  below(count) {
    return Math.floor(this.next() * count);
  }

  pick(items) {
    return items[this.below(items.length)];
  }
}
