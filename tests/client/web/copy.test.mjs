// The page's copy is the server's mesh: after random edits, a crash of the server, and in three pages.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { atRevision, Browser, figures } from './support/browser.mjs';
import { Editor } from './support/edits.mjs';
import { Random } from './support/random.mjs';
import { Server } from './support/server.mjs';

const EDITS = process.env.DYNMESH_NIGHTLY ? 1000 : 100;

let server;
let browser;

before(async () => {
  server = await Server.start();
  browser = await Browser.start();
});
after(async () => {
  await browser?.close();
  await server?.stop();
});

async function expectCopy(page, mesh) {
  const { revision, hash } = await server.call('GetMesh', { mesh });
  const copy = await atRevision(page, Number(revision ?? 0));
  assert.equal(copy.revision, Number(revision ?? 0));
  assert.equal(copy.hash, hash);
  assert.deepEqual(page.problems, []);
  return copy;
}

for (const dimension of [2, 3]) {
  test(`in ${dimension}D, three pages have the server's mesh after random edits and a crash`, async () => {
    const random = new Random();
    const side = dimension === 3 ? { x: 1, y: 1, z: 1 } : { x: 1, y: 1 };
    const zero = dimension === 3 ? { x: 0, y: 0, z: 0 } : { x: 0, y: 0 };
    const id = `space-${dimension}`;
    const mesh = await server.create(id, {
      dimension,
      box: { lo: zero, hi: side },
    });
    const editor = new Editor(server, mesh, dimension, random);
    const pages = [];
    for (let i = 0; i < 3; ++i) {
      pages.push(
        await browser.open(`${server.url}#mesh=${id}`, {
          width: 640,
          height: 480,
        }),
      );
    }
    let revision = 0;
    let refused = 0;
    const edits = dimension === 3 ? Math.ceil(EDITS / 3) : EDITS;
    for (let i = 0; i < edits; ++i) {
      const next = await editor.edit();
      if (next === undefined) ++refused;
      else revision = next;
      if (i === Math.floor(edits / 2)) await server.restart(200);
      if (i % Math.ceil(edits / 10) === 0) for (const page of pages) await expectCopy(page, mesh);
    }
    for (const page of pages) await expectCopy(page, mesh);
    console.log(
      `${edits} batches, ${refused} refused, revision ${revision}`,
      JSON.stringify(await figures(pages[0])),
    );
    assert.ok(revision > edits / 2, 'most batches are applied');
    for (const page of pages) await page.close();
  });
}
