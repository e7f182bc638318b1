// Packages of the page, which has the only package.json of the project. DYNMESH_WEB_MODULES is the
// folder that has its node_modules, if that is not client/web.
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';

export const root = fileURLToPath(new URL('../../../..', import.meta.url));

const require = createRequire(
  `${process.env.DYNMESH_WEB_MODULES ?? `${root}client/web`}/package.json`,
);
export const puppeteer = require('puppeteer-core');
export const { PNG } = require('pngjs');
export const axeSource = require('axe-core').source;
