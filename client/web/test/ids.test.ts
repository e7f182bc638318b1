import { expect, test } from 'vitest';
import { randomId } from '../src/model/ids.js';

test('ids are those that any feature may have, exact in JSON, and not twice the same', () => {
  const ids = Array.from({ length: 10_000 }, randomId);
  expect(new Set(ids).size).toBe(ids.length);
  expect(ids.every((id) => id > 0n && id < 2n ** 53n)).toBe(true);
  expect(ids.some((id) => id > 2n ** 52n)).toBe(true);
});
