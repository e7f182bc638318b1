// Elements of the page. Text is only ever set as text: what a client named is never markup.

type Attributes = Record<string, string | boolean>;

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const result = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'string') result.setAttribute(name, value);
    else result.toggleAttribute(name, value);
  }
  result.append(...children);
  return result;
}

/** The element of index.html with this id. */
export function byId<T extends HTMLElement>(id: string, type: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`the page has no ${id}`);
  return found;
}

/** A list of names and values. */
export function definitions(rows: readonly (readonly [string, string])[]): HTMLDListElement {
  return element(
    'dl',
    {},
    ...rows.flatMap(([name, value]) => [element('dt', {}, name), element('dd', {}, value)]),
  );
}

const grouped = new Intl.NumberFormat('en', { useGrouping: true });

export function count(value: number | bigint): string {
  return grouped.format(value);
}

/** A number as people read it: six digits. */
export function short(value: number): string {
  if (!Number.isFinite(value)) return '–';
  return Number(value.toPrecision(6)).toString();
}
