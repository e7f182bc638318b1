// The kept past: pause, steps, and a slider over the revisions that the page can go back to.
import { count, element } from './dom.js';

export interface TimelineListener {
  pause(isPaused: boolean): void;
  /** Goes that many steps along the kept past. */
  move(steps: number): void;
}

export class Timeline {
  readonly #pause = element('button', { type: 'button' }, 'Pause');
  readonly #back = element('button', { type: 'button', 'aria-label': 'One revision back' }, '◀');
  readonly #forward = element(
    'button',
    { type: 'button', 'aria-label': 'One revision forward' },
    '▶',
  );
  readonly #slider = element('input', { type: 'range', 'aria-label': 'Revision', min: '0' });
  readonly #text = element('span');
  #before = 0;
  #isPaused = false;

  constructor(parent: HTMLElement, listener: TimelineListener) {
    parent.append(this.#pause, this.#back, this.#slider, this.#forward, this.#text);
    this.#pause.addEventListener('click', () => listener.pause(!this.#isPaused));
    this.#back.addEventListener('click', () => listener.move(-1));
    this.#forward.addEventListener('click', () => listener.move(1));
    this.#slider.addEventListener('input', () => {
      listener.move(Number(this.#slider.value) - this.#before);
    });
  }

  /** `before` steps can be taken back, `behind` applied again. */
  show(revision: bigint, before: number, behind: number, isPaused: boolean): void {
    this.#before = before;
    this.#isPaused = isPaused;
    this.#pause.textContent = isPaused ? 'Resume' : 'Pause';
    this.#back.disabled = before === 0;
    this.#forward.disabled = behind === 0;
    this.#slider.max = String(before + behind);
    this.#slider.value = String(before);
    this.#slider.disabled = before + behind === 0;
    this.#text.textContent = `revision ${count(revision)}`;
  }
}
