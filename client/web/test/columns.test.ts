import { BinaryWriter } from '@bufbuild/protobuf/wire';
import { expect, test } from 'vitest';
import { doubles, varints, wordAt, words } from '../src/model/columns.js';

const numbers = [
  0n,
  1n,
  127n,
  128n,
  2n ** 28n - 1n,
  2n ** 28n,
  2n ** 31n,
  2n ** 32n - 1n,
  2n ** 32n,
  2n ** 35n,
  2n ** 35n - 1n,
  2n ** 63n,
  2n ** 64n - 1n,
  0x123456789abcdef0n,
];

test('varints are read as two halves', () => {
  const writer = new BinaryWriter();
  for (const number of numbers) writer.uint64(number);
  const column = varints(writer.finish());
  expect(numbers.map((_, row) => wordAt(column, row))).toEqual(numbers);
  expect(() => varints(Uint8Array.of(0x80))).toThrow(RangeError);
  expect(() => varints(Uint8Array.of(...Array<number>(10).fill(0x80), 1))).toThrow(RangeError);
});

test('words and doubles may begin at any byte', () => {
  const writer = new BinaryWriter();
  for (const number of numbers) writer.fixed64(number);
  const bytes = Uint8Array.of(9, 9, 9, ...writer.finish()).subarray(3);
  const column = words(bytes);
  expect(numbers.map((_, row) => wordAt(column, row))).toEqual(numbers);
  expect(doubles(bytes)[0]).toBe(0);
  expect(() => words(bytes.subarray(1))).toThrow(RangeError);
});
