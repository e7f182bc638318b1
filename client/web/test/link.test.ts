import { expect, test } from 'vitest';
import { readLink, start, writeLink, type Link } from '../src/ui/link.js';

test('a link leads back to what it was written from', () => {
  const link: Link = {
    mesh: 'plate',
    fill: 'quality',
    ramp: 'viridis',
    edges: false,
    segments: true,
    points: false,
    clip: { axis: 1, share: 0.25 },
    view: [0.123456789012345, -7e-11, 123456789.5],
  };
  expect(readLink(writeLink(link))).toEqual(link);
  expect(readLink(writeLink(start))).toEqual(start);
  expect(writeLink(start)).toBe('#');
});

test('what makes no sense is as without it', () => {
  expect(readLink('#fill=javascript&view=1 NaN 2&hide=all&clip=w 2&ramp=x&mesh=a%3Cb%3E')).toEqual({
    ...start,
    mesh: 'a<b>',
  });
});
