// Times of changes. Those of rows count from the begin of the page; a texel has their lower bits, and
// what changed long ago has 0 there: else it would glow again when the lower bits come round.

/** Stamps a second. */
export const STAMPS_PER_SECOND = 64;
/** Bits of a stamp in a texel; the rest is the colour of the region. */
export const STAMP_BITS = 24;
export const STAMP_MASK = (1 << STAMP_BITS) - 1;

/** A quarter of the time after which the bits come round: 18 hours. */
const ERA = 1 << (STAMP_BITS - 2);

/** The present time in stamps; never 0, which stands for what did not change. */
export function stampNow(): number {
  return 1 + Math.floor((performance.now() / 1000) * STAMPS_PER_SECOND);
}

/** All texels are written again when another era begins, so that none has a stamp older than two. */
export function eraOf(now: number): number {
  return Math.floor(now / ERA);
}

/** What a texel has of a stamp; the stamp before if that would be 0. */
export function stampBits(stamp: number, now: number): number {
  if (stamp === 0 || now - stamp > ERA) return 0;
  return stamp & STAMP_MASK || STAMP_MASK;
}
