// Cuts meshes beside the page: a million tetrahedra take longer than a frame.
import { Cutter, type CutTriangles, type Patch } from './cutter.js';

export interface Order {
  /** Begins another mesh. */
  reset: boolean;
  patch: Patch;
  axis: number;
  offset: number;
  origin: readonly number[];
}

export type Answer = CutTriangles;

interface Scope {
  onmessage: ((event: MessageEvent<Order>) => void) | null;
  postMessage(answer: Answer, transfer: Transferable[]): void;
}

const scope = self as unknown as Scope;
let cutter = new Cutter();

scope.onmessage = ({ data }) => {
  if (data.reset) cutter = new Cutter();
  cutter.patch(data.patch);
  const triangles = cutter.cut(data.axis, data.offset, data.origin);
  const copy = {
    positions: triangles.positions.slice(),
    figures: triangles.figures.slice(),
    edges: triangles.edges.slice(),
  };
  scope.postMessage(copy, [copy.positions.buffer, copy.figures.buffer, copy.edges.buffer]);
};
