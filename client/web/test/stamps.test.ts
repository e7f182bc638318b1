import { expect, test } from 'vitest';
import { eraOf, STAMP_MASK, stampBits, STAMPS_PER_SECOND } from '../src/draw/stamps.js';

/** As the shaders do. */
function age(bits: number, now: number): number {
  return (now - bits) & STAMP_MASK;
}

test('what has changed does not glow again after days', () => {
  const day = 86_400 * STAMPS_PER_SECOND;
  expect(stampBits(0, 5)).toBe(0);
  for (const stamp of [1, 12_345, STAMP_MASK, STAMP_MASK + 1, 100 * day]) {
    expect(stampBits(stamp, stamp)).not.toBe(0);
    expect(age(stampBits(stamp, stamp), stamp)).toBeLessThanOrEqual(STAMPS_PER_SECOND);
    // Texels are written again when an era begins; none is kept for two.
    let now = stamp;
    let bits = stampBits(stamp, now);
    for (; now < stamp + 8 * day; now += 64 * 600) {
      if (eraOf(now) !== eraOf(now - 64 * 600)) bits = stampBits(stamp, now);
      if (now > stamp && bits !== 0) expect(age(bits, now)).toBeGreaterThan(1000);
    }
    expect(bits).toBe(0);
  }
});
