// Keys of the page. They are for what has the focus first: fields and buttons keep theirs.

import { definitions, element } from './dom.js';

/** What a key does, by `KeyboardEvent.key`. */
export type Keys = Record<string, { does: string; run: () => void }>;

/** A dialog that lists them. */
export function keyHelp(keys: Keys): HTMLDialogElement {
  const close = element('button', { type: 'button' }, 'Close');
  const rows = Object.entries(keys).map(
    ([key, { does }]) => [key === ' ' ? 'Space' : key, does] as const,
  );
  const dialog = element(
    'dialog',
    { 'aria-label': 'Keys' },
    element('h2', {}, 'Keys'),
    definitions(rows),
    close,
  );
  close.addEventListener('click', () => dialog.close());
  return dialog;
}

export function listenTo(keys: Keys): void {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof HTMLElement && event.target.closest('input, select, button, a')) {
      return;
    }
    if (!Object.hasOwn(keys, event.key)) return;
    event.preventDefault();
    keys[event.key].run();
  });
}
