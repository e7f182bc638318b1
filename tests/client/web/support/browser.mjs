// A headless Chromium, and pages in it that fail the test if something goes wrong in them.
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { puppeteer } from './packages.mjs';

const PROGRAM = process.env.CHROMIUM ?? '/usr/bin/chromium';

export class Browser {
  #folder = mkdtempSync(join(tmpdir(), 'dynmesh-chromium-'));
  #browser;

  static async start() {
    if (!existsSync(PROGRAM)) throw new Error(`there is no ${PROGRAM}: install chromium`);
    const result = new Browser();
    result.#browser = await puppeteer.launch({
      executablePath: PROGRAM,
      userDataDir: result.#folder,
      args: [
        '--headless',
        '--no-sandbox',
        '--use-angle=swiftshader',
        '--enable-unsafe-swiftshader',
        '--disable-dev-shm-usage',
        '--enable-precise-memory-info',
        '--js-flags=--expose-gc',
      ],
    });
    return result;
  }

  /** A page at this address; `problems` collects what its console and policy complain of. */
  async open(url, size = { width: 1000, height: 700 }) {
    const page = await this.#browser.newPage({ type: 'window' }); // a tab behind others is not seen
    await page.setViewport(size);
    page.problems = [];
    page.requested = [];
    page.on('pageerror', (error) => page.problems.push(`error: ${error.stack ?? error}`));
    page.on('console', (message) => {
      // A lost connection is reported by the browser itself, too.
      const isLost = /Failed to load resource|net::ERR/.test(message.text());
      if (['error', 'warn'].includes(message.type()) && !isLost) {
        page.problems.push(`${message.type()}: ${message.text()}`);
      }
    });
    page.on('request', (request) => page.requested.push(request.url()));
    await page.goto(url);
    return page;
  }

  async close() {
    await this.#browser.close();
    rmSync(this.#folder, { recursive: true, force: true });
  }
}

/** Waits until the page's copy is live and at that revision; its figures. */
export async function atRevision(page, revision, timeout = 20000) {
  try {
    await page.waitForFunction(
      (wanted) =>
        window.__dynmesh?.connection === 'live' &&
        window.__dynmesh.hash !== '' &&
        window.__dynmesh.revision >= wanted,
      { timeout, polling: 20 },
      revision,
    );
  } catch (error) {
    const state = await figures(page);
    throw new Error(`no revision ${revision}: ${JSON.stringify(state)} ${page.problems}`, {
      cause: error,
    });
  }
  return figures(page);
}

export function figures(page) {
  return page.evaluate(() => {
    const d = window.__dynmesh;
    return {
      revision: d.revision,
      hash: d.hash,
      connection: d.connection,
      diffs: d.diffs,
      frames: d.frames,
      counts: d.counts,
      bytes: d.bytesUploaded,
      milliseconds: d.milliseconds,
    };
  });
}
