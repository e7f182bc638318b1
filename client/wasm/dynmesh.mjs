// dynmesh in JavaScript: a thin layer over the C interface, compiled to WebAssembly. What its
// functions do is described in dynmesh.h; what they take and return, in dynmesh.d.mts.
//
// The module's memory grows, which ends all views of it: so each array that is returned is a copy,
// and views are made right before they are used. Structures have the layout that layout.cc checks.
import instantiate from "./dynmesh-core.mjs";

const CODES = {
  1: "CANCELLED", 2: "INTERNAL", 3: "INVALID_ARGUMENT", 5: "NOT_FOUND", 6: "ALREADY_EXISTS",
  8: "RESOURCE_EXHAUSTED", 9: "FAILED_PRECONDITION", 11: "OUT_OF_RANGE", 12: "UNIMPLEMENTED",
  14: "UNAVAILABLE", 15: "DATA_LOSS",
};
const KINDS = { delaunay: 1, quadtree: 2, triangulation: 3 };
const CRITERIA = { edge: 1, thesis: 2 };
const COUNTS = { vertices: 1, cells: 2, vertexSlots: 3, cellSlots: 4, features: 5 };
const ACTIONS = { add: 1, set: 2 };
const ARRAYS = {
  points: 1, vertexIds: 2, owners: 3, on: 4, cells: 5, neighbours: 6, regions: 7, subsegments: 8,
  subsegmentOwners: 9, subfacets: 10, subfacetOwners: 11,
};
const DIFFS = {
  removedVertices: 1, addedVertices: 2, removedCells: 3, removedCorners: 4, removedRegions: 5,
  addedCells: 6, relabelledCells: 7, formerRegions: 8,
};
const FIELDS = { p0: 1, p0Linear: 2, p1: 3, dg1: 4, dual: 5, dualCorners: 6, overlap: 7 };
const BY_VERTEX = ["p1", "dual"];
const BY_CORNER = ["dg1", "dualCorners"];
const PART_ARRAYS = {
  points: 1, vertexSlots: 2, cells: 3, cellSlots: 4, regions: 5, facets: 6, facetOwners: 7,
  facetCells: 8,
};
const READ_FLAGS = { mergeCoplanar: 1, mapPolygons: 2, refine: 4, keepFacets: 8 };
const WRITE_FLAGS = { order2: 1, fromZero: 2, binary: 4, inputMarkers: 8 };
// By the type of a column.
const TYPED = { 1: Float64Array, 2: Int32Array, 3: BigUint64Array, 4: Uint8Array, 5: BigInt64Array };
const F64 = 1;
const U64 = 3;
const COLUMN = 20;
const ERROR = 1136;
const OPTIONS = 104;

/** An error of the library: `code` is the name of dynmesh.h's, without its prefix. */
export class DynmeshError extends Error {
  constructor(code, message, { reason = "", features = [], edit } = {}) {
    super(message);
    this.name = "DynmeshError";
    this.code = code;
    this.reason = reason;
    this.features = features;
    this.edit = edit;
  }
}

const invalid = (message) => new DynmeshError("INVALID_ARGUMENT", message);

function numberOf(table, name, what) {
  if (!Object.hasOwn(table, name)) {
    throw invalid(`there is no ${what} ${name}, but ${Object.keys(table).join(", ")}`);
  }
  return table[name];
}

function flagsOf(table, chosen) {
  let sum = 0;
  for (const [name, is] of Object.entries(chosen)) if (is) sum |= numberOf(table, name, "choice");
  return sum;
}

function toBigInt(value, what) {
  if (typeof value === "bigint") return value;
  if (!Number.isSafeInteger(value)) throw invalid(`${value} is no ${what}`);
  return BigInt(value);
}

function toUnsigned(value, what) {
  const big = toBigInt(value, what);
  if (BigInt.asUintN(64, big) === big) return big;
  throw invalid(`the ${what} ${value} is not from 0 to 2^64 - 1`);
}

function toMarker(value) {
  const big = toBigInt(value, "marker");
  if (BigInt.asIntN(64, big) === big) return big;
  throw invalid(`the marker ${value} is not from -2^63 to 2^63 - 1`);
}

const toIds = (ids) =>
  ids instanceof BigUint64Array ? ids : BigUint64Array.from(ids, (id) => toUnsigned(id, "id"));

