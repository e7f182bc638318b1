// What is drawn over the picture: the draft of an edit, and the places that a refusal names.
import type { PlaneCamera, Place } from '../draw/camera.js';

const SVG = 'http://www.w3.org/2000/svg';

export interface Draft {
  /** Of a segment or polygon that is being drawn. */
  line: readonly Place[];
  disc: { centre: Place; radius: number } | undefined;
}

export const noDraft: Draft = { line: [], disc: undefined };

export class Overlay {
  readonly #svg: SVGSVGElement;
  draft: Draft = noDraft;
  /** Places that are wrong. */
  marks: readonly Place[] = [];

  constructor(parent: HTMLElement) {
    this.#svg = document.createElementNS(SVG, 'svg');
    this.#svg.setAttribute('class', 'overlay');
    this.#svg.setAttribute('aria-hidden', 'true');
    parent.append(this.#svg);
  }

  draw(camera: PlaneCamera): void {
    const shapes: SVGElement[] = [];
    const { line, disc } = this.draft;
    if (line.length > 0) {
      const pixels = line.map((place) => camera.pixelOf(place));
      shapes.push(
        shape('polyline', {
          points: pixels.map(({ x, y }) => `${x},${y}`).join(' '),
          class: 'draft',
        }),
      );
    }
    if (disc) {
      const { x, y } = camera.pixelOf(disc.centre);
      const r = disc.radius * camera.scale;
      shapes.push(shape('circle', { cx: `${x}`, cy: `${y}`, r: `${r}`, class: 'draft' }));
    }
    for (const place of this.marks) {
      const { x, y } = camera.pixelOf(place);
      shapes.push(shape('circle', { cx: `${x}`, cy: `${y}`, r: '9', class: 'mark' }));
    }
    if (shapes.length > 0 || this.#svg.childElementCount > 0) this.#svg.replaceChildren(...shapes);
  }
}

function shape(tag: 'polyline' | 'circle', attributes: Record<string, string>): SVGElement {
  const result = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) result.setAttribute(name, value);
  return result;
}
