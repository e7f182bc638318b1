type Column = Int32Array | Uint32Array | Uint8Array | Float64Array;

/** A longer copy. */
export function grown<T extends Column>(column: T, length: number): T {
  const result = new (column.constructor as new (length: number) => T)(length);
  result.set(column as never);
  return result;
}