const toNumbers = (numbers) =>
  numbers instanceof Float64Array ? numbers : Float64Array.from(numbers);

function toDimension(dimension) {
  if (dimension === 2 || dimension === 3) return dimension;
  throw invalid(`dimension: ${dimension} is neither 2 nor 3`);
}

// The module: calls, and memory for them.
class Core {
  constructor(module) {
    this.module = module;
    this.error = this.allocate(ERROR);
    this.text = new TextDecoder();
    this.freed = new FinalizationRegistry(({ free, at }) => free(at));
  }

  allocate(bytes) {
    const at = this.module._malloc(bytes) >>> 0;
    if (at === 0) throw new DynmeshError("RESOURCE_EXHAUSTED", "memory ran out");
    return at;
  }

  view() {
    return new DataView(this.module.HEAPU8.buffer);
  }

  string(at) {
    const bytes = this.module.HEAPU8;
    return this.text.decode(bytes.slice(at, bytes.indexOf(0, at)));
  }

  // The result of use(arena), where arena has memory until then.
  with(use) {
    const arena = new Arena(this);
    try {
      return use(arena);
    } finally {
      arena.free();
    }
  }

  // Calls a function whose last argument is the error; throws what it reports.
  call(name, ...given) {
    if (this.module[`_${name}`](...given, this.error) === 0) return;
    const view = this.view();
    const at = this.error;
    const features = [];
    for (let i = 0; i < view.getInt32(at + 4, true); ++i) {
      features.push(view.getBigUint64(at + 16 + 8 * i, true));
    }
    const edit = Number(view.getBigInt64(at + 8, true));
    throw new DynmeshError(CODES[view.getInt32(at, true)] ?? "INTERNAL", this.string(at + 112), {
      reason: this.string(at + 80), features, edit: edit < 0 ? undefined : edit,
    });
  }

  // A new object: what a function puts where its argument before the error points to.
  make(name, ...given) {
    return this.with((arena) => {
      const to = arena.take(8);
      this.call(name, ...given, to);
      return this.view().getUint32(to, true);
    });
  }

  // A copy of the column that a function gives out.
  column(name, object, which) {
    return this.with((arena) => {
      const at = arena.take(COLUMN);
      this.call(name, object, which, at);
      const view = this.view();
      const Typed = TYPED[view.getInt32(at + 16, true)];
      const data = view.getUint32(at, true);
      const length = view.getUint32(at + 4, true) * view.getInt32(at + 12, true);
      return length === 0 ? new Typed(0) : new Typed(view.buffer, data, length).slice();
    });
  }
}

class Arena {
  constructor(core) {
    this.core = core;
    this.taken = [];
  }

  take(bytes) {
    const at = this.core.allocate(bytes);
    this.taken.push(at);
    return at;
  }

  // Where a copy of the array is.
  copy(array) {
    const at = this.take(Math.max(array.byteLength, 8));
    new array.constructor(this.core.view().buffer, at, array.length).set(array);
    return at;
  }

  // Where a column is: of a copy, `width` numbers a row.
  column(array, width = 1, to = this.take(COLUMN)) {
    if (array.length % width !== 0) {
      throw invalid(`${array.length} numbers are no rows of ${width}`);
    }
    const data = this.copy(array);
    const view = this.core.view();
    view.setUint32(to, data, true);
    view.setUint32(to + 4, array.length / width, true);
    view.setInt32(to + 8, width * array.BYTES_PER_ELEMENT, true);
    view.setInt32(to + 12, width, true);
    view.setInt32(to + 16, array instanceof Float64Array ? F64 : U64, true);
    return to;
  }

  string(text) {
    if (`${text}`.includes("\0")) throw invalid("a text has a character 0");
    return this.copy(new TextEncoder().encode(`${text}\0`));
  }

  free() {
    for (const at of this.taken) this.core.module._free(at);
  }
}

// An object of the library, which ends with `close`, or when it is no longer reachable.
class Handle {
  #at;
  constructor(core, at, free) {
    this.core = core;
    this.#at = at;
    this.free = core.module[free];
    core.freed.register(this, { free: this.free, at }, this);
    // Its memory and that of other objects are no part of what a program sees.
    for (const key of ["core", "free"]) Object.defineProperty(this, key, { enumerable: false });
  }

