// The mesh's hash, as defined at the top of proto/dynmesh/v1/mesh.proto, on halves of 32 bits: BigInt
// would take a microsecond a word, and a diff of 300 triangles has to be applied in two milliseconds.
//
// Rows of one kind begin with the same words, so their chains start from what these have left.

/** The chains of hash(...): lower and higher half of A's, then of B's. */
const chain = new Int32Array(4);

/** The upper 32 bits of the product of two unsigned numbers; b0 and b1 are the halves of one. */
function upper(a: number, b0: number, b1: number): number {
  const a0 = a & 0xffff;
  const a1 = a >>> 16;
  const middle = (Math.imul(a1, b0) >>> 0) + ((Math.imul(a0, b0) >>> 0) >>> 16);
  const rest = (Math.imul(a0, b1) >>> 0) + (middle & 0xffff);
  return (Math.imul(a1, b1) + (middle >>> 16) + (rest >>> 16)) | 0;
}

/** One step of A, in place. */
function stepA(wordLo: number, wordHi: number): void {
  const z = ((chain[0] ^ wordLo) >>> 0) + 0x7f4a7c15;
  let hi = ((chain[1] ^ wordHi) + 0x9e3779b9 + (z > 0xffffffff ? 1 : 0)) | 0;
  let lo = z | 0;
  lo ^= (lo >>> 30) | (hi << 2);
  hi ^= hi >>> 30;
  hi = (upper(lo, 0xe5b9, 0x1ce4) + Math.imul(hi, 0x1ce4e5b9) + Math.imul(lo, 0xbf58476d)) | 0;
  lo = Math.imul(lo, 0x1ce4e5b9);
  lo ^= (lo >>> 27) | (hi << 5);
  hi ^= hi >>> 27;
  hi = (upper(lo, 0x11eb, 0x1331) + Math.imul(hi, 0x133111eb) + Math.imul(lo, 0x94d049bb)) | 0;
  lo = Math.imul(lo, 0x133111eb);
  chain[0] = lo ^ ((lo >>> 31) | (hi << 1));
  chain[1] = hi ^ (hi >>> 31);
}

/** One step of B, in place. */
function stepB(wordLo: number, wordHi: number): void {
  const z = ((chain[2] ^ wordLo) >>> 0) + 0xd192ed03;
  let hi = ((chain[3] ^ wordHi) + 0xd1b54a32 + (z > 0xffffffff ? 1 : 0)) | 0;
  let lo = z | 0;
  lo ^= hi >>> 1;
  hi = (upper(lo, 0x8ccd, 0xed55) + Math.imul(hi, 0xed558ccd) + Math.imul(lo, 0xff51afd7)) | 0;
  lo = Math.imul(lo, 0xed558ccd);
  lo ^= hi >>> 1;
  hi = (upper(lo, 0xec53, 0x1a85) + Math.imul(hi, 0x1a85ec53) + Math.imul(lo, 0xc4ceb9fe)) | 0;
  lo = Math.imul(lo, 0x1a85ec53);
  chain[2] = lo ^ (hi >>> 1);
  chain[3] = hi;
}

function take(wordLo: number, wordHi: number): void {
  stepA(wordLo, wordHi);
  stepB(wordLo, wordHi);
}

/** The chains after these words, all of them small. */
function after(...words: number[]): Int32Array {
  chain.set([0x9c88c6e3, 0x8ebc6af0, 0x75374cc3, 0x589965cc]);
  for (const word of words) take(word, 0);
  return chain.slice();
}

const vertexStart = [2, 3].map((dimension) => after(1, dimension));
const simplexStart = [2, 3].map((dimension) => after(2, dimension + 1));
const subsegmentStart = after(3);
const subfacetStart = after(4);

const coordinate = new Float64Array(1);
const coordinateBits = new Int32Array(coordinate.buffer);

/** A sum of hashes: of what was added, less what was subtracted. */
export class HashSum {
  /** Halves of the two words, the higher word first, the lower half first. */
  readonly #sum = new Uint32Array(4);

  /** 32 hexadecimal digits, as the server writes it. */
  toHex(): string {
    const s = this.#sum;
    return [s[1], s[0], s[3], s[2]].map((half) => half.toString(16).padStart(8, '0')).join('');
  }

  // `sign` is 1 to add the row, -1 to subtract it. Columns have two numbers a word.

  vertex(
    sign: 1 | -1,
    dimension: number,
    coordinates: Float64Array,
    containingDimensions: Uint8Array,
    owners: Uint32Array,
    row: number,
  ): void {
    chain.set(vertexStart[dimension - 2]);
    for (let k = 0; k < dimension; ++k) {
      coordinate[0] = coordinates[row * dimension + k] + 0; // +0 for -0
      take(coordinateBits[0], coordinateBits[1]);
    }
    take(containingDimensions[row], 0);
    take(owners[2 * row], owners[2 * row + 1]);
    this.#finish(sign);
  }

  simplex(
    sign: 1 | -1,
    dimension: number,
    ids: Uint32Array,
    row: number,
    regionLo: number,
    regionHi: number,
  ): void {
    chain.set(simplexStart[dimension - 2]);
    const width = 2 * (dimension + 1);
    for (let k = row * width; k < (row + 1) * width; k += 2) take(ids[k], ids[k + 1]);
    if (regionLo !== 0 || regionHi !== 0) take(regionLo, regionHi);
    this.#finish(sign);
  }

  /** A subsegment (width 2) or a subfacet (width 3). */
  constraint(
    sign: 1 | -1,
    width: number,
    ids: Uint32Array,
    owners: Uint32Array,
    row: number,
  ): void {
    chain.set(width === 2 ? subsegmentStart : subfacetStart);
    for (let k = 2 * row * width; k < 2 * (row + 1) * width; k += 2) take(ids[k], ids[k + 1]);
    take(owners[2 * row], owners[2 * row + 1]);
    this.#finish(sign);
  }

  #finish(sign: 1 | -1): void {
    this.#accumulate(0, sign);
    this.#accumulate(2, sign);
  }

  #accumulate(at: 0 | 2, sign: 1 | -1): void {
    const sum = this.#sum;
    const lo = sum[at] + sign * (chain[at] >>> 0);
    sum[at] = lo;
    sum[at + 1] =
      sum[at + 1] + sign * (chain[at + 1] >>> 0) + (lo < 0 ? -1 : lo > 0xffffffff ? 1 : 0);
  }
}
