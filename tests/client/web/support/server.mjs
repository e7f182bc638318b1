// A dynmeshd (DYNMESHD, or that of build/release) with a folder of its own, which can be restarted,
// and calls of its methods as JSON. Its page is the one that it has in itself, or that of the folder
// DYNMESH_WEB_DIST.
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { root } from './packages.mjs';
import { startFront } from './front.mjs';

const PROGRAM = process.env.DYNMESHD ?? `${root}build/release/bin/dynmeshd`;

async function freePort() {
  const server = createServer();
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  const { port } = server.address();
  await new Promise((resolve) => server.close(resolve));
  return port;
}

export class Server {
  #folder = mkdtempSync(join(tmpdir(), 'dynmesh-web-'));
  #process;
  #front;
  #options;

  static async start(...options) {
    const server = new Server();
    server.#options = options;
    server.port = await freePort();
    await server.#run();
    const dist = process.env.DYNMESH_WEB_DIST;
    if (dist !== undefined) server.#front = await startFront(dist, () => server.port);
    return server;
  }

  /** Of the page. */
  get url() {
    return this.#front?.url ?? `http://127.0.0.1:${this.port}/`;
  }

  async #run() {
    this.#process = spawn(
      PROGRAM,
      [
        '--listen=127.0.0.1:0',
        `--http=127.0.0.1:${this.port}`,
        `--data-dir=${this.#folder}/data`,
        '--log-level=warning',
        ...this.#options,
      ],
      { stdio: ['ignore', 'inherit', 'inherit'] },
    );
    this.#process.once('error', (error) => {
      throw error;
    });
    for (let tries = 0; ; ++tries) {
      try {
        await this.call('ListMeshes', {});
        return;
      } catch (error) {
        if (tries === 200) throw error;
        await sleep(50);
      }
    }
  }

  /** Ends it at once, as a crash does, and starts it again. */
  async restart(pause = 0) {
    await this.#end('SIGKILL');
    await sleep(pause);
    await this.#run();
  }

  async stop() {
    await this.#end('SIGTERM');
    await this.#front?.close();
    rmSync(this.#folder, { recursive: true, force: true });
  }

  async #end(signal) {
    const ended = new Promise((resolve) => this.#process.once('exit', resolve));
    this.#process.kill(signal);
    await ended;
  }

  /** A method with one answer. */
  async call(method, message) {
    const answer = await fetch(this.#address(method), {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify(message),
    });
    const result = await answer.json();
    if (!answer.ok) throw Object.assign(new Error(result.message), { code: result.code });
    return result;
  }

  /** A method with a stream of answers: all of them. */
  async stream(method, message) {
    const body = Buffer.from(JSON.stringify(message));
    const head = Buffer.alloc(5);
    head.writeUInt32BE(body.length, 1);
    const answer = await fetch(this.#address(method), {
      method: 'POST',
      headers: { 'Content-Type': 'application/connect+json' },
      body: Buffer.concat([head, body]),
    });
    const bytes = Buffer.from(await answer.arrayBuffer());
    const messages = [];
    for (let at = 0; at < bytes.length; ) {
      const length = bytes.readUInt32BE(at + 1);
      const result = JSON.parse(bytes.subarray(at + 5, at + 5 + length).toString());
      if (bytes[at] & 2) {
        if (result.error) {
          throw Object.assign(new Error(result.error.message), {
            code: result.error.code,
          });
        }
        return messages;
      }
      messages.push(result);
      at += 5 + length;
    }
    throw new Error(`${method} was cut off`);
  }

  /** One batch; its revision. */
  async edit(mesh, edits) {
    const diffs = await this.stream('ApplyEdits', {
      mesh,
      edits,
      omitColumns: true,
    });
    return Number(diffs.at(-1).toRevision ?? 0);
  }

  async create(id, options) {
    await this.call('CreateMesh', { meshId: id, options });
    return `meshes/${id}`;
  }

  #address(method) {
    return `http://127.0.0.1:${this.port}/dynmesh.v1.MeshService/${method}`;
  }
}
