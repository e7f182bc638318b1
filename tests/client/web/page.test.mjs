// The page itself: no fault that axe finds, nothing from another server, no exception of its policy.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { atRevision, Browser } from './support/browser.mjs';
import { axeSource } from './support/packages.mjs';
import { Server } from './support/server.mjs';

let server;
let browser;

before(async () => {
  server = await Server.start();
  browser = await Browser.start();
  await server.create('plate', {
    box: { lo: { x: 0, y: 0 }, hi: { x: 1, y: 1 } },
  });
});
after(async () => {
  await browser?.close();
  await server?.stop();
});

for (const scheme of ['light', 'dark']) {
  test(`axe finds no serious fault in the ${scheme} page`, async () => {
    const page = await browser.open('about:blank');
    await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
    await page.goto(`${server.url}#mesh=plate&fill=quality`);
    await atRevision(page, 0);
    await page.evaluate(axeSource); // by the debugger, which the page's policy does not bind
    const { violations, passes } = await page.evaluate(() => window.axe.run());
    const serious = violations
      .filter(({ impact }) => impact === 'serious' || impact === 'critical')
      .map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(' ')}`);
    assert.deepEqual(serious, []);
    assert.ok(passes.length > 10);
    await page.close();
  });
}

test('everything comes from the server', async () => {
  const page = await browser.open(`${server.url}#mesh=plate`);
  await atRevision(page, 0);
  const others = page.requested.filter(
    (url) => !url.startsWith(server.url) && !url.startsWith('data:'),
  );
  assert.deepEqual(others, []);
  assert.ok(page.requested.length > 4);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('a script or a style in the page is refused', async () => {
  const page = await browser.open(server.url);
  const ran = await page.evaluate(() => {
    const script = document.createElement('script');
    script.textContent = 'window.ran = true';
    document.body.append(script);
    return window.ran === true;
  });
  assert.equal(ran, false);
  assert.ok(page.problems.some((text) => text.includes('Content Security Policy')));
  await page.close();
});

test('a mesh that does not exist is named, with what the server says', async () => {
  const page = await browser.open(`${server.url}#mesh=none`);
  await page.waitForFunction(() => !document.getElementById('notice').hidden);
  assert.match(await page.$eval('#notice', (notice) => notice.textContent), /none/);
  await page.close();
});

test('the page goes back along its past and to the present again, and its link leads to the same', async () => {
  const mesh = await server.create('past', { box: { lo: { x: 0, y: 0 }, hi: { x: 1, y: 1 } } });
  const page = await browser.open(`${server.url}#mesh=past`);
  const hashes = [(await atRevision(page, 0)).hash];
  for (let i = 1; i <= 4; ++i) {
    const point = { x: 0.2 * i, y: 0.3 };
    const revision = await server.edit(mesh, [{ add: { id: `${i}`, point } }]);
    hashes.push((await atRevision(page, revision)).hash);
  }
  const state = () => page.evaluate(() => [window.__dynmesh.revision, window.__dynmesh.hash]);
  for (let i = 3; i >= 1; --i) {
    await page.keyboard.press('[');
    assert.deepEqual(await state(), [i, hashes[i]]);
  }
  await page.keyboard.press(']');
  assert.deepEqual(await state(), [2, hashes[2]]);
  // What happens meanwhile is seen when the page goes on.
  const revision = await server.edit(mesh, [{ remove: '1' }]);
  assert.deepEqual(await state(), [2, hashes[2]]);
  await page.keyboard.press(' ');
  assert.equal(
    (await atRevision(page, revision)).hash,
    (await server.call('GetMesh', { mesh })).hash,
  );

  await page.keyboard.press('2');
  await page.keyboard.press('+');
  await page.keyboard.press('ArrowLeft');
  const place = () => page.evaluate(() => window.__dynmesh.pixelOf(0.4, 0.3));
  const before = await place();
  const url = page.url();
  assert.match(url, /fill=quality.*view=/);
  const other = await browser.open(url);
  await atRevision(other, revision);
  await page.bringToFront();
  const after = await other.evaluate(() => window.__dynmesh.pixelOf(0.4, 0.3));
  assert.ok(
    Math.hypot(after.x - before.x, after.y - before.y) < 0.01,
    JSON.stringify([before, after]),
  );
  assert.deepEqual([...page.problems, ...other.problems], []);
  await page.close();
  await other.close();
});

const METHODS = '/dynmesh.v1.MeshService/';

/** A page whose calls are answered by `answer(method, headers)`, or by the server if it gives nothing. */
async function openIntercepted(url, answer) {
  const page = await browser.open('about:blank');
  await page.setRequestInterception(true);
  page.on('request', (request) => {
    const at = request.url().indexOf(METHODS);
    const error =
      at < 0 ? undefined : answer(request.url().slice(at + METHODS.length), request.headers());
    if (error === undefined) {
      request.continue();
      return;
    }
    request.respond({
      status: error.status,
      contentType: 'application/json',
      body: JSON.stringify({ code: error.code, message: error.message }),
    });
  });
  await page.goto(url);
  return page;
}

function noticeHas(page, text) {
  return page.waitForFunction(
    (wanted) => document.getElementById('notice').textContent.includes(wanted),
    {},
    text,
  );
}

test('of meshes that are chosen in quick succession only the last is watched', async () => {
  const box = { lo: { x: 0, y: 0 }, hi: { x: 1, y: 1 } };
  const meshes = [await server.create('aa', { box }), await server.create('bb', { box })];
  const page = await browser.open(server.url);
  await page.evaluate(async () => {
    for (const id of ['aa', 'bb', 'aa', 'bb', 'aa']) {
      location.hash = `#mesh=${id}`;
      await new Promise((done) => addEventListener('hashchange', done, { once: true }));
    }
  });
  await atRevision(page, 0);
  const watchers = async () => {
    const stats = await Promise.all(meshes.map((mesh) => server.call('GetStats', { mesh })));
    return stats.map(({ mesh }) => Number(mesh.watchers ?? 0)).join();
  };
  for (let tries = 0; (await watchers()) !== '1,0'; ++tries) {
    assert.ok(tries < 100, await watchers());
    await sleep(50);
  }
  await server.edit(meshes[0], [{ add: { id: '1', point: { x: 0.5, y: 0.5 } } }]);
  await atRevision(page, 1);
  assert.equal(await watchers(), '1,0');
  // What goes wrong with a mesh that is no longer chosen is not said.
  await page.evaluate(() => {
    location.hash = '#mesh=none';
    location.hash = '#mesh=bb';
  });
  await page.waitForFunction(() => document.getElementById('title').textContent === 'bb');
  await atRevision(page, 0);
  assert.equal(await page.$eval('#notice', ({ hidden }) => hidden), true);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('a mesh is opened when the server is ready, though it was not at first', async () => {
  let refused = 0;
  const page = await openIntercepted(`${server.url}#mesh=plate`, (method) => {
    if (method !== 'GetMesh' || ++refused > 3) return undefined;
    return { status: 503, code: 'unavailable', message: 'RECOVERING' };
  });
  await atRevision(page, 0);
  assert.equal(await page.$eval('#notice', ({ hidden }) => hidden), true);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('a token is asked for, and then what was refused goes on', async () => {
  let isStrict = false;
  const page = await openIntercepted(`${server.url}#mesh=plate`, (method, { authorization }) => {
    if (authorization === 'Bearer good' || (!isStrict && method !== 'Watch')) return undefined;
    isStrict = true; // the watch was the first call that is refused
    return { status: 401, code: 'unauthenticated', message: 'TOKEN_MISSING' };
  });
  await page.waitForSelector('#meshes form');
  await noticeHas(page, 'TOKEN_MISSING');
  await page.type('#meshes input', 'schlüssel');
  await page.click('#meshes button');
  await page.waitForFunction(() =>
    document.querySelector('#meshes .bad').textContent.startsWith('A token has'),
  );
  await page.$eval('#meshes input', (input) => {
    input.value = 'good';
  });
  await page.click('#meshes button');
  await atRevision(page, 0);
  await page.waitForFunction(() => document.getElementById('notice').hidden);
  assert.equal(await page.$('#meshes form'), null);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('a mesh without figures leaves the others in the list', async () => {
  const page = await openIntercepted(server.url, (method) =>
    method === 'GetStats' ? { status: 500, code: 'data_loss', message: 'MESH_DAMAGED' } : undefined,
  );
  await page.waitForSelector('#meshes a[href="#mesh=plate"]');
  assert.equal(await page.$eval('#notice', ({ hidden }) => hidden), true);
  await page.close();
});

test('without WebGL the page says so, and has the rest', async () => {
  const page = await browser.open('about:blank');
  await page.evaluateOnNewDocument(() => {
    const { getContext } = HTMLCanvasElement.prototype;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
      return kind.startsWith('webgl') ? null : getContext.call(this, kind, ...rest);
    };
  });
  await page.goto(`${server.url}#mesh=plate`);
  await atRevision(page, 0);
  await noticeHas(page, 'no WebGL 2');
  await page.waitForSelector('#meshes a[href="#mesh=plate"]');
  assert.deepEqual(
    page.problems.filter((text) => !text.includes('WebGL')),
    [],
  );
  await page.close();
});

test('statistics that a hidden tab has cut off are made when it is seen again', async () => {
  const mesh = await server.create('survey', { box: { lo: { x: 0, y: 0 }, hi: { x: 1, y: 1 } } });
  const page = await browser.open(`${server.url}#mesh=survey`);
  await atRevision(page, 0);
  await page.waitForSelector('#panel figure');
  const revision = await server.edit(mesh, [{ add: { id: '1', point: { x: 0.3, y: 0.2 } } }]);
  await atRevision(page, revision);
  await page.evaluate(() => {
    for (const figure of document.querySelectorAll('#panel figure')) figure.className = 'old';
    Object.defineProperty(document, 'hidden', { value: true, configurable: true });
    document.dispatchEvent(new Event('visibilitychange'));
  });
  await sleep(1500); // the survey is due within a second
  await page.evaluate(() => {
    delete document.hidden;
    document.dispatchEvent(new Event('visibilitychange'));
  });
  await page.waitForSelector('#panel figure:not(.old)');
  assert.deepEqual(page.problems, []);
  await page.close();
});
