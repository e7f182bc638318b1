// The npm package, from DYNMESH_WASM, in node: meshes and fields have the bits of the native library.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { casesOf, hashOf } from "./golden.mjs";
import { crack, DynmeshError, load } from "./scene.mjs";

const FEWEST_CASES = 50;
const { DYNMESH_GOLDEN, DYNMESH_LIBRARY, DYNMESH_CC, DYNMESH_VERSION } = process.env;
const dynmesh = await load();

test("golden cases have their recorded hashes", () => {
  const recorded = new Map();
  for (const line of readFileSync(new URL("../../golden/hashes.txt", import.meta.url), "utf8").split("\n")) {
    const words = line.split(/ +/);
    if (!line.startsWith("#")) recorded.set(words[0], words[3]);
  }
  const scripts = execFileSync(DYNMESH_GOLDEN, ["--scripts"], { encoding: "utf8", maxBuffer: 2 ** 30 });
  const cases = casesOf(scripts).filter((golden) => golden.isWhole);
  assert.ok(cases.length >= FEWEST_CASES, `${cases.length} cases`);
  for (const golden of cases) {
    const hash = hashOf(dynmesh, golden, (error) => error instanceof DynmeshError);
    assert.equal(hash, recorded.get(golden.name), golden.name);
  }
  console.log(`${cases.length} cases`);
});

