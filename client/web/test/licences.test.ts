import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { expect, test } from 'vitest';
import { licencesOf, packagesOf } from '../licences.js';

const modules = join(dirname(dirname(fileURLToPath(import.meta.url))), 'node_modules');

test('packages are those that modules come from, and have texts', () => {
  const packages = packagesOf([
    join(modules, 'three/src/Three.Core.js'),
    join(modules, 'three/src/math/Vector3.js'),
    `\0${join(modules, '@connectrpc/connect/dist/esm/index.js')}`,
    '/somewhere/src/main.ts',
  ]);
  expect(packages.map(({ name }) => name)).toEqual(['@connectrpc/connect', 'three']);
  const text = licencesOf(packages, 'TEXT OF APACHE');
  expect(text).toContain('MIT');
  expect(text).toContain('TEXT OF APACHE');
});

test('a copyleft licence is refused', () => {
  for (const license of ['GPL-3.0', 'LGPL-2.1-or-later', 'MPL-2.0', 'UNLICENSED']) {
    const other = { name: 'other', version: '1.0.0', license, folder: modules };
    expect(() => licencesOf([other], '')).toThrow(license);
  }
});
