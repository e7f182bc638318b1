// Columns of numbers, from the bytes of packed fields. A 64-bit word is two 32-bit ones, the lower
// first: an id as a BigInt costs an object, and a mesh has millions.

// Most columns of a small diff are empty, and the page keeps many diffs.
const noWords = new Uint32Array(0);
const noDoubles = new Float64Array(0);

/** Words of `fixed64`: two numbers each. */
export function words(bytes: Uint8Array): Uint32Array {
  if (bytes.length === 0) return noWords;
  return new Uint32Array(aligned(bytes, 8));
}

export function doubles(bytes: Uint8Array): Float64Array {
  if (bytes.length === 0) return noDoubles;
  return new Float64Array(aligned(bytes, 8));
}

/** Words of `uint64`, which are varints: two numbers each. */
export function varints(bytes: Uint8Array): Uint32Array {
  if (bytes.length === 0) return noWords;
  let count = 0;
  for (const byte of bytes) if (byte < 0x80) ++count;
  const result = new Uint32Array(2 * count);
  let at = 0;
  for (let i = 0; i < result.length; i += 2) {
    let lo = 0;
    let hi = 0;
    let shift = 0;
    for (;;) {
      if (shift > 63) throw new RangeError('a number has more than ten bytes');
      const byte = bytes[at++];
      const bits = byte & 0x7f;
      if (shift < 32) lo |= bits << shift;
      if (shift > 31) hi |= bits << (shift - 32);
      else if (shift === 28) hi |= bits >>> 4;
      if (byte < 0x80) break;
      shift += 7;
    }
    result[i] = lo;
    result[i + 1] = hi;
  }
  if (at !== bytes.length) throw new RangeError('a number is cut off');
  return result;
}

// A message's fields begin at any byte; views of words do not.
function aligned(bytes: Uint8Array, size: number): ArrayBuffer {
  if (bytes.length % size !== 0) throw new RangeError('a column is cut off');
  return bytes.slice().buffer;
}

/** The word as a BigInt, for messages to the server and for people. */
export function wordAt(column: Uint32Array, row: number): bigint {
  return (BigInt(column[2 * row + 1]) << 32n) | BigInt(column[2 * row]);
}
