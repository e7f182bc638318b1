// The licences of what is in the bundle: a build with another kind of licence fails, and the texts are
// served beside the page.
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Plugin } from 'vite';

/** None of them asks those that give the page away for its source. */
export const ACCEPTED = [
  'MIT',
  'ISC',
  'Apache-2.0',
  'BSD-2-Clause',
  'BSD-3-Clause',
  '(Apache-2.0 AND BSD-3-Clause)',
];

export interface Package {
  name: string;
  version: string;
  license: string;
  folder: string;
}

/** The packages that these modules come from. */
export function packagesOf(modules: Iterable<string>): Package[] {
  const found = new Map<string, Package>();
  for (const module of modules) {
    const match = /^\0?(.*\/node_modules\/(?:@[^/]+\/)?[^/]+)\//.exec(module);
    if (match === null || found.has(match[1])) continue;
    const folder = match[1];
    const about = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8')) as Package;
    found.set(folder, { ...about, folder });
  }
  return [...found.values()].sort((a, b) => (a.name < b.name ? -1 : 1));
}

/** Their licences as text; an error if one is not accepted, or has no text. */
export function licencesOf(packages: readonly Package[], fallback: string): string {
  return packages
    .map(({ name, version, license, folder }) => {
      if (!ACCEPTED.includes(license)) throw new Error(`${name} has the licence ${license}`);
      return `${name} ${version}, ${license}\n\n${textOf(folder, license, fallback)}`;
    })
    .join(`\n\n${'-'.repeat(80)}\n\n`);
}

function textOf(folder: string, license: string, fallback: string): string {
  for (const file of ['LICENSE', 'LICENSE.md', 'LICENSE.txt', 'LICENCE']) {
    if (existsSync(join(folder, file))) return readFileSync(join(folder, file), 'utf8').trim();
  }
  // The packages under Apache-2.0 name it only; the text is always the same.
  if (license.includes('Apache-2.0')) return fallback;
  throw new Error(`${folder} has no text of its licence`);
}

/** Writes licenses.txt into the build; `apache` is a file with the text of Apache-2.0. */
export function licences(apache: string): Plugin {
  return {
    name: 'licences',
    generateBundle(_, bundle) {
      const modules = Object.values(bundle).flatMap((file) =>
        file.type === 'chunk' ? Object.keys(file.modules) : [],
      );
      const text = licencesOf(packagesOf(modules), readFileSync(apache, 'utf8').trim());
      this.emitFile({ type: 'asset', fileName: 'licenses.txt', source: `${text}\n` });
    },
  };
}
