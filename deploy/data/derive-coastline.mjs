#!/usr/bin/env node
// Derives coastline-110m.poly from the npm package world-atlas. Run once, by hand; the
// result is committed, so that no build needs node or the network to use it.
//
//   npm pack world-atlas@2.0.2 && tar xzf world-atlas-2.0.2.tgz
//   deploy/data/derive-coastline.mjs package/land-110m.json > deploy/data/coastline-110m.poly
//
// Source:  Natural Earth, 1:110m land polygons, in the public domain
//          (https://www.naturalearthdata.com/about/terms-of-use/), as packed into
//          TopoJSON by world-atlas 2.0.2 (ISC licence, Michael Bostock).
// Result:  the vertices of all arcs, in file order, each once: 4,996 points, and the 4,992
//          segments between one and the next of an arc, each once. Coordinates are the
//          TopoJSON's own quantised integers, eastward and northward; eastward doubled,
//          because 360 degrees have as many steps there as 169 northward. Segments across
//          the date line are left out.
import {readFileSync} from 'node:fs';

if (process.argv.length !== 3) {
  console.error('usage: derive-coastline.mjs LAND-110M.JSON > coastline-110m.poly');
  process.exit(2);
}
const topology = JSON.parse(readFileSync(process.argv[2], 'utf8'));
if (topology.type !== 'Topology' || !topology.transform) {
  console.error(`${process.argv[2]}: no quantised TopoJSON`);
  process.exit(2);
}

const HALF_THE_WORLD = 99999;  // what is longer runs round the back of the map
const numbers = new Map();  // of the points, by place; keeps the order of insertion
const segments = new Map();  // by their ends, the lesser first
for (const arc of topology.arcs) {
  let east = 0;  // an arc is a first point and steps from it
  let north = 0;
  let last = null;
  let lastEast = 0;
  for (const [dx, dy] of arc) {
    east += dx;
    north += dy;
    const place = `${2 * east} ${north}`;
    if (!numbers.has(place)) numbers.set(place, numbers.size + 1);
    const number = numbers.get(place);
    const across = Math.abs(2 * east - lastEast) > HALF_THE_WORLD;
    if (last !== null && last !== number && !across) {
      const key = `${Math.min(last, number)} ${Math.max(last, number)}`;
      if (!segments.has(key)) segments.set(key, `${last} ${number}`);
    }
    last = number;
    lastEast = 2 * east;
  }
}

console.log('# The world\'s coastlines at 1:110 million. Natural Earth, public domain; by way of npm');
console.log('# world-atlas 2.0.2 (ISC), land-110m.json. See derive-coastline.mjs.');
console.log(`${numbers.size} 2 0 0`);
for (const [place, number] of numbers) console.log(`${number} ${place}`);
console.log(`${segments.size} 0`);
let row = 0;
for (const ends of segments.values()) console.log(`${++row} ${ends}`);
console.log('0');
