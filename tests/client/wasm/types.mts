// What the package's types accept and refuse: compiled only.
import { DynmeshError, load, type Mesh } from "../../../client/wasm/dynmesh.mjs";

const dynmesh = await load();
const mesh: Mesh = dynmesh.open({ dimension: 3, high: [1, 2, 3], maxVertices: 1000n });
const batch = dynmesh.batch(3).addPoints([1, 2n], new Float64Array(6)).setLabel(1, { name: "a" });
mesh.apply(batch, { maxOperations: 10 });
const points: Float64Array = mesh.array("points");
const ids: BigUint64Array = mesh.array("vertexIds");
const removed: Int32Array = mesh.diff("removedCells");
const field: Float64Array = mesh.carry(points, { kind: "p1", components: 3 });
const part = mesh.part({ polygons: [1n] }).update(mesh);
const files: Record<string, Uint8Array> = mesh.write("a.vtu", { part, binary: true });
const read: Mesh = dynmesh.read("a.stl", new Uint8Array(8), { mergeCoplanar: true }).openMesh(dynmesh);
export const used = [ids, removed, field, files, read, new DynmeshError().code === "NOT_FOUND"];

// @ts-expect-error: no such array
mesh.array("colours");
// @ts-expect-error: no such kind
dynmesh.open({ kind: "round" });
// @ts-expect-error: ids are no texts
batch.remove(["1"]);
