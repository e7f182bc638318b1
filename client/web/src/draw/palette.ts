// Colours: those of the page's themes, and ramps that look the same to most colour-blind people
// (cividis and viridis, as sampled from their published tables).

export type Colour = readonly [number, number, number];

export interface Theme {
  background: Colour;
  /** A triangle without another colour. */
  plain: Colour;
  line: Colour;
  segment: Colour;
  border: Colour;
  point: Colour;
  /** What has just changed. */
  glow: Colour;
  hover: Colour;
}

export const themes = {
  light: {
    background: hex('#f6f7f9'),
    plain: hex('#ffffff'),
    line: hex('#9aa3af'),
    segment: hex('#1b3a6b'),
    border: hex('#6b7280'),
    point: hex('#111827'),
    glow: hex('#e8710a'),
    hover: hex('#0072b2'),
  },
  dark: {
    background: hex('#14171c'),
    plain: hex('#232831'),
    line: hex('#4d5665'),
    segment: hex('#8ab4f8'),
    border: hex('#7b8494'),
    point: hex('#f3f4f6'),
    glow: hex('#ffb454'),
    hover: hex('#56b4e9'),
  },
} as const satisfies Record<string, Theme>;

export type ThemeName = keyof typeof themes;

/** Nine colours, evenly from 0 to 1. */
export type Ramp = readonly Colour[];

export const ramps = {
  cividis: [
    '#00224e',
    '#083370',
    '#35456c',
    '#575d6d',
    '#7d7c78',
    '#a59c74',
    '#c8b866',
    '#e3d150',
    '#fee838',
  ].map(hex),
  viridis: [
    '#440154',
    '#472d7b',
    '#3b528b',
    '#2c728e',
    '#21918c',
    '#28ae80',
    '#5ec962',
    '#addc30',
    '#fde725',
  ].map(hex),
} as const satisfies Record<string, Ramp>;

/** Colours of regions, after Okabe and Ito: eight that most people tell apart, then again, paler. */
export const regionColours: readonly Colour[] = [
  '#56b4e9',
  '#e69f00',
  '#009e73',
  '#cc79a7',
  '#f0e442',
  '#0072b2',
  '#d55e00',
  '#8c8c8c',
].map(hex);

/** The colour of a ramp at `value`, which is cut to 0 to 1; as the shaders make it. */
export function colourAt(ramp: Ramp, value: number): Colour {
  const place = Math.min(Math.max(value, 0), 1) * (ramp.length - 1);
  const index = Math.min(Math.floor(place), ramp.length - 2);
  return mixed(ramp[index], ramp[index + 1], place - index);
}

export function mixed(a: Colour, b: Colour, share: number): Colour {
  return [0, 1, 2].map((k) => a[k] + (b[k] - a[k]) * share) as unknown as Colour;
}

export function css(colour: Colour): string {
  return `rgb(${colour.map((part) => Math.round(255 * part)).join(' ')})`;
}

function hex(text: string): Colour {
  return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255) as unknown as Colour;
}
