// Makes the folder gen: TypeScript of the service's messages, from the contract: the folder proto of the
// project, or DYNMESH_PROTO.
//
// A page has to decode a million ids in a second, and to hash them. As `fixed64` they would become
// as many BigInts, so in what the page generates from, columns of numbers are `bytes`: a packed
// field and a field of bytes are the same on the wire. `columns.ts` reads them.
import { execFileSync } from 'node:child_process';
import { cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const home = dirname(dirname(fileURLToPath(import.meta.url)));
const contract = process.env.DYNMESH_PROTO ?? join(home, '../../proto');
const gen = join(home, 'gen');
const copy = join(gen, 'proto');

// Files whose columns are read as bytes. Requests, as in the others, keep their numbers.
const FILES_OF_COLUMNS = ['dynmesh/v1/mesh.proto'];
const COLUMN = /^(\s*)repeated (fixed64|double|uint64|sint64) (\w+ = \d+;)/gm;
// Few, and handy as numbers.
const KEPT = /^(polygons|features|markers) /;

rmSync(gen, { recursive: true, force: true });
mkdirSync(join(copy, 'dynmesh'), { recursive: true });
cpSync(join(contract, 'dynmesh'), join(copy, 'dynmesh'), { recursive: true });
for (const name of FILES_OF_COLUMNS) {
  const text = readFileSync(join(copy, name), 'utf8');
  writeFileSync(
    join(copy, name),
    text.replace(COLUMN, (line, indent, type, rest) =>
      KEPT.test(rest) ? line : `${indent}bytes ${rest}`,
    ),
  );
}
execFileSync(
  process.env.PROTOC ?? 'protoc',
  [
    `--plugin=${join(home, 'node_modules/.bin/protoc-gen-es')}`,
    `--proto_path=${copy}`,
    `--es_out=${gen}`,
    '--es_opt=target=ts,import_extension=js',
    'dynmesh/v1/geometry.proto',
    'dynmesh/v1/mesh.proto',
    'dynmesh/v1/mesh_service.proto',
    'dynmesh/v1/status_details.proto',
  ],
  { stdio: 'inherit' },
);
