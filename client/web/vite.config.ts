import { defineConfig } from 'vitest/config';
import { licences } from './licences.js';

// The server has the page's files in itself, under these names: they do not change from build to
// build, and there is no file that a network beyond the server would have to give.
export default defineConfig({
  base: './',
  plugins: [licences('node_modules/typescript/LICENSE.txt')],
  build: {
    target: 'es2022',
    assetsInlineLimit: 0,
    modulePreload: false,
    chunkSizeWarningLimit: 1000,
    rollupOptions: {
      output: {
        entryFileNames: 'app.js',
        chunkFileNames: '[name].js',
        assetFileNames: 'app[extname]',
      },
    },
  },
  worker: { format: 'es', rollupOptions: { output: { entryFileNames: '[name].js' } } },
  // `npx vite` with a server that was started with --http 127.0.0.1:8080.
  server: {
    proxy: {
      '/dynmesh.v1.MeshService': {
        target: process.env.DYNMESHD ?? 'http://127.0.0.1:8080',
        changeOrigin: true,
        configure: (proxy) => {
          // The page is of another port here, which the server would refuse.
          proxy.on('proxyReq', (request) => {
            request.removeHeader('origin');
            request.removeHeader('sec-fetch-site');
          });
        },
      },
    },
  },
  test: { include: ['test/**/*.test.ts'], setupFiles: ['test/browser.ts'] },
});
