// Histograms of a survey, with their figures as text.
import type { Colour } from '../draw/palette.js';
import { css } from '../draw/palette.js';
import { BINS, type Histogram } from '../model/survey.js';
import { element, short } from './dom.js';

const HEIGHT = 48;

/** `colourOf` gives the colour of a share of the range, from 0 to 1. */
export function histogramFigure(
  histogram: Histogram,
  colourOf: (share: number) => Colour,
): HTMLElement {
  const { name, unit, range, bins, least, most } = histogram;
  const words = `${name}: ${short(least)}${unit} to ${short(most)}${unit}`;
  const canvas = element('canvas', { class: 'histogram', role: 'img', 'aria-label': words });
  canvas.width = 8 * BINS;
  canvas.height = HEIGHT;
  const context = canvas.getContext('2d');
  const highest = Math.max(...bins, 1);
  bins.forEach((bin, i) => {
    if (context === null || bin === 0) return;
    context.fillStyle = css(colourOf((i + 0.5) / BINS));
    const height = Math.max(1, (HEIGHT * bin) / highest);
    context.fillRect(8 * i, HEIGHT - height, 7, height);
  });
  return element(
    'figure',
    {},
    element('figcaption', {}, words),
    canvas,
    element(
      'div',
      { class: 'ends' },
      element('small', {}, `${short(range[0])}${unit}`),
      element('small', {}, `${short(range[1])}${unit}`),
    ),
  );
}
