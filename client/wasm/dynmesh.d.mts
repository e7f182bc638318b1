/** dynmesh: dynamic meshes in this process. Features in, arrays by slot out. */

/** An id of a feature. From typed arrays and as results these are bigints. */
export type Id = number | bigint;
/** Ids, one after the other. */
export type Ids = BigUint64Array | Iterable<Id>;
/** Numbers, one after the other. */
export type Numbers = Float64Array | Iterable<number>;
/** Is the feature new, or may it replace the one with that id? Default: add. */
export interface Action {
  action?: "add" | "set";
}

export type Code =
  | "CANCELLED" | "INTERNAL" | "INVALID_ARGUMENT" | "NOT_FOUND" | "ALREADY_EXISTS"
  | "RESOURCE_EXHAUSTED" | "FAILED_PRECONDITION" | "OUT_OF_RANGE" | "UNIMPLEMENTED"
  | "UNAVAILABLE" | "DATA_LOSS";

/** What the library reports. A call that throws it has changed nothing. */
export class DynmeshError extends Error {
  readonly code: Code;
  /** As "POINT_IN_USE", stable; empty: none. */
  readonly reason: string;
  /** Those involved, the one to blame first: 8 at most. */
  readonly features: bigint[];
  /** The number of the batch's edit to blame, from 0. */
  readonly edit: number | undefined;
}

/** What a mesh is made with; what is left out has its default. */
export interface Options {
  /** Default: 2. */
  dimension?: 2 | 3;
  kind?: "delaunay" | "quadtree" | "triangulation";
  criterion?: "edge" | "thesis";
  /** The box of the features. Default: the unit square or cube. */
  low?: readonly number[] | Float64Array;
  high?: Options["low"];
  /** The largest ratio of circumradius and shortest edge. */
  quality?: number;
  /** No edge in the box is longer than sqrt 2 times this; 0: no bound. */
  maxEdge?: number;
  /** In 3D, in degrees. */
  minDihedral?: number;
  maxVertices?: Id;
}

/** An object in the module's memory. */
export interface Handle {
  /** Frees it. Without it that is done some time after the last reference is gone. */
  close(): void;
}

/** Edits to be applied together. Each method that appends returns the batch. */
export interface Batch extends Handle {
  readonly dimension: number;
  /** Edits so far. */
  readonly length: number;
  clear(): this;
  /** Points at places: as many coordinates a point as the batch has dimensions. */
  addPoints(ids: Ids, places: Numbers, options?: Action): this;
  /** Segments between points: two ids each. */
  addSegments(ids: Ids, ends: Ids, options?: Action): this;
  /** A polygon: the points of each of its rings. */
  addPolygon(id: Id, rings: Iterable<Iterable<Id>>, options?: Action): this;
  /** Target lengths within radii of places; without radii, at the places. */
  addSizes(ids: Ids, places: Numbers, targets: Numbers, options?: Action & { radii?: Numbers }): this;
  movePoints(ids: Ids, places: Numbers): this;
  remove(ids: Ids): this;
  /** The label of a feature; 0 and "" take it away. */
  setLabel(id: Id, label: { marker?: Id; name?: string }): this;
}

/** Arrays by slot. A vertex or cell keeps its row, its slot, while it exists. */
export interface MeshArrays {
  points: Float64Array;
  /** 0: the slot is free. */
  vertexIds: BigUint64Array;
  owners: BigUint64Array;
  on: Uint8Array;
  /** Slots of vertices, dimension + 1 a cell; -1: the slot is free. */
  cells: Int32Array;
  neighbours: Int32Array;
  regions: BigUint64Array;
  subsegments: Int32Array;
  subsegmentOwners: BigUint64Array;
  subfacets: Int32Array;
  subfacetOwners: BigUint64Array;
}

/** What the last batch changed. */
export interface DiffArrays {
  removedVertices: Int32Array;
  addedVertices: Int32Array;
  removedCells: Int32Array;
  removedCorners: Int32Array;
  removedRegions: BigUint64Array;
  addedCells: Int32Array;
  relabelledCells: Int32Array;
  formerRegions: BigUint64Array;
}

export interface PartArrays {
  points: Float64Array;
  vertexSlots: Int32Array;
  cells: Int32Array;
  cellSlots: Int32Array;
  regions: BigUint64Array;
  facets: Int32Array;
  facetOwners: BigUint64Array;
  facetCells: Int32Array;
}

export interface Field {
  /** Default: p1, a value a vertex. */
  kind?: "p0" | "p0Linear" | "p1" | "dg1" | "dual" | "dualCorners" | "overlap";
  components?: number;
  rings?: number;
  bounded?: boolean;
}

export interface Choice {
  polygons?: Ids & { length: number };
  without?: Ids;
  /** Segments and polygons along which the part is opened, as cracks are. */
  open?: Ids;
  /** All that polygons enclose: the default if `polygons` are not given. */
  inside?: boolean;
}

/** The part of a mesh in polygons, without gaps. */
export interface Part extends Handle {
  /** Follows the mesh. */
  update(mesh: Mesh): this;
  array<K extends keyof PartArrays>(which: K): PartArrays[K];
}

export interface Mesh extends Handle {
  readonly dimension: 2 | 3;
  /** The number of batches applied that changed something. */
  readonly revision: number;
  /** 32 hexadecimal digits: equal for equal meshes, as all interfaces of dynmesh have it. */
  readonly hash: string;
  count(which: "vertices" | "cells" | "vertexSlots" | "cellSlots" | "features"): number;
  /** Makes the next revision: all edits or none. */
  apply(batch: Batch, options?: { maxOperations?: Id }): this;
  /** A copy of a column of the mesh. */
  array<K extends keyof MeshArrays>(which: K): MeshArrays[K];
  /** A copy of a column of what the last batch changed. */
  diff<K extends keyof DiffArrays>(which: K): DiffArrays[K];
  /** For each place the slot of a cell that contains it; -1 outside. */
  locate(places: Numbers): Int32Array;
  /** The field across the last batch: a row of each slot that there is now. Rows that `values` does
   * not have yet count as nothing. */
  carry(values: Float64Array, field?: Field): Float64Array;
  part(choice?: Choice): Part;
  /** The files that the mesh, or a part of it, is written as, by the extension of `name`. */
  write(name: string, options?: {
    part?: Part; order2?: boolean; fromZero?: boolean; binary?: boolean; inputMarkers?: boolean;
  }): Record<string, Uint8Array>;
}

/** The content of a file. */
export interface Input extends Handle {
  /** For a mesh of it. */
  readonly options: Required<Options>;
  /** A mesh of all its features, with these options in place of its own. */
  openMesh(dynmesh: Dynmesh, options?: Options): Mesh;
}

export interface Dynmesh {
  /** "MAJOR.MINOR.PATCH". */
  readonly version: string;
  /** Bytes of memory that the module has. */
  readonly memory: number;
  /** A mesh of the bare box, at revision 0. */
  open(options?: Options): Mesh;
  /** An empty batch. Default of the dimension: 2. */
  batch(dimension?: 2 | 3): Batch;
  /** A file by its extension; a format of several files takes them by their names. */
  read(name: string, files: Uint8Array | Record<string, Uint8Array>, options?: {
    mergeCoplanar?: boolean; mapPolygons?: boolean; refine?: boolean; keepFacets?: boolean;
  }): Input;
}

/** Loads the module: from beside this file, or the bytes given. Each call makes another one. */
export function load(options?: { wasm?: ArrayBuffer | Uint8Array }): Promise<Dynmesh>;
