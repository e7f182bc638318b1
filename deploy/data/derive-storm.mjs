#!/usr/bin/env node
// Derives storm.dynmesh, the edit script of the main job: a sizing disc that travels along
// the coast of North America, one revision a step, like a hurricane of the season. Run
// once, by hand; the result is committed.
//
//   deploy/data/derive-storm.mjs > deploy/data/storm.dynmesh
//
// Places are in the units of coastline-110m.poly, where 360 degrees of longitude are
// 199,998 and 169 of latitude 99,999. No randomness.
const STEPS = 60;
const ID = 20001;  // above the ids of the coastline's points and segments
const RADIUS = 2500;
const TARGET = 250;
// Along this track, in equal steps.
const TRACK = [
  [61110, 61510],  // Santo Domingo
  [58333, 63282],
  [55555, 66236],  // Florida
  [55277, 68895],
  [58055, 71554],  // Cape Hatteras
  [61110, 75099],  // Cape Cod
  [64444, 76871],
  [70555, 78644],  // Newfoundland
];

const legs = TRACK.slice(1).map((to, i) => Math.hypot(to[0] - TRACK[i][0], to[1] - TRACK[i][1]));
const whole = legs.reduce((a, b) => a + b);
function at(distance) {
  let i = 0;
  while (i + 1 < legs.length && distance > legs[i]) distance -= legs[i++];
  const part = distance / legs[i];
  return [0, 1].map((k) => Math.round(TRACK[i][k] + part * (TRACK[i + 1][k] - TRACK[i][k])));
}

console.log('# A storm along the coast of North America: a disc in which the mesh is to be finer, 60');
console.log('# revisions. See derive-storm.mjs.');
for (let step = 0; step < STEPS; ++step) {
  const [x, y] = at((whole * step) / (STEPS - 1));
  console.log(`${step === 0 ? 'add' : 'set'} size ${ID} disc ${x} ${y} ${RADIUS} ${TARGET}`);
  console.log('commit');
}
