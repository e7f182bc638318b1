// Packages of the page, which has the only package.json of the project. DYNMESH_WEB: the folder where
// they are installed, if not that.
import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../../../..", import.meta.url));
export const web = process.env.DYNMESH_WEB ?? `${root}client/web`;

const require = createRequire(`${web}/package.json`);
export const puppeteer = require("puppeteer-core");
export const { PNG } = require("pngjs");
export const axeSource = require("axe-core").source;