test("a crack with a field is that of C", () => {
  const folder = mkdtempSync(join(tmpdir(), "crack"));
  try {
    const source = fileURLToPath(new URL("../c/crack.c", import.meta.url));
    const header = fileURLToPath(new URL("../../../client/c", import.meta.url));
    const libraries = dirname(DYNMESH_LIBRARY);
    execFileSync(DYNMESH_CC, ["-std=c11", `-I${header}`, source, "-o", join(folder, "crack"),
      `-L${libraries}`, "-ldynmesh", `-Wl,-rpath,${libraries}`]);
    const printed = execFileSync(join(folder, "crack"), { encoding: "utf8" });
    assert.equal(crack(dynmesh), printed.trim());
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test("the version is the library's", () => assert.equal(dynmesh.version, DYNMESH_VERSION));

test("errors have code, reason, features and edit, and change nothing", () => {
  const mesh = dynmesh.open();
  const batch = dynmesh.batch().addPoints([1, 2], [0.25, 0.25, 0.75, 0.5]).addSegments([7], [1, 2]);
  mesh.apply(batch);
  const { hash } = mesh;
  batch.clear();
  batch.addPoints([3], [0.5, 0.125]).remove([1]);
  assert.throws(() => mesh.apply(batch), (error) => {
    assert.ok(error instanceof DynmeshError);
    assert.equal(error.code, "FAILED_PRECONDITION");
    assert.equal(error.reason, "POINT_IN_USE");
    assert.ok(error.features.includes(1n));
    return error.message.length > 0;
  });
  assert.equal(mesh.hash, hash);
  assert.equal(mesh.revision, 1);
  const code = (name) => (error) => error.code === name;
  assert.throws(() => dynmesh.open({ quality: -1 }), code("INVALID_ARGUMENT"));
  assert.throws(() => dynmesh.open({ kind: "round" }), code("INVALID_ARGUMENT"));
  assert.throws(() => batch.addPoints([4], [0.5]), code("INVALID_ARGUMENT"));
  assert.throws(() => batch.addPoints([0.5], [0.5, 0.5]), code("INVALID_ARGUMENT"));
  assert.throws(() => mesh.array("colours"), code("INVALID_ARGUMENT"));
  assert.throws(() => dynmesh.read("a.poly", new TextEncoder().encode("?")), DynmeshError);
  assert.throws(() => dynmesh.read("a.b", new Uint8Array(1)), DynmeshError);
  mesh.close();
  mesh.close();
  assert.throws(() => mesh.hash, code("FAILED_PRECONDITION"));
  batch.close();
});

const isInvalid = (error) => error instanceof DynmeshError && error.code === "INVALID_ARGUMENT";
const refuses = (call) => assert.throws(call, isInvalid, `${call}`);

test("objects of another class or module are refused", async () => {
  const another = await load();
  const mesh = dynmesh.open();
  const batch = another.batch().addPoints([1], [0.5, 0.5]);
  const part = mesh.part();
  const theirs = another.open();
  refuses(() => mesh.apply(batch));
  refuses(() => mesh.apply(part));
  refuses(() => mesh.apply({ at: 8 }));
  refuses(() => part.update(theirs));
  refuses(() => mesh.write("a.vtu", { part: mesh }));
  refuses(() => theirs.write("a.vtu", { part }));
  const input = dynmesh.read("a.node", new TextEncoder().encode("1 2 0 0\n1 0.5 0.5\n"));
  refuses(() => input.openMesh(another));
  for (const object of [mesh, batch, part, theirs, input]) object.close();
});

test("what does not fit into the library's structures is refused", () => {
  refuses(() => dynmesh.open({ low: [0, 0], high: [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1] }));
  refuses(() => dynmesh.open({ low: [0] }));
  refuses(() => dynmesh.open({ dimension: 4 }));
  refuses(() => dynmesh.batch("2"));
  refuses(() => dynmesh.open({ maxVertices: 0.5 }));
  const mesh = dynmesh.open();
  const batch = dynmesh.batch().addPoints([1], [0.5, 0.5]);
  refuses(() => mesh.apply(batch, { maxOperations: -1 }));
  mesh.apply(batch);
  refuses(() => mesh.carry(new Float64Array(2), { components: 1.1 }));
  refuses(() => mesh.carry(new Float64Array(3), { components: 2 }));
  batch.clear();
  refuses(() => batch.setLabel(1, { marker: 2n ** 63n }));
  refuses(() => batch.setLabel(1, { marker: 0.5 }));
  refuses(() => batch.setLabel(1, { name: "a\0b" }));
  refuses(() => batch.remove([2n ** 64n]));
  refuses(() => batch.addPolygon(-1, [[1, 2, 3]]));
  assert.equal(batch.length, 0);
  mesh.apply(batch.setLabel(1, { marker: -(2n ** 63n), name: "Riß 𝔸" }));
  for (const name of ["", "..", "../a.vtu", "folder/a.vtu"]) {
    refuses(() => mesh.write(name));
    refuses(() => dynmesh.read(name, new Uint8Array(1)));
  }
  refuses(() => dynmesh.read("a.node", { "a.node": new Uint8Array(1), "b/c": new Uint8Array(1) }));
  refuses(() => dynmesh.read("a.node", "1 2 0 0"));
  assert.ok(mesh.write("a.vtu")["a.vtu"].length > 0);
  batch.close();
  mesh.close();
});

test("a ring may have more corners than a call has arguments", () => {
  const batch = dynmesh.batch();
  const ring = BigUint64Array.from({ length: 200_000 }, (_, i) => BigInt(i + 1));
  assert.equal(batch.addPolygon(1_000_000, [ring]).length, 1);
  batch.close();
});

test("beyond 2 GB all is the same, and memory that ends is an error", async () => {
  const another = await load();
  const first = crack(another, 10);
  const batch = another.batch();
  const { module } = batch.core;
  const blocks = [];
  const reserve = (bytes, most) => {
    for (let at = 1; another.memory < most && at !== 0; ) {
      at = module._malloc(bytes);
      if (at !== 0) blocks.push(at);
    }
  };
  reserve(1e8, 2.5e9);
  assert.equal(crack(another, 10), first);
  const input = another.read("a.node", new TextEncoder().encode("2 2 0 0\n1 0 0\n2 1 1\n"));
  const mesh = input.openMesh(another);
  assert.ok(mesh.at > 2 ** 31);
  assert.ok(mesh.write("a.vtu")["a.vtu"].length > 0);
  reserve(1e7, 2 ** 32);
  const code = (name) => (error) => error instanceof DynmeshError && error.code === name;
  const ids = BigUint64Array.from({ length: 4e6 }, (_, i) => BigInt(10 + i));
  for (let i = 0; i < 3; ++i) assert.throws(() => batch.remove(ids), code("RESOURCE_EXHAUSTED"));
  assert.equal(batch.length, 0);
  mesh.apply(batch.addPoints([3], [0.5, 0.25]));
  for (const at of blocks) module._free(at);
  assert.equal(crack(another, 10), first);
  for (const object of [batch, input, mesh]) object.close();
});

test("arrays, diffs, places", () => {
  const mesh = dynmesh.open();
  const batch = dynmesh.batch().addPoints([1n], [0.5, 0.5]);
  const cells = mesh.count("cells");
  mesh.apply(batch);
  assert.equal(mesh.count("features"), 1);
  const change = mesh.diff("addedCells").length - mesh.diff("removedCells").length;
  assert.equal(mesh.count("cells"), cells + change);
  assert.equal(mesh.diff("removedCorners").length, 3 * mesh.diff("removedCells").length);
  const points = mesh.array("points");
  assert.equal(points.length, 2 * mesh.count("vertexSlots"));
  const [here, outside] = mesh.locate([0.375, 0.25, 1e9, 1e9]);
  assert.equal(outside, -1);
  const at = mesh.array("cells").slice(3 * here, 3 * here + 3);
  const xs = [...at].map((v) => points[2 * v]);
  assert.ok(Math.min(...xs) <= 0.375 && Math.max(...xs) >= 0.375);
  batch.close();
  mesh.close();
});

test("files are read and written as bytes", () => {
  const plate = "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n";
  const input = dynmesh.read("plate.poly", new TextEncoder().encode(plate));
  assert.equal(input.options.dimension, 2);
  const mesh = input.openMesh(dynmesh);
  assert.equal(mesh.count("features"), 8);
  const files = mesh.write("mesh.vtu");
  assert.deepEqual(Object.keys(files), ["mesh.vtu"]);
  assert.match(new TextDecoder().decode(files["mesh.vtu"].slice(0, 200)), /VTKFile/);
  const both = mesh.write("mesh.node");
  assert.ok(both["mesh.node"].length > 0 && both["mesh.ele"].length > 0, Object.keys(both));
  // Coordinates are written so that they read back.
  const rows = new TextDecoder().decode(both["mesh.node"]).split("\n");
  const written = new Set(rows.slice(1).flatMap((row) => row.trim().split(/ +/).slice(1, 3).map(Number)));
  const points = mesh.array("points");
  mesh.array("vertexIds").forEach((id, v) => {
    if (id !== 0n) assert.ok(written.has(points[2 * v]) && written.has(points[2 * v + 1]));
  });
  input.close();
  mesh.close();
});

test("memory does not grow over 1,000 edits", () => {
  const mesh = dynmesh.open({ maxEdge: 0.05 });
  const batch = dynmesh.batch().addPoints([1], [0.5, 0.5]);
  mesh.apply(batch);
  let before = 0;
  for (let i = 0; i < 1000; ++i) {
    batch.clear();
    batch.movePoints([1], [0.25 + ((i * 37) % 512) / 1024, 0.25 + ((i * 91) % 512) / 1024]);
    mesh.apply(batch);
    mesh.array("points");
    if (i === 100) before = dynmesh.memory;
  }
  assert.equal(dynmesh.memory, before);
  batch.close();
  mesh.close();
});
