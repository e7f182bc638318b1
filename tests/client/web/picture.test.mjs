// What the page draws has the colours that it should, pixel by pixel; what the page costs.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { atRevision, Browser, figures } from './support/browser.mjs';
import { PNG } from './support/packages.mjs';
import { Plane, visible } from './support/plane.mjs';
import { Random } from './support/random.mjs';
import { Server } from './support/server.mjs';

// Of the light theme, and of cividis: as src/draw/palette.ts has them.
const PLAIN = [255, 255, 255];
const GLOW = [232, 113, 10];
const CIVIDIS = [
  '#00224e',
  '#083370',
  '#35456c',
  '#575d6d',
  '#7d7c78',
  '#a59c74',
  '#c8b866',
  '#e3d150',
  '#fee838',
].map((text) => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16)));

const box = { lo: { x: 0, y: 0 }, hi: { x: 1, y: 1 } };
let server;
let browser;

before(async () => {
  server = await Server.start('--watch-queue=4');
  browser = await Browser.start();
});
after(async () => {
  await browser?.close();
  await server?.stop();
});

function isNear(a, b, distance = 3) {
  return a.every((part, k) => Math.abs(part - b[k]) <= distance);
}

async function colours(page, seen) {
  return page.evaluate(
    (pixels) => window.__dynmesh.colours(pixels),
    seen.map(({ pixel }) => pixel),
  );
}

async function expectColours(page, seen, expected) {
  const found = await colours(page, seen);
  const wrong = seen
    .map((triangle, i) => ({
      triangle,
      found: found[i],
      expected: expected(triangle),
    }))
    .filter((row) => !isNear(row.found, row.expected));
  assert.deepEqual(wrong.slice(0, 3), [], `${wrong.length} of ${seen.length}`);
}

/** A batch, with the keys of the triangles that it brings. */
async function editWithDiff(mesh, edits) {
  const diffs = await server.stream('ApplyEdits', { mesh, edits });
  const ids = diffs.flatMap(({ addedSimplices }) => addedSimplices?.vertexIds ?? []);
  const added = new Set();
  for (let i = 0; i < ids.length; i += 3) added.add(ids.slice(i, i + 3).join());
  return { revision: Number(diffs.at(-1).toRevision), added };
}