  get at() {
    if (this.#at === 0) throw new DynmeshError("FAILED_PRECONDITION", "it was closed");
    return this.#at;
  }

  // Where an argument is: in another module's memory, or of another class, its number means nothing.
  other(object, Class) {
    if (object instanceof Class && object.core === this.core) return object.at;
    throw invalid(`an argument is no ${Class.name} of the same module`);
  }

  close() {
    if (this.#at === 0) return;
    this.core.freed.unregister(this);
    this.free(this.#at);
    this.#at = 0;
  }
}
if (Symbol.dispose) Handle.prototype[Symbol.dispose] = Handle.prototype.close;

class Batch extends Handle {
  // The number of coordinates of each place.
  constructor(core, dimension) {
    super(core, core.make("dynmesh_batch_new"), "_dynmesh_batch_free");
    this.dimension = dimension;
  }

  get length() {
    return this.core.module._dynmesh_batch_count(this.at) >>> 0;
  }

  clear() {
    this.core.module._dynmesh_batch_clear(this.at);
    return this;
  }

  #call(name, make) {
    this.core.with((arena) => this.core.call(name, this.at, ...make(arena)));
    return this;
  }

  addPoints(ids, places, { action = "add" } = {}) {
    return this.#call("dynmesh_add_points", (arena) => [
      numberOf(ACTIONS, action, "action"), arena.column(toIds(ids)),
      arena.column(toNumbers(places), this.dimension),
    ]);
  }

  addSegments(ids, ends, { action = "add" } = {}) {
    return this.#call("dynmesh_add_segments", (arena) => [
      numberOf(ACTIONS, action, "action"), arena.column(toIds(ids)), arena.column(toIds(ends), 2),
    ]);
  }

  addPolygon(id, rings, { action = "add" } = {}) {
    const corners = [];
    const ends = [];
    for (const ring of rings) {
      for (const corner of ring) corners.push(corner);
      ends.push(corners.length);
    }
    return this.#call("dynmesh_add_polygon", (arena) => [
      numberOf(ACTIONS, action, "action"), toUnsigned(id, "id"), arena.column(toIds(corners)),
      arena.column(toIds(ends)),
    ]);
  }

  addSizes(ids, places, targets, { radii = [], action = "add" } = {}) {
    return this.#call("dynmesh_add_sizes", (arena) => [
      numberOf(ACTIONS, action, "action"), arena.column(toIds(ids)),
      arena.column(toNumbers(places), this.dimension), arena.column(toNumbers(radii)),
      arena.column(toNumbers(targets)),
    ]);
  }

  movePoints(ids, places) {
    return this.#call("dynmesh_move_points", (arena) => [
      arena.column(toIds(ids)), arena.column(toNumbers(places), this.dimension),
    ]);
  }

  remove(ids) {
    return this.#call("dynmesh_remove", (arena) => [arena.column(toIds(ids))]);
  }

  setLabel(id, { marker = 0, name = "" }) {
    return this.#call("dynmesh_set_label", (arena) => [
      toUnsigned(id, "id"), toMarker(marker), arena.string(name),
    ]);
  }
}

class Mesh extends Handle {
  constructor(core, at, dimension) {
    super(core, at, "_dynmesh_close");
    this.dimension = dimension;
  }

  get revision() {
    return Number(this.core.module._dynmesh_revision(this.at));
  }

  get hash() {
    return this.core.with((arena) => {
      const to = arena.take(33);
      this.core.module._dynmesh_hash(this.at, to);
      return this.core.string(to);
    });
  }

  count(which) {
    return Number(this.core.module._dynmesh_count(this.at, numberOf(COUNTS, which, "count")));
  }

  apply(batch, { maxOperations = 0 } = {}) {
    this.core.with((arena) => {
      const options = arena.take(24);
      this.core.module._dynmesh_fill_apply_options(options, 24);
      const most = toUnsigned(maxOperations, "number of operations");
      this.core.view().setBigUint64(options + 16, most, true);
      this.core.call("dynmesh_apply", this.at, this.other(batch, Batch), options);
    });
    return this;
  }

  array(which) {
    return this.core.column("dynmesh_array", this.at, numberOf(ARRAYS, which, "array"));
  }

  diff(which) {
    return this.core.column("dynmesh_diff", this.at, numberOf(DIFFS, which, "column of a diff"));
  }

