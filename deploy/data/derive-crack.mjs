#!/usr/bin/env node
// Derives crack.dynmesh, the edit script of the main job: a right-angled crack of 60
// segments, one revision each, from the South Atlantic to Siberia. Run once, by hand; the
// result is committed.
//
//   deploy/data/derive-crack.mjs < deploy/data/coastline-110m.node > deploy/data/crack.dynmesh
//
// The crack climbs in turn east and north. Every coordinate ends in .5, so that it cannot
// meet a vertex of the coastline; of several lengths each step takes the first that keeps
// ROOM from them, else the one that keeps farthest. No randomness: the same input gives
// the same script.
import {readFileSync} from 'node:fs';

const SEGMENTS = 60;
const FIRST_POINT = 10001;    // ids above those of the coastline's points
const FIRST_SEGMENT = 20001;
const START = [76000.5, 27000.5];
const END = [158000.5, 86000.5];
// Lengths to choose from, as parts of the mean step, tried from another one each time.
const PARTS = [1, 0.7, 1.3, 0.55, 1.15, 0.85, 1.45];
const ROOM = 300;

const coast = readFileSync(0, 'utf8')
  .split('\n')
  .filter((line) => line !== '' && !line.startsWith('#'))
  .slice(1)
  .map((line) => line.split(' ').slice(1, 3).map(Number));

// Least squared distance from the coastline's vertices to the axis-parallel segment pq.
function clearance(p, q) {
  let least = Infinity;
  for (const [x, y] of coast) {
    const dx = Math.max(Math.min(p[0], q[0]) - x, 0, x - Math.max(p[0], q[0]));
    const dy = Math.max(Math.min(p[1], q[1]) - y, 0, y - Math.max(p[1], q[1]));
    least = Math.min(least, dx * dx + dy * dy);
  }
  return least;
}

// The next point along `axis`; `steps` are still to be made along it, this one included.
function next(p, axis, steps) {
  const mean = (END[axis] - p[axis]) / steps;
  let best = null;
  for (let i = 0; i < PARTS.length; ++i) {
    const part = steps === 1 ? 1 : PARTS[(i + 2 * steps) % PARTS.length];
    const q = [...p];
    q[axis] = Math.floor(p[axis] + mean * part) + 0.5;
    const room = Math.sqrt(clearance(p, q));
    if (room >= ROOM) return {q, room};
    if (best === null || room > best.room) best = {q, room};
  }
  return best;
}

const points = [START];
let room = Infinity;
for (let s = 0; s < SEGMENTS; ++s) {
  const step = next(points[s], s % 2, Math.ceil((SEGMENTS - s) / 2));
  points.push(step.q);
  room = Math.min(room, step.room);
}
console.error(`keeps ${room.toFixed(1)} from the coastline's vertices`);

console.log('# A right-angled crack of 60 segments, one revision each. See derive-crack.mjs.');
for (let s = 0; s < SEGMENTS; ++s) {
  if (s === 0) console.log(`add point ${FIRST_POINT} ${points[0].join(' ')}`);
  console.log(`add point ${FIRST_POINT + s + 1} ${points[s + 1].join(' ')}`);
  console.log(`add segment ${FIRST_SEGMENT + s} ${FIRST_POINT + s} ${FIRST_POINT + s + 1}`);
  console.log('commit');
}
