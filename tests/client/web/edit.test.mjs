// Editing with the pointer: what is clicked and dragged is what the server has.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { atRevision, Browser, figures } from './support/browser.mjs';
import { Server } from './support/server.mjs';

let server;
let browser;
let page;
const mesh = 'meshes/drawn';

before(async () => {
  server = await Server.start();
  browser = await Browser.start();
  await server.create('drawn', { box: { lo: { x: 0, y: 0 }, hi: { x: 1, y: 1 } } });
  page = await browser.open(`${server.url}#mesh=drawn`);
  await atRevision(page, 0);
});
after(async () => {
  await browser?.close();
  await server?.stop();
});

async function choose(tool) {
  await page.evaluate((value) => {
    for (const select of document.querySelectorAll('select')) {
      if (![...select.options].some((option) => option.value === value)) continue;
      select.value = value;
      select.dispatchEvent(new Event('change'));
    }
  }, tool);
}

async function pixel(x, y) {
  return page.evaluate(
    (x, y) => {
      const { left, top } = document.getElementById('picture').getBoundingClientRect();
      const place = window.__dynmesh.pixelOf(x, y);
      return { x: left + place.x, y: top + place.y };
    },
    x,
    y,
  );
}

async function click(x, y) {
  const at = await pixel(x, y);
  await page.mouse.click(at.x, at.y);
}

/** The features that the server has. */
async function features() {
  const chunks = await server.stream('GetFeatures', { mesh });
  return chunks.flatMap((chunk) => chunk.features ?? []);
}

/** True if the points that the server has are at these places. */
async function hasPoints(...places) {
  const points = (await features()).flatMap(({ point }) => (point ? [point] : []));
  return (
    points.length === places.length &&
    places.every(([x, y]) => points.some((point) => isAt(point, x, y)))
  );
}

async function drag(from, to, steps) {
  const [begin, end] = [await pixel(...from), await pixel(...to)];
  await page.mouse.move(begin.x, begin.y);
  await page.mouse.down();
  await page.mouse.move(end.x, end.y, { steps });
}

async function pointAt(x, y) {
  for (let tries = 0; ; ++tries) {
    const points = (await features()).flatMap(({ point }) => (point ? [point] : []));
    if (points.some((point) => isAt(point, x, y))) return;
    assert.ok(tries < 200, JSON.stringify(points));
    await sleep(50);
  }
}

/** The revision that the server has when it has had no edit for a while. */
async function rest() {
  for (let last = -1, quiet = 0; ; ++quiet) {
    const revision = Number((await server.call('GetMesh', { mesh })).revision ?? 0);
    if (revision !== last) quiet = 0;
    if (quiet === 10) return revision;
    last = revision;
    await sleep(30);
  }
}

/** Waits for that revision in the page, whose hash is the server's then. */
async function expectRevision(revision) {
  const copy = await atRevision(page, revision);
  const { hash, revision: present } = await server.call('GetMesh', { mesh });
  assert.equal(Number(present), revision);
  assert.equal(copy.hash, hash);
  assert.deepEqual(page.problems, []);
}

function isAt(point, x, y) {
  return Math.hypot(point.x - x, point.y - y) < 0.005;
}

test('points are added, dragged, removed; undone and done again', async () => {
  await choose('points');
  await click(0.3, 0.3);
  await expectRevision(1);
  await click(0.7, 0.3);
  await expectRevision(2);
  assert.ok(await hasPoints([0.3, 0.3], [0.7, 0.3]));

  await drag([0.7, 0.3], [0.6, 0.7], 12);
  await page.mouse.up();
  await page.waitForFunction(() => window.__dynmesh.revision > 2);
  // Wherever the drag was joined, its end is the last move.
  await pointAt(0.6, 0.7);
  assert.ok(await hasPoints([0.3, 0.3], [0.6, 0.7]));
  const dragged = await rest();
  assert.ok(dragged <= 2 + 13);
  await expectRevision(dragged);

  // The whole drag is undone at once.
  await page.keyboard.press('u');
  await expectRevision(dragged + 1);
  assert.ok(await hasPoints([0.3, 0.3], [0.7, 0.3]));
  await page.keyboard.press('u');
  await expectRevision(dragged + 2);
  assert.equal((await features()).length, 1);
  await page.keyboard.press('r');
  await expectRevision(dragged + 3);
  await page.keyboard.press('r');
  await expectRevision(dragged + 4);
  assert.ok(await hasPoints([0.3, 0.3], [0.6, 0.7]));

  await choose('remove');
  await click(0.6, 0.7);
  await expectRevision(dragged + 5);
  assert.equal((await features()).length, 1);
});

test('a change of another client is not undone', async () => {
  const { revision } = await server.call('GetMesh', { mesh });
  await server.edit(mesh, [{ add: { id: '99', point: { x: 0.9, y: 0.9 } } }]);
  await expectRevision(Number(revision) + 1);
  await page.keyboard.press('u');
  await page.waitForFunction(() =>
    document.getElementById('notice').textContent.startsWith('Another client'),
  );
  await expectRevision(Number(revision) + 1);
});

