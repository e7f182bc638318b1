// The package, and the crack of tests/client/c/crack.c in JavaScript.
import { pathToFileURL } from "node:url";

export const { DynmeshError, load } = await import(
  pathToFileURL(`${process.env.DYNMESH_WASM}/dynmesh.mjs`)
);

// "HASH SUM CELLS", as crack.c prints it.
export function crack(dynmesh, steps = 100) {
  const mesh = dynmesh.open({ maxEdge: 0.05 });
  const batch = dynmesh.batch();
  batch.addPoints([1, 2, 3, 4], [0, 0, 1, 0, 1, 1, 0, 1]);
  batch.addPolygon(9, [[1, 2, 3, 4]]).addPoints([5], [0.125, 0.5]);
  mesh.apply(batch);
  const part = mesh.part();
  const points = mesh.array("points");
  let u = Float64Array.from({ length: mesh.count("vertexSlots") }, (_, i) => {
    return points[2 * i] * points[2 * i] + 3 * points[2 * i + 1];
  });
  for (let k = 0; k < steps; ++k) {
    const point = 101 + k;
    batch.clear();
    batch.addPoints([point], [0.125 + (k + 1) / 160, 0.5 + (((k * 7) % 13) - 6) / 4096]);
    batch.addSegments([301 + k], [k === 0 ? 5 : point - 1, point]);
    mesh.apply(batch);
    u = mesh.carry(u);
    part.update(mesh);
  }
  let sum = 0;
  mesh.array("vertexIds").forEach((id, i) => {
    if (id !== 0n) sum += u[i];
  });
  const bits = new BigUint64Array(Float64Array.of(sum).buffer)[0].toString(16).padStart(16, "0");
  const printed = `${mesh.hash} ${bits} ${part.array("cells").length / 3}`;
  for (const object of [part, batch, mesh]) object.close();
  return printed;
}