test('triangles that have changed glow, others do not, and quality is the colour of its ramp', async () => {
  const random = new Random();
  const mesh = await server.create('glow', { box });
  const page = await browser.open(`${server.url}#mesh=glow`);
  let id = 1;
  const point = () => ({ x: random.next(), y: random.next() });
  const first = Array.from({ length: 40 }, () => ({
    add: { id: `${id++}`, point: point() },
  }));
  await atRevision(page, await server.edit(mesh, first));
  for (let step = 0; step < 6; ++step) {
    // The time between stands still: what changes now glows as on the first day.
    await page.evaluate(() => window.__dynmesh.freeze(true));
    const edits =
      step % 2 === 0
        ? [{ add: { id: `${id++}`, point: point() } }]
        : [{ move: { id: `${1 + random.below(40)}`, to: point() } }];
    // What was new before must be old: a page that was opened again has nothing that glows.
    await page.reload();
    await page.evaluate(() => window.__dynmesh.freeze(true));
    await atRevision(page, 1 + step);
    const { revision, added } = await editWithDiff(mesh, edits);
    await atRevision(page, revision);
    const seen = await visible(page, await Plane.of(server, mesh));
    const changed = seen.filter(({ ids }) => added.has(ids.join()));
    assert.ok(seen.length > 30, `${seen.length} triangles are seen`);
    assert.ok(changed.length > 0 || added.size < 3, 'a changed triangle is seen');
    await expectColours(page, seen, ({ ids }) => (added.has(ids.join()) ? GLOW : PLAIN));
  }

  // What the canvas has is on the screen.
  const [seen] = await visible(page, await Plane.of(server, mesh), 8);
  const corner = await page.$eval('#picture', (canvas) => {
    const { x, y } = canvas.getBoundingClientRect();
    return { x, y };
  });
  const shot = PNG.sync.read(Buffer.from(await page.screenshot()));
  const at =
    4 * (Math.floor(corner.y + seen.pixel.y) * shot.width + Math.floor(corner.x + seen.pixel.x));
  assert.ok(isNear([...shot.data.subarray(at, at + 3)], (await colours(page, [seen]))[0]));

  await page.reload();
  await atRevision(page, 7);
  await page.select('select', 'quality');
  const ramp = (value) => {
    const place = Math.min(Math.max(value, 0), 1) * 8;
    const index = Math.min(Math.floor(place), 7);
    return [0, 1, 2].map(
      (k) => CIVIDIS[index][k] + (CIVIDIS[index + 1][k] - CIVIDIS[index][k]) * (place - index),
    );
  };
  await expectColours(page, await visible(page, await Plane.of(server, mesh)), ({ quality }) =>
    ramp((quality - Math.SQRT2) / (1 / Math.sqrt(3) - Math.SQRT2)),
  );
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('a polygon has the colour of its region', async () => {
  const mesh = await server.create('region', { box });
  const page = await browser.open(`${server.url}#mesh=region&fill=region`);
  await atRevision(page, 0);
  const corners = [
    [0.2, 0.2],
    [0.7, 0.2],
    [0.7, 0.8],
    [0.2, 0.8],
  ];
  const revision = await server.edit(mesh, [
    ...corners.map(([x, y], i) => ({
      add: { id: `${i + 1}`, point: { x, y } },
    })),
    {
      add: { id: '9', polygon: { rings: [{ points: ['1', '2', '3', '4'] }] } },
    },
  ]);
  await page.reload();
  await atRevision(page, revision);
  const seen = await visible(page, await Plane.of(server, mesh));
  assert.ok(seen.some(({ region }) => region === '9') && seen.some(({ region }) => region === '0'));
  // 9 is the second of eight colours.
  await expectColours(page, seen, ({ region }) => (region === '9' ? [230, 159, 0] : PLAIN));
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('input points are small dots, and none where they are dense', async () => {
  const POINT = [17, 24, 39];
  const mesh = await server.create('dots', { box });
  const page = await browser.open(`${server.url}#mesh=dots&hide=edges+segments`);
  await atRevision(page, 0);
  const places = await page.evaluate(() => {
    const { width, height } = document.getElementById('picture').getBoundingClientRect();
    const scale = window.__dynmesh.pixelOf(1, 0).x - window.__dynmesh.pixelOf(0, 0).x;
    return { width, height, scale };
  });
  // Two alone, then a row of points half a pixel apart.
  const alone = [
    [0.25, 0.2],
    [0.6, 0.25],
  ];
  const row = Array.from({ length: 200 }, (_, i) => [0.4 + (0.5 * i) / places.scale, 0.7]);
  const revision = await server.edit(
    mesh,
    [...alone, ...row].map(([x, y], i) => ({ add: { id: `${i + 1}`, point: { x, y } } })),
  );
  await page.reload();
  await atRevision(page, revision);
  const around = (x, y, width) =>
    page.evaluate(
      (x, y, width) => {
        const middle = window.__dynmesh.pixelOf(x, y);
        const pixels = [];
        for (let dx = -width; dx <= width; ++dx) {
          for (let dy = -5; dy <= 5; ++dy) pixels.push({ x: middle.x + dx, y: middle.y + dy });
        }
        return window.__dynmesh.colours(pixels);
      },
      x,
      y,
      width,
    );
  const dark = async (x, y, width) =>
    (await around(x, y, width)).filter((colour) => isNear(colour, POINT)).length;
  for (const [x, y] of alone) {
    const pixels = await dark(x, y, 5);
    assert.ok(pixels >= 4 && pixels <= 9, `${pixels} pixels of a point`);
  }
  assert.equal(await dark(0.4 + 50 / places.scale, 0.7, 40), 0);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('the picture comes back after the graphics card was lost', async () => {
  const mesh = await server.create('reset', { box });
  const page = await browser.open(`${server.url}#mesh=reset&fill=region`);
  await atRevision(page, 0);
  const corners = ['0.2 0.2', '0.8 0.2', '0.8 0.8', '0.2 0.8'].map((text) => text.split(' '));
  const revision = await server.edit(mesh, [
    ...corners.map(([x, y], i) => ({ add: { id: `${i + 1}`, point: { x: +x, y: +y } } })),
    { add: { id: '9', polygon: { rings: [{ points: ['1', '2', '3', '4'] }] } } },
  ]);
  await page.reload();
  await atRevision(page, revision);
  const seen = await visible(page, await Plane.of(server, mesh));
  const expected = ({ region }) => (region === '9' ? [230, 159, 0] : PLAIN);
  await expectColours(page, seen, expected);
  const notice = () => page.$eval('#notice', ({ textContent }) => textContent);
  await page.evaluate(() => {
    const canvas = document.getElementById('picture');
    window.lose = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
    const lost = new Promise((done) => canvas.addEventListener('webglcontextlost', done));
    window.lose.loseContext();
    return lost.then(() => undefined);
  });
  assert.match(await notice(), /lost the graphics card/);
  await page.evaluate(() => {
    const canvas = document.getElementById('picture');
    const restored = new Promise((done) => canvas.addEventListener('webglcontextrestored', done));
    window.lose.restoreContext();
    return restored.then(() => undefined);
  });
  await expectColours(page, seen, expected);
  assert.equal(await notice(), '');
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('a mesh that is too large for the graphics card is not drawn, and the page says so', async () => {
  const mesh = await server.create('large', { box });
  await server.create('small', { box });
  const revision = await server.edit(mesh, [{ add: { id: '1', size: { box, target: 0.02 } } }]);
  const page = await browser.open('about:blank');
  await page.evaluateOnNewDocument(() => {
    const { getParameter } = WebGL2RenderingContext.prototype;
    WebGL2RenderingContext.prototype.getParameter = function (name) {
      return name === this.MAX_TEXTURE_SIZE ? 1 : getParameter.call(this, name);
    };
  });
  await page.goto(`${server.url}#mesh=large`);
  const { counts } = await atRevision(page, revision);
  assert.ok(counts.cells > 2048);
  const hasNotice = (wanted) =>
    page.waitForFunction(
      (wanted) => document.getElementById('notice').textContent.includes('larger') === wanted,
      {},
      wanted,
    );
  await hasNotice(true);
  await page.evaluate(() => {
    location.hash = '#mesh=small';
  });
  await hasNotice(false);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('a cut through a closed surface shows the region inside', async () => {
  const space = { lo: { x: 0, y: 0, z: 0 }, hi: { x: 1, y: 1, z: 1 } };
  const mesh = await server.create('cut', { dimension: 3, box: space });
  const corner = (i, axis) => 0.1 + 0.8 * ((i >> axis) & 1);
  const faces = ['1342', '5687', '1265', '3784', '1573', '2486'];
  const revision = await server.edit(mesh, [
    ...Array.from({ length: 8 }, (_, i) => ({
      add: { id: `${i + 1}`, point: { x: corner(i, 0), y: corner(i, 1), z: corner(i, 2) } },
    })),
    ...faces.map((face, i) => ({
      add: { id: `${11 + i}`, polygon: { rings: [{ points: [...face] }] } },
    })),
  ]);
  const page = await browser.open(`${server.url}#mesh=cut&fill=region&hide=edges&clip=y+0.45`);
  await atRevision(page, revision);
  const chunks = await server.stream('GetSnapshot', { mesh });
  const regions = new Set(chunks.flatMap(({ simplices }) => simplices?.regions ?? []));
  regions.delete('0');
  assert.equal(regions.size, 1);
  // As src/draw/palette.ts has them.
  const okabe = [
    '#56b4e9',
    '#e69f00',
    '#009e73',
    '#cc79a7',
    '#f0e442',
    '#0072b2',
    '#d55e00',
    '#8c8c8c',
  ];
  const colour = okabe[Number([...regions][0]) % 8];
  const expected = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
  await page.waitForFunction(
    (wanted) => {
      const { width, height } = document.getElementById('picture').getBoundingClientRect();
      const [found] = window.__dynmesh.colours([{ x: width / 2, y: height / 2 }]);
      return found.every((part, k) => Math.abs(part - wanted[k]) <= 3);
    },
    { polling: 100, timeout: 20000 },
    expected,
  );
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('a diff uploads 64 bytes a changed triangle at most, and takes little time', async () => {
  const mesh = await server.create('cost', { box });
  const target = 0.01;
  await server.edit(mesh, [{ add: { id: '1', size: { box, target } } }]);
  const page = await browser.open(`${server.url}#mesh=cost`);
  let before = await atRevision(page, 1);
  await sleep(500);
  before = await figures(page);
  const times = [];
  for (let i = 0; i < 20; ++i) {
    const { revision, added } = await editWithDiff(mesh, [
      {
        add: {
          id: `${10 + i}`,
          size: {
            disc: { centre: { x: 0.1 + 0.04 * i, y: 0.5 }, radius: 5 * target },
            target: target / 2,
          },
        },
      },
    ]);
    const frame = before.frames;
    await atRevision(page, revision);
    await page.waitForFunction((n) => window.__dynmesh.frames > n + 1, {}, frame);
    const now = await figures(page);
    // A row of what is drawn is 16 bytes and its number 4; the rows before go first.
    assert.ok(
      now.bytes - before.bytes <= 64 * added.size + 2048 * 16,
      `${now.bytes - before.bytes} bytes for ${added.size} triangles`,
    );
    times.push(now.milliseconds.take + now.milliseconds.update);
    before = now;
  }
  times.sort((a, b) => a - b);
  console.log(
    `${before.counts.cells} triangles, a diff of 300: ${times[10]} ms of JavaScript (median), ${times[0]} (least)`,
  );
  await page.close();
});

test('a page that does not keep up gets joined diffs, and a page that is not seen none', async () => {
  const mesh = await server.create('slow', { box });
  const page = await browser.open(`${server.url}#mesh=slow`);
  await atRevision(page, 0);
  // As a page whose scripts are kept busy, without the load.
  const debug = await page.createCDPSession();
  await debug.send('Debugger.enable');
  await debug.send('Debugger.pause');
  const edits = 50;
  let revision = 0;
  for (let i = 0; i < edits; ++i) {
    const edit = i % 2 === 0 ? { add: { id: '1', size: { box, target: 0.01 } } } : { remove: '1' };
    revision = await server.edit(mesh, [edit]);
  }
  await debug.send('Debugger.resume');
  await debug.detach();
  const after = await atRevision(page, revision);
  console.log(`${edits} edits came as ${after.diffs} diffs`);
  assert.equal(after.hash, (await server.call('GetMesh', { mesh })).hash);
  assert.ok(after.diffs < edits);

  // Another tab in front of it.
  const watchers = async () => Number((await server.call('GetStats', { mesh })).mesh.watchers ?? 0);
  assert.equal(await watchers(), 1);
  const other = await page.browserContext().newPage();
  await page.evaluate(() => {
    Object.defineProperty(document, 'hidden', {
      value: true,
      configurable: true,
    });
    document.dispatchEvent(new Event('visibilitychange'));
  });
  for (let tries = 0; (await watchers()) > 0; ++tries) {
    assert.ok(tries < 100, 'the watch ends');
    await sleep(50);
  }
  revision = await server.edit(mesh, [{ add: { id: '5', point: { x: 0.5, y: 0.5 } } }]);
  const { frames } = await figures(page);
  await sleep(300);
  assert.equal((await figures(page)).frames, frames);
  await other.close();
  await page.evaluate(() => {
    delete document.hidden;
    document.dispatchEvent(new Event('visibilitychange'));
  });
  await atRevision(page, revision);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('memory stays flat over many diffs', async () => {
  const diffs = process.env.DYNMESH_NIGHTLY ? 10_000 : 300;
  const mesh = await server.create('heap', { box });
  const page = await browser.open(`${server.url}#mesh=heap`, {
    width: 640,
    height: 480,
  });
  await atRevision(page, 0);
  const heap = async () => {
    return page.evaluate(() => {
      window.gc();
      return performance.memory.usedJSHeapSize;
    });
  };
  const change = async (count) => {
    let revision = 0;
    for (let i = 0; i < count; ++i) {
      const place = {
        x: 0.5 + 0.3 * Math.cos(i / 10),
        y: 0.5 + 0.3 * Math.sin(i / 10),
      };
      revision = await server.edit(mesh, [{ set: { id: '1', point: place } }]);
    }
    await atRevision(page, revision, 60000);
  };
  await server.edit(mesh, [{ add: { id: '1', point: { x: 0.5, y: 0.5 } } }]);
  await change(diffs / 3);
  const kept = () => page.evaluate(() => window.__dynmesh.kept);
  const early = { bytes: await heap(), kept: await kept() };
  await change(diffs);
  const late = { bytes: await heap(), kept: await kept() };
  console.log(`${diffs / 3} and ${(diffs * 4) / 3} diffs: ${JSON.stringify([early, late])}`);
  assert.ok(late.kept <= 1000);
  // The past that can be gone back to takes some kB a revision, and ends at 1,000 of them.
  const most = early.bytes * 1.1 + 1e6 + 8e3 * (late.kept - early.kept);
  assert.ok(late.bytes < most, `${early.bytes} bytes have become ${late.bytes}`);
  await page.close();
});
