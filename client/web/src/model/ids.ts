// Ids for new features. The page does not know all ids of a mesh: sizes have no vertex, and other
// clients choose ids at the same time. So its own are random, and no other client is likely to have them.

/** From 1 to 2^53 - 1, which a polygon may have, too, and which every language reads from JSON. */
export function randomId(): bigint {
  const [hi, lo] = crypto.getRandomValues(new Uint32Array(2));
  const id = (BigInt(hi & 0x1fffff) << 32n) | BigInt(lo);
  return id === 0n ? randomId() : id;
}
