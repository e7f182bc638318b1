import { expect, test } from 'vitest';
import { isToken } from '../src/service/client.js';

test('what can be a token is what a header of a request can have', () => {
  for (const value of ['', 'dm_0aZ-', '~!"#']) {
    expect(isToken(value)).toBe(true);
    expect(() => new Headers({ Authorization: `Bearer ${value}` })).not.toThrow();
  }
  for (const value of ['schlüssel', 'ключ', 'a\nb', 'a b']) expect(isToken(value)).toBe(false);
});