  locate(places) {
    return this.core.with((arena) => {
      const numbers = toNumbers(places);
      const column = arena.column(numbers, this.dimension);
      const rows = numbers.length / this.dimension;
      const cells = arena.take(4 * rows + 4);
      this.core.call("dynmesh_locate", this.at, column, cells);
      return new Int32Array(this.core.view().buffer, cells, rows).slice();
    });
  }

  carry(values, { kind = "p1", components = 1, rings, bounded = false } = {}) {
    if (!Number.isSafeInteger(components) || components < 1) {
      throw invalid("a field has 1 component or more");
    }
    return this.core.with((arena) => {
      const field = arena.take(20);
      this.core.module._dynmesh_fill_field(field, 20);
      const view = this.core.view();
      view.setInt32(field + 4, numberOf(FIELDS, kind, "kind of field"), true);
      view.setInt32(field + 8, components, true);
      if (rings !== undefined) view.setInt32(field + 12, rings, true);
      view.setInt32(field + 16, bounded ? 1 : 0, true);
      const rows = this.count(BY_VERTEX.includes(kind) ? "vertexSlots" : "cellSlots");
      const width = components * (BY_CORNER.includes(kind) ? this.dimension + 1 : 1);
      if (values.length > rows * width) throw invalid(`the field has more than ${rows} rows`);
      if (values.length % width !== 0) {
        throw invalid(`${values.length} numbers are no rows of ${width}`);
      }
      const carried = new Float64Array(rows * width);
      carried.set(values);
      const at = arena.copy(carried);
      this.core.call("dynmesh_carry", this.at, field, at, rows, 8 * width);
      carried.set(new Float64Array(this.core.view().buffer, at, carried.length));
      return carried;
    });
  }

  part({ polygons = [], without = [], open = [], inside = polygons.length === 0 } = {}) {
    return this.core.with((arena) => {
      const choice = arena.take(72);
      this.core.module._dynmesh_fill_choice(choice, 72);
      arena.column(toIds(polygons), 1, choice + 4);
      arena.column(toIds(without), 1, choice + 24);
      arena.column(toIds(open), 1, choice + 44);
      this.core.view().setInt32(choice + 64, inside ? 1 : 0, true);
      return new Part(this.core, this.core.make("dynmesh_part_new", this.at, choice));
    });
  }

  write(name, { part, ...flags } = {}) {
    return inFolder(this.core, name, {}, (folder, path) => {
      const wanted = part === undefined ? 0 : this.other(part, Part);
      this.core.call("dynmesh_write", this.at, wanted, path, flagsOf(WRITE_FLAGS, flags));
      const { FS } = this.core.module;
      const names = FS.readdir(folder).filter((entry) => entry !== "." && entry !== "..");
      return Object.fromEntries(names.map((entry) => [entry, FS.readFile(`${folder}/${entry}`)]));
    });
  }
}

class Part extends Handle {
  constructor(core, at) {
    super(core, at, "_dynmesh_part_free");
  }

  update(mesh) {
    this.core.call("dynmesh_part_update", this.at, this.other(mesh, Mesh));
    return this;
  }

  array(which) {
    return this.core.column("dynmesh_part_array", this.at,
                            numberOf(PART_ARRAYS, which, "array of a part"));
  }
}

// The content of a file. Its batch is the input's own, and ends with it.
class Input extends Handle {
  constructor(core, at) {
    super(core, at, "_dynmesh_input_free");
    this.options = core.with((arena) => {
      const options = arena.take(OPTIONS);
      core.module._dynmesh_input_fill_options(at, options, OPTIONS);
      return readOptions(core.view(), options);
    });
  }

  openMesh(dynmesh, options = {}) {
    const mesh = dynmesh.open({ ...this.options, ...options });
    try {
      const at = this.other(mesh, Mesh);
      this.core.call("dynmesh_apply", at, this.core.module._dynmesh_input_batch(this.at), 0);
      return mesh;
    } catch (error) {
      mesh.close();
      throw error;
    }
  }
}

const nameOf = (table, number) => Object.keys(table).find((name) => table[name] === number);

