// Random batches of edits: points that come, move and go; segments; polygons; sizes; all removed.
// Some are refused, as lines that cross are: then the features stay as they were.

export class Editor {
  #next = 1;
  /** By id: 'point', 'segment', 'polygon' or 'size'. */
  #kinds = new Map();

  constructor(server, mesh, dimension, random) {
    Object.assign(this, { server, mesh, dimension, random });
  }

  /** One random batch; the revision after it, or undefined if it was refused. */
  async edit() {
    const kinds = new Map(this.#kinds);
    const edits = this.#batch(kinds);
    if (edits.length === 0) return undefined;
    try {
      const revision = await this.server.edit(this.mesh, edits);
      this.#kinds = kinds;
      return revision;
    } catch (error) {
      if (!['failed_precondition', 'invalid_argument', 'resource_exhausted'].includes(error.code)) {
        throw error;
      }
      return undefined;
    }
  }

  #batch(kinds) {
    const { random } = this;
    const points = this.#ids(kinds, 'point');
    const what = random.below(100);
    if (what < 2 || kinds.size > 120) return this.#removeAll(kinds);
    if (what < 30) return [this.#add(kinds)];
    if (what < 50) return Array.from({ length: 2 + random.below(6) }, () => this.#add(kinds));
    if (what < 75 && points.length > 0) {
      return [{ move: { id: `${random.pick(points)}`, to: this.#place() } }];
    }
    if (what < 85) return this.#removeOne(kinds);
    if (what < 93) return this.#polygon(kinds);
    if (what < 96) return this.#size(kinds);
    return this.dimension === 2 ? this.#segment(kinds, points) : [this.#add(kinds)];
  }

  #ids(kinds, kind) {
    return [...kinds].filter(([, value]) => value === kind).map(([id]) => id);
  }

  #place(scale = 1, from = [0, 0, 0]) {
    const [x, y, z] = from.map((start) => start + scale * this.random.next());
    return this.dimension === 3 ? { x, y, z } : { x, y };
  }

  #add(kinds, point = this.#place()) {
    const id = this.#next++;
    kinds.set(id, 'point');
    return { add: { id: `${id}`, point } };
  }

  #removeAll(kinds) {
    // What uses points goes before them.
    const ids = [...kinds.keys()].reverse();
    kinds.clear();
    return ids.map((id) => ({ remove: `${id}` }));
  }

  #removeOne(kinds) {
    if (kinds.size === 0) return [];
    const id = this.random.pick([...kinds.keys()]);
    kinds.delete(id);
    return [{ remove: `${id}` }];
  }

  /** A small one, which mostly meets nothing; in 2D polygons may overlap if their edges do not. */
  #polygon(kinds) {
    const from = this.#place(0.8);
    const side = 0.02 + 0.15 * this.random.next();
    const corners = [
      [0, 0],
      [1, 0],
      [1, 1],
      [0, 1],
    ].map(([dx, dy]) => ({
      ...from,
      x: from.x + side * dx,
      y: from.y + side * dy,
    }));
    const added = corners.map((corner) => this.#add(kinds, corner));
    const id = this.#next++;
    kinds.set(id, 'polygon');
    const points = added.map(({ add }) => add.id);
    return [...added, { add: { id: `${id}`, polygon: { rings: [{ points }] } } }];
  }

  #segment(kinds, points) {
    if (points.length < 2) return [];
    const id = this.#next++;
    kinds.set(id, 'segment');
    const [p, q] = [this.random.pick(points), this.random.pick(points)];
    return [{ add: { id: `${id}`, segment: { p: `${p}`, q: `${q}` } } }];
  }

  #size(kinds) {
    const id = this.#next++;
    kinds.set(id, 'size');
    const target = this.dimension === 2 ? 0.03 : 0.2;
    const disc = { centre: this.#place(), radius: 0.05 };
    return [{ add: { id: `${id}`, size: { disc, target } } }];
  }
}
