// Pictures to keep.
import { colourAt, ramps, regionColours, type Colour } from '../draw/palette.js';
import { regionNumber, type Look } from '../draw/picture.js';
import type { PlaneCamera } from '../draw/camera.js';
import { triangleFigures } from '../model/figures.js';
import type { SlotMesh } from '../model/slot_mesh.js';
import { element } from './dom.js';

export function save(name: string, content: Blob): void {
  const href = URL.createObjectURL(content);
  const link = element('a', { href, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(href), 10_000);
}

/** What is seen of a 2D mesh, as vectors; glows are left out. */
export function svgOf(mesh: SlotMesh, camera: PlaneCamera, look: Look): string {
  const { width, height } = camera;
  const parts = [
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}">`,
    `<rect width="${width}" height="${height}" fill="${hexOf(look.theme.background)}"/>`,
  ];
  const stroke = look.edges ? `stroke="${hexOf(look.theme.line)}"` : '';
  parts.push(`<g ${stroke} stroke-width="0.7" stroke-linejoin="round">`);
  const { cells, subsegments } = mesh;
  for (let row = 0; row < cells.length; ++row) {
    const places = pixelsOf(mesh, camera, cells.corners, 3, row);
    if (places === undefined) continue;
    const fill = hexOf(fillOf(mesh, row, look));
    parts.push(`<path d="M${places.join('L')}Z" fill="${fill}"/>`);
  }
  parts.push('</g>');
  if (look.segments) {
    parts.push(`<g stroke="${hexOf(look.theme.segment)}" stroke-width="2" stroke-linecap="round">`);
    for (let row = 0; row < subsegments.length; ++row) {
      const places = pixelsOf(mesh, camera, subsegments.corners, 2, row);
      if (places !== undefined) parts.push(`<path d="M${places.join('L')}"/>`);
    }
    parts.push('</g>');
  }
  parts.push('</svg>');
  return parts.join('\n');
}

/** Undefined if the row is free or not seen. */
function pixelsOf(
  mesh: SlotMesh,
  camera: PlaneCamera,
  corners: Int32Array,
  width: number,
  row: number,
): string[] | undefined {
  if (corners[row * width] < 0) return undefined;
  const { coordinates } = mesh.vertices;
  const pixels = Array.from({ length: width }, (_, k) => {
    const at = 2 * corners[row * width + k];
    return camera.pixelOf({ x: coordinates[at], y: coordinates[at + 1] });
  });
  const xs = pixels.map(({ x }) => x);
  const ys = pixels.map(({ y }) => y);
  const isSeen =
    Math.max(...xs) >= 0 &&
    Math.min(...xs) <= camera.width &&
    Math.max(...ys) >= 0 &&
    Math.min(...ys) <= camera.height;
  return isSeen ? pixels.map(({ x, y }) => `${x.toFixed(2)} ${y.toFixed(2)}`) : undefined;
}

function fillOf(mesh: SlotMesh, row: number, look: Look): Colour {
  const { corners, tags } = mesh.cells;
  if (look.fill === 'change') return look.theme.plain;
  if (look.fill === 'region') {
    const region = regionNumber(tags[2 * row], tags[2 * row + 1]);
    return region === 0 ? look.theme.plain : regionColours[region - 1];
  }
  const [a, b, c] = corners.subarray(3 * row, 3 * row + 3);
  const figures = triangleFigures(mesh.vertices.coordinates, 2, a, b, c);
  const value = {
    quality: figures.quality,
    angle: figures.leastAngle,
    size: Math.log2(figures.longestEdge),
  }[look.fill];
  return colourAt(ramps[look.ramp], (value - look.range[0]) / (look.range[1] - look.range[0]));
}

function hexOf(colour: Colour): string {
  return `#${colour
    .map((part) =>
      Math.round(255 * part)
        .toString(16)
        .padStart(2, '0'),
    )
    .join('')}`;
}