function readOptions(view, at) {
  const dimension = view.getInt32(at + 4, true);
  const corner = (offset) =>
    Array.from({ length: dimension }, (_, i) => view.getFloat64(at + offset + 8 * i, true));
  return {
    dimension,
    kind: nameOf(KINDS, view.getInt32(at + 8, true)),
    criterion: nameOf(CRITERIA, view.getInt32(at + 12, true)),
    low: corner(24),
    high: corner(48),
    quality: view.getFloat64(at + 72, true),
    maxEdge: view.getFloat64(at + 80, true),
    minDihedral: view.getFloat64(at + 88, true),
    maxVertices: view.getBigUint64(at + 96, true),
  };
}

function writeOptions(view, at, dimension, given) {
  if (given.kind !== undefined) view.setInt32(at + 8, numberOf(KINDS, given.kind, "kind"), true);
  if (given.criterion !== undefined) {
    view.setInt32(at + 12, numberOf(CRITERIA, given.criterion, "criterion"), true);
  }
  for (const [name, offset] of [["low", 24], ["high", 48]]) {
    const corner = given[name];
    if (corner === undefined) continue;
    if (corner.length !== dimension) {
      throw invalid(`${name}: ${corner.length} numbers, not ${dimension}`);
    }
    corner.forEach((x, i) => view.setFloat64(at + offset + 8 * i, x, true));
  }
  if (given.quality !== undefined) view.setFloat64(at + 72, given.quality, true);
  if (given.maxEdge !== undefined) view.setFloat64(at + 80, given.maxEdge, true);
  if (given.minDihedral !== undefined) view.setFloat64(at + 88, given.minDihedral, true);
  if (given.maxVertices !== undefined) {
    view.setBigUint64(at + 96, toUnsigned(given.maxVertices, "number of vertices"), true);
  }
}

// The result of use(folder, path, arena), where a folder of the module has the files until then, and
// `path` is that of the file `main` there.
function inFolder(core, main, files, use) {
  for (const name of [main, ...Object.keys(files)]) {
    if (/^\.{0,2}$|[/\0]/.test(name)) throw invalid(`"${name}" is no name of a file, without folders`);
  }
  for (const [name, bytes] of Object.entries(files)) {
    if (!ArrayBuffer.isView(bytes)) throw invalid(`the content of ${name} is no array of bytes`);
  }
  const { FS } = core.module;
  const folder = "/files";
  FS.mkdir(folder);
  try {
    for (const [name, { buffer, byteOffset, byteLength }] of Object.entries(files)) {
      FS.writeFile(`${folder}/${name}`, new Uint8Array(buffer, byteOffset, byteLength));
    }
    return core.with((arena) => use(folder, arena.string(`${folder}/${main}`)));
  } finally {
    for (const name of FS.readdir(folder)) {
      if (name !== "." && name !== "..") FS.unlink(`${folder}/${name}`);
    }
    FS.rmdir(folder);
  }
}

class Dynmesh {
  #core;
  constructor(module) {
    this.#core = new Core(module);
  }

  get version() {
    return this.#core.string(this.#core.module._dynmesh_version());
  }

  open(options = {}) {
    const dimension = toDimension(options.dimension ?? 2);
    const core = this.#core;
    return core.with((arena) => {
      const at = arena.take(OPTIONS);
      core.module._dynmesh_fill_options(dimension, at, OPTIONS);
      writeOptions(core.view(), at, dimension, options);
      return new Mesh(core, core.make("dynmesh_open", at), dimension);
    });
  }

  batch(dimension = 2) {
    return new Batch(this.#core, toDimension(dimension));
  }

  read(name, files, flags = {}) {
    const core = this.#core;
    const given = ArrayBuffer.isView(files) ? { [name]: files } : files;
    return inFolder(core, name, given, (folder, path) =>
      new Input(core, core.make("dynmesh_read", path, flagsOf(READ_FLAGS, flags))));
  }

  get memory() {
    return this.#core.module.HEAPU8.length;
  }
}

/** Loads the module: from beside this file, or the bytes given. Each call makes another one. */
export async function load({ wasm } = {}) {
  const url = new URL("./dynmesh-core.wasm", import.meta.url);
  let bytes = wasm;
  if (bytes === undefined && url.protocol === "file:") {
    const { readFile } = await import("node:fs/promises");
    bytes = await readFile(url);
  } else if (bytes === undefined) {
    const response = await fetch(url);
    if (!response.ok) throw new DynmeshError("UNAVAILABLE", `${url}: ${response.status}`);
    bytes = await response.arrayBuffer();
  }
  return new Dynmesh(await instantiate({ wasmBinary: bytes }));
}
