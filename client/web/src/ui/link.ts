// What a link has: the mesh, how it is drawn, and what is seen of it. It is the part of the address
// after the #, which the browser sends to no server.
import { fills, type Fill } from '../draw/picture.js';
import { ramps } from '../draw/palette.js';

export interface Link {
  mesh: string;
  fill: Fill;
  ramp: keyof typeof ramps;
  edges: boolean;
  segments: boolean;
  points: boolean;
  /** Of 3D meshes: across which axis they are cut, and where between the sides of the box. */
  clip: { axis: number; share: number } | undefined;
  /** The middle and the zoom, relative to the fitted picture; or the angles of a space. */
  view: readonly number[];
}

export const start: Link = {
  mesh: '',
  fill: 'change',
  ramp: 'cividis',
  edges: true,
  segments: true,
  points: true,
  clip: undefined,
  view: [],
};

const HIDDEN = ['edges', 'segments', 'points'] as const;

const AXES = 'xyz';

function clipOf(text: string): Link['clip'] {
  const match = /^([xyz]) ([\d.]+)$/.exec(text);
  if (match === null) return undefined;
  const share = Number(match[2]);
  return share >= 0 && share <= 1 ? { axis: AXES.indexOf(match[1]), share } : undefined;
}

/** Reads a link; what is missing or makes no sense is as in `start`. */
export function readLink(hash: string): Link {
  const given = new URLSearchParams(hash.replace(/^#/, ''));
  const fill = fills.find((name) => name === given.get('fill')) ?? start.fill;
  const ramp = given.get('ramp');
  const hidden = (given.get('hide') ?? '').split(' ');
  const view = (given.get('view') ?? '').split(' ').map(Number);
  return {
    mesh: given.get('mesh') ?? '',
    fill,
    ramp: ramp === 'viridis' ? ramp : start.ramp,
    edges: !hidden.includes('edges'),
    segments: !hidden.includes('segments'),
    points: !hidden.includes('points'),
    clip: clipOf(given.get('clip') ?? ''),
    view: view.length > 1 && view.every(Number.isFinite) ? view : [],
  };
}

/** Writes one, without what is as in `start`. */
export function writeLink(link: Link): string {
  const given = new URLSearchParams();
  if (link.mesh !== '') given.set('mesh', link.mesh);
  if (link.fill !== start.fill) given.set('fill', link.fill);
  if (link.ramp !== start.ramp) given.set('ramp', link.ramp);
  const hidden = HIDDEN.filter((name) => !link[name]);
  if (hidden.length > 0) given.set('hide', hidden.join(' '));
  if (link.clip) given.set('clip', `${AXES[link.clip.axis]} ${link.clip.share}`);
  if (link.view.length > 0) given.set('view', link.view.join(' '));
  return `#${given.toString()}`;
}
