// The histograms of a mesh: surveyed again some time after it has changed, in slices between frames.
import type { Colour } from '../draw/palette.js';
import type { SlotMesh } from '../model/slot_mesh.js';
import { Survey } from '../model/survey.js';
import { element } from './dom.js';
import { histogramFigure } from './histograms.js';

/** Between surveys. */
const PAUSE_MS = 1000;
const SLICE_MS = 6;

export class Statistics {
  readonly #section = element('section', { hidden: true });
  readonly #figures = element('div');
  #timer: ReturnType<typeof setTimeout> | undefined;
  #mesh: SlotMesh | undefined;
  #bound = Math.SQRT2;
  /** The last survey that was begun. */
  #newest: Survey | undefined;

  constructor(
    parent: HTMLElement,
    private readonly colourOf: (name: string, share: number) => Colour,
  ) {
    this.#section.append(element('h2', {}, 'Statistics'), this.#figures);
    parent.append(this.#section);
  }

  /** The mesh has changed, or is another. */
  changed(mesh: SlotMesh | undefined, bound: number): void {
    if (mesh !== this.#mesh) clearTimeout(this.#timer);
    this.#section.hidden = mesh === undefined;
    if (mesh === this.#mesh && this.#timer !== undefined) return;
    const wait = mesh === this.#mesh ? PAUSE_MS : 100;
    this.#mesh = mesh;
    this.#bound = bound;
    if (mesh !== undefined) this.#timer = setTimeout(() => this.#begin(mesh), wait);
  }

  #begin(mesh: SlotMesh): void {
    // What changes from now on makes another survey.
    this.#timer = undefined;
    this.#newest = new Survey(mesh, this.#bound);
    this.#goOn(mesh, this.#newest);
  }

  #goOn(mesh: SlotMesh, survey: Survey): void {
    if (mesh !== this.#mesh) return;
    if (document.hidden) {
      const goOn = (): void => {
        if (survey === this.#newest) this.#goOn(mesh, survey);
      };
      document.addEventListener('visibilitychange', goOn, { once: true });
      return;
    }
    if (!survey.advance(SLICE_MS)) {
      setTimeout(() => this.#goOn(mesh, survey), 30);
      return;
    }
    this.#figures.replaceChildren(
      ...survey.histograms
        .filter(({ least }) => least < Infinity)
        .map((histogram) =>
          histogramFigure(histogram, (share) => this.colourOf(histogram.name, share)),
        ),
    );
  }
}
