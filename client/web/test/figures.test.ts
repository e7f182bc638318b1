import { expect, test } from 'vitest';
import { triangleFigures } from '../src/model/figures.js';
import { PlaneCamera, halves } from '../src/draw/camera.js';
import { colourAt, ramps, themes, type Colour } from '../src/draw/palette.js';

test('an equilateral and a right triangle have their figures', () => {
  const equal = triangleFigures(Float64Array.of(0, 0, 2, 0, 1, Math.sqrt(3)), 2, 0, 1, 2);
  expect(equal.quality).toBeCloseTo(1 / Math.sqrt(3), 12);
  expect(equal.leastAngle).toBeCloseTo(60, 9);
  const right = triangleFigures(Float64Array.of(0, 0, 0, 4, 0, 0, 0, 3, 0), 3, 0, 1, 2);
  expect(right.quality).toBeCloseTo(2.5 / 3, 12);
  expect(right.leastAngle).toBeCloseTo((Math.atan2(3, 4) * 180) / Math.PI, 9);
  expect(right.area).toBe(6);
});

test('a camera fits a box, and zooming keeps what is at the pointer', () => {
  const camera = new PlaneCamera();
  camera.resize(800, 400);
  camera.fit({ lo: { x: 10, y: -1 }, hi: { x: 12, y: 1 } });
  expect(camera.pixelOf({ x: 11, y: 0 })).toEqual({ x: 400, y: 200 });
  expect(camera.scale).toBeCloseTo(0.92 * 200, 9);
  const pixel = { x: 123, y: 321 };
  const before = camera.placeOf(pixel);
  camera.zoom(pixel, 1e9);
  const after = camera.placeOf(pixel);
  expect(Math.abs(after.x - before.x) * camera.scale).toBeLessThan(1e-3);
  expect(Math.abs(after.y - before.y) * camera.scale).toBeLessThan(1e-3);
  camera.zoom(pixel, 1e-30);
  expect(camera.scale).toBeCloseTo(camera.fittedScale / 100, 9);
});

test('at a billionth of the box, positions in two floats are exact to a thousandth of a pixel', () => {
  const camera = new PlaneCamera();
  camera.resize(1000, 1000);
  camera.fit({ lo: { x: 0, y: 0 }, hi: { x: 1, y: 1 } });
  const place = { x: 0.123456789123456, y: 0.71 };
  camera.centre = { x: place.x + 2e-10, y: place.y - 1e-10 };
  camera.setScale(camera.fittedScale * 1e9);
  // As the shader does, with an origin in the middle of the box.
  const relative = (value: number, centre: number): number => {
    const [hi, lo] = halves(value - 0.5);
    const [cameraHi, cameraLo] = halves(centre - 0.5);
    return Math.fround(Math.fround(hi - cameraHi) + Math.fround(lo - cameraLo));
  };
  const exact = camera.pixelOf(place);
  const x = 500 + relative(place.x, camera.centre.x) * camera.scale;
  const y = 500 - relative(place.y, camera.centre.y) * camera.scale;
  expect(Math.abs(x - exact.x)).toBeLessThan(1e-2);
  expect(Math.abs(y - exact.y)).toBeLessThan(1e-2);
});

test('ramps are monotonic in lightness, and text of themes can be read', () => {
  const luminance = (colour: Colour): number => {
    const [r, g, b] = colour.map((part) =>
      part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4,
    );
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  for (const ramp of Object.values(ramps)) {
    expect(ramp.length).toBe(9);
    for (let i = 0; i < 64; ++i) {
      const [a, b] = [colourAt(ramp, i / 64), colourAt(ramp, (i + 1) / 64)];
      expect(luminance(b)).toBeGreaterThan(luminance(a));
    }
  }
  for (const theme of Object.values(themes)) {
    const contrast = (a: Colour, b: Colour): number => {
      const [p, q] = [luminance(a), luminance(b)];
      return (Math.max(p, q) + 0.05) / (Math.min(p, q) + 0.05);
    };
    expect(contrast(theme.segment, theme.plain)).toBeGreaterThan(4.5);
    expect(contrast(theme.glow, theme.plain)).toBeGreaterThan(2.5);
  }
});
