#!/usr/bin/env node
// Derives coastline-110m.node from the npm package world-atlas. Run once, by hand; the
// result is committed, so that nobody needs node or the network to use it.
//
//   npm pack world-atlas@2.0.2 && tar xzf world-atlas-2.0.2.tgz
//   deploy/data/derive-coastline.mjs package/land-110m.json > deploy/data/coastline-110m.node
//
// Source:  Natural Earth, 1:110m land polygons, in the public domain
//          (https://www.naturalearthdata.com/about/terms-of-use/), as packed into
//          TopoJSON by world-atlas 2.0.2 (ISC licence, Michael Bostock).
// Result:  the vertices of all arcs, in file order, each once: 4,996 points. Coordinates
//          are the TopoJSON's own quantised integers, eastward and northward; eastward
//          doubled, because 360 degrees have as many steps there as 169 northward.
import {readFileSync} from 'node:fs';

if (process.argv.length !== 3) {
  console.error('usage: derive-coastline.mjs LAND-110M.JSON > coastline-110m.node');
  process.exit(2);
}
const topology = JSON.parse(readFileSync(process.argv[2], 'utf8'));
if (topology.type !== 'Topology' || !topology.transform) {
  console.error(`${process.argv[2]}: no quantised TopoJSON`);
  process.exit(2);
}

const points = new Set();  // keeps the order of insertion
for (const arc of topology.arcs) {
  let east = 0;  // an arc is a first point and steps from it
  let north = 0;
  for (const [dx, dy] of arc) {
    east += dx;
    north += dy;
    points.add(`${2 * east} ${north}`);
  }
}

console.log('# Vertices of the world\'s coastlines at 1:110 million. Natural Earth, public domain;');
console.log('# by way of npm world-atlas 2.0.2 (ISC), land-110m.json. See derive-coastline.mjs.');
console.log(`${points.size} 2 0 0`);
let number = 0;
for (const point of points) console.log(`${++number} ${point}`);