test('undo stops before a change of another client in between', async () => {
  await choose('points');
  const before = await features();
  let { revision } = await figures(page);
  await click(0.2, 0.1);
  await expectRevision(++revision);
  await server.edit(mesh, [{ add: { id: '100', point: { x: 0.8, y: 0.9 } } }]);
  await expectRevision(++revision);
  await click(0.5, 0.1);
  await expectRevision(++revision);
  await page.keyboard.press('u');
  await page.keyboard.press('u');
  await page.waitForFunction(() =>
    document.getElementById('notice').textContent.startsWith('Another client'),
  );
  await expectRevision(++revision);
  assert.equal((await features()).length, before.length + 2);
  assert.ok((await features()).some(({ id }) => id === '100'));
});

test('Escape or the browser ends a drag: what follows is undone by itself', async () => {
  await choose('points');
  const before = (await features()).length;
  const ends = [
    () => page.keyboard.press('Escape'),
    () =>
      page.$eval('#picture', (canvas) => {
        const event = { pointerId: 1, isPrimary: true, pointerType: 'mouse' };
        canvas.dispatchEvent(new PointerEvent('pointercancel', event));
      }),
  ];
  for (const [i, end] of ends.entries()) {
    await drag([0.2 + 0.05 * i, 0.1], [0.25 + 0.05 * i, 0.1], 3);
    await end();
    await page.mouse.up();
    await pointAt(0.25 + 0.05 * i, 0.1); // the last move of the drag
    let revision = await rest();
    for (const x of [0.4, 0.5, 0.6]) {
      await click(x, 0.03 + 0.05 * i);
      await expectRevision(++revision);
    }
    await page.keyboard.press('u');
    await expectRevision(++revision);
    assert.equal((await features()).length, before + 2 * (i + 1));
  }
});

test('a right click edits nothing', async () => {
  await choose('points');
  const { revision } = await figures(page);
  const at = await pixel(0.7, 0.03);
  await page.mouse.click(at.x, at.y, { button: 'right' });
  await page.keyboard.press('Escape');
  await click(0.75, 0.03);
  await atRevision(page, revision + 1);
  assert.equal(await rest(), revision + 1);
  await expectRevision(revision + 1);
});

test('a point whose id a size of another client has gets another id', async () => {
  await choose('points');
  let { revision } = await figures(page);
  const size = { point: { x: 0.05, y: 0.95 }, target: 0.1 };
  await server.edit(mesh, [{ add: { id: '4242', size } }]);
  await expectRevision(++revision);
  await page.evaluate(() => {
    const random = crypto.getRandomValues.bind(crypto);
    crypto.getRandomValues = (array) => {
      if (array.length !== 2) return random(array);
      delete crypto.getRandomValues;
      array.set([0, 4242]);
      return array;
    };
  });
  await click(0.95, 0.05);
  await expectRevision(++revision);
  assert.equal(await page.$eval('#notice', ({ hidden }) => hidden), true);
  const { size: kept } = (await features()).find(({ id }) => id === '4242');
  assert.deepEqual(kept, size);
  await server.edit(mesh, [{ remove: '4242' }]);
  await expectRevision(++revision);
});

test('segments, a polygon and a size are drawn; what crosses is refused where it does', async () => {
  let { revision } = await figures(page);
  await choose('segments');
  await click(0.1, 0.5);
  await click(0.4, 0.6);
  await expectRevision(++revision);
  await click(0.5, 0.9);
  await expectRevision(++revision);
  assert.equal((await features()).filter(({ segment }) => segment).length, 2);

  await page.keyboard.press('Escape');
  await click(0.2, 0.7);
  await click(0.3, 0.4);
  await page.waitForFunction(() => document.querySelectorAll('.mark').length > 0);
  assert.match(await page.$eval('#notice', ({ textContent }) => textContent), /cross/);
  await expectRevision(revision);
  await page.keyboard.press('Escape');
  assert.equal(await page.$$eval('.mark', ({ length }) => length), 0);

  await choose('polygon');
  for (const [x, y] of [
    [0.6, 0.1],
    [0.9, 0.1],
    [0.9, 0.25],
    [0.6, 0.25],
    [0.6, 0.1],
  ]) {
    await click(x, y);
  }
  await expectRevision(++revision);
  const [drawn] = (await features()).filter(({ polygon }) => polygon);
  assert.equal(drawn.polygon.rings[0].points.length, 4);

  await choose('size');
  await drag([0.75, 0.5], [0.85, 0.5], 3);
  await page.mouse.up();
  await expectRevision(++revision);
  const [{ size }] = (await features()).filter((feature) => feature.size);
  assert.ok(Math.abs(size.disc.radius - 0.1) < 0.01);
  await page.screenshot({ path: process.env.DYNMESH_WEB_SHOT ?? '/dev/null', type: 'png' });
});
