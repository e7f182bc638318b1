#!/usr/bin/env node
// Derives crack.dynmesh and valve.dynmesh, edit scripts of the main job: geometry that changes in an
// area with a target length. Run once, by hand; the results are committed.
//
//   deploy/data/derive-crack-and-valve.mjs deploy/data
//
// No randomness.
import { writeFileSync } from 'node:fs';

const round = (x) => Math.round(x * 1e6) / 1e6;

// A plate of side 1. A crack begins at its left side and grows by two targets a step, 40 steps.
function crack() {
  const lines = [
    '# A crack that grows through a plate: 40 steps. See derive-crack-and-valve.mjs.',
    'mesh dim=2 box=0,0,1,1 rho=1.4142135623730951 hmax=0.01',
    'add point 1 0 0', 'add point 2 1 0', 'add point 3 1 1', 'add point 4 0 1', 'add point 5 0 0.5',
    'add segment 6 1 2', 'add segment 7 2 3', 'add segment 8 3 4', 'add segment 9 4 5',
    'add segment 10 5 1', 'commit',
  ];
  let x = 0, y = 0.5, tip = 5;
  for (let step = 1; step <= 40; ++step) {
    const turn = 0.5 * Math.sin(0.9 * step) + 0.3 * Math.sin(0.31 * step);
    x = round(x + 0.02 * Math.cos(turn));
    y = round(y + 0.02 * Math.sin(turn));
    const next = 100 + step;
    lines.push(`add point ${next} ${x} ${y}`, `add segment ${200 + step} ${tip} ${next}`, 'commit');
    tip = next;
  }
  return lines;
}

// A pipe of length 2 and width 1. A flap in it, 0.7 long and 0.03 thick, turns by 3 degrees a step,
// from shut to open, 30 steps.
function valve() {
  const lines = [
    '# A valve that opens: a flap in a pipe turns by 3 degrees, 30 times. See',
    '# derive-crack-and-valve.mjs.',
    'mesh dim=2 box=0,0,2,1 rho=1.4142135623730951 hmax=0.02',
    'add point 1 0 0', 'add point 2 2 0', 'add point 3 2 1', 'add point 4 0 1', 'add segment 5 1 2',
    'add segment 6 3 4',
  ];
  const corners = (step) => {
    const turn = ((90 - 3 * step) * Math.PI) / 180;
    return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([u, v]) => {
      const along = 0.35 * u, across = 0.015 * v;
      return [
        round(1 + along * Math.cos(turn) - across * Math.sin(turn)),
        round(0.5 + along * Math.sin(turn) + across * Math.cos(turn)),
      ];
    });
  };
  corners(0).forEach(([x, y], i) => lines.push(`add point ${11 + i} ${x} ${y}`));
  lines.push('add polygon 20 11 12 13 14', 'commit');
  for (let step = 1; step <= 30; ++step) {
    corners(step).forEach(([x, y], i) => lines.push(`move point ${11 + i} ${x} ${y}`));
    lines.push('commit');
  }
  return lines;
}

const folder = process.argv[2];
writeFileSync(`${folder}/crack.dynmesh`, crack().join('\n') + '\n');
writeFileSync(`${folder}/valve.dynmesh`, valve().join('\n') + '\n');
