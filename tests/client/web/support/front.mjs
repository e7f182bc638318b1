// Serves a folder with a build of the page as dynmeshd does with the one that it has in itself, and
// hands calls on to a dynmeshd: to test a page that no dynmeshd has yet.
import { readFileSync } from 'node:fs';
import { createServer, request } from 'node:http';
import { extname } from 'node:path';

export const POLICY =
  "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; " +
  "img-src 'self' data: blob:; worker-src 'self'";

const types = {
  '.html': 'text/html',
  '.js': 'text/javascript',
  '.css': 'text/css',
};

/** A server on a free port; `backend()` is the port of dynmeshd. */
export async function startFront(folder, backend) {
  const server = createServer((asked, answer) => {
    if (asked.method === 'GET') {
      serveFile(folder, asked, answer);
      return;
    }
    const { origin: _, 'sec-fetch-site': __, ...headers } = asked.headers;
    headers.host = `127.0.0.1:${backend()}`;
    const handed = request(
      {
        host: '127.0.0.1',
        port: backend(),
        path: asked.url,
        method: asked.method,
        headers,
      },
      (result) => {
        answer.writeHead(result.statusCode, result.headers);
        result.pipe(answer);
        result.on('error', () => answer.destroy());
      },
    );
    handed.on('error', () => answer.destroy());
    answer.on('close', () => handed.destroy());
    asked.pipe(handed);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}/`,
    close: () => {
      server.closeAllConnections();
      return new Promise((resolve) => server.close(resolve));
    },
  };
}

function serveFile(folder, asked, answer) {
  const name = asked.url === '/' ? '/index.html' : asked.url;
  try {
    if (!/^\/[\w-]+\.(html|js|css|txt)$/.test(name)) throw new Error('no such file');
    const body = readFileSync(folder + name);
    answer.writeHead(200, {
      'Content-Type': types[extname(name)],
      'Content-Security-Policy': POLICY,
      'X-Content-Type-Options': 'nosniff',
    });
    answer.end(body);
  } catch {
    answer.writeHead(404).end();
  }
}
