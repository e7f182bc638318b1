// The controls of how a mesh is drawn, and their legend.
import { colourAt, css, ramps, regionColours, type Theme } from '../draw/palette.js';
import { fills, type Fill } from '../draw/picture.js';
import { element, short } from './dom.js';
import type { Link } from './link.js';

const names: Record<Fill, string> = {
  change: 'last changes',
  quality: 'quality (circumradius / shortest edge)',
  angle: 'least angle',
  size: 'longest edge',
  region: 'region',
};

export class Controls {
  readonly #fill = select('Fill', fills, names);
  readonly #ramp = select('Colours', ['cividis', 'viridis'] as const, {
    cividis: 'cividis',
    viridis: 'viridis',
  });
  readonly #edges = checkbox('Edges');
  readonly #segments = checkbox('Subsegments');
  readonly #points = checkbox('Input points');
  readonly #clip = select('Cut across', ['none', 'x', 'y', 'z'] as const, {
    none: 'no axis',
    x: 'x',
    y: 'y',
    z: 'z',
  });
  readonly #share = element('input', {
    type: 'range',
    min: '0',
    max: '1',
    step: '0.005',
    'aria-label': 'Place of the cut',
  });
  readonly #space = element('div', { hidden: true }, this.#clip.label, this.#share);
  readonly #legend = element('div', { role: 'group', 'aria-label': 'Legend' });

  constructor(
    parent: HTMLElement,
    private readonly changed: (choice: Partial<Link>) => void,
  ) {
    parent.append(
      element('h2', {}, 'Display'),
      ...[this.#fill, this.#ramp, this.#edges, this.#segments, this.#points].map(
        ({ label }) => label,
      ),
      this.#space,
      this.#legend,
    );
    const cut = (): void => {
      const axis = 'xyz'.indexOf(this.#clip.input.value);
      const share = Number(this.#share.value);
      this.changed({ clip: axis < 0 ? undefined : { axis, share } });
    };
    this.#clip.input.addEventListener('change', cut);
    this.#share.addEventListener('input', cut);
    this.#fill.input.addEventListener('change', () => {
      this.changed({ fill: this.#fill.input.value as Fill });
    });
    this.#ramp.input.addEventListener('change', () => {
      this.changed({ ramp: this.#ramp.input.value as keyof typeof ramps });
    });
    for (const [name, { input }] of [
      ['edges', this.#edges],
      ['segments', this.#segments],
      ['points', this.#points],
    ] as const) {
      input.addEventListener('change', () => this.changed({ [name]: input.checked }));
    }
  }

  show(link: Link, theme: Theme, range: readonly [number, number], isSpace: boolean): void {
    this.#space.hidden = !isSpace;
    this.#clip.input.value = link.clip ? 'xyz'[link.clip.axis] : 'none';
    this.#share.value = String(link.clip?.share ?? 0.5);
    this.#share.disabled = link.clip === undefined;
    this.#fill.input.value = link.fill;
    this.#ramp.input.value = link.ramp;
    this.#edges.input.checked = link.edges;
    this.#segments.input.checked = link.segments;
    this.#points.input.checked = link.points;
    this.#ramp.input.disabled = link.fill === 'change' || link.fill === 'region';
    this.#legend.replaceChildren(...legendOf(link, theme, range));
  }
}

function legendOf(link: Link, theme: Theme, range: readonly [number, number]): Node[] {
  if (link.fill === 'region') return [bar(regionColours.map(css), 'Colours of regions')];
  const [low, high] =
    link.fill === 'size'
      ? range.map((value) => short(2 ** value))
      : link.fill === 'angle'
        ? range.map((value) => `${short(value)}°`)
        : range.map(short);
  if (link.fill === 'change') {
    return [
      bar([css(theme.plain), css(theme.glow)], 'From old to new'),
      element('small', {}, 'unchanged to just changed'),
    ];
  }
  const colours = Array.from({ length: 32 }, (_, i) => css(colourAt(ramps[link.ramp], i / 31)));
  return [bar(colours, `From ${low} to ${high}`), element('small', {}, `${low} to ${high}`)];
}

function bar(colours: readonly string[], label: string): HTMLCanvasElement {
  const canvas = element('canvas', { class: 'legend', role: 'img', 'aria-label': label });
  canvas.width = colours.length;
  canvas.height = 1;
  const context = canvas.getContext('2d');
  if (context === null) return canvas;
  colours.forEach((colour, i) => {
    context.fillStyle = colour;
    context.fillRect(i, 0, 1, 1);
  });
  return canvas;
}

interface Labelled<T extends HTMLElement> {
  label: HTMLLabelElement;
  input: T;
}

function select<T extends string>(
  text: string,
  values: readonly T[],
  shown: Record<T, string>,
): Labelled<HTMLSelectElement> {
  const input = element(
    'select',
    {},
    ...values.map((value) => element('option', { value }, shown[value])),
  );
  return { label: element('label', {}, `${text} `, input), input };
}

function checkbox(text: string): Labelled<HTMLInputElement> {
  const input = element('input', { type: 'checkbox' });
  return { label: element('label', {}, input, ` ${text}`), input };
}
