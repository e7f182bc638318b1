// A diff as columns: what goes, then what comes. A snapshot's chunk is a diff that removes nothing.
import type {
  MeshDiff,
  SimplexColumn,
  SnapshotChunk,
  SubfacetColumns,
  SubsegmentColumns,
  VertexColumns,
} from '../../gen/dynmesh/v1/mesh_pb.js';
import { doubles, varints, words } from './columns.js';

/** Ids have two numbers each, the lower half first; so have regions and owners. */
export interface Simplices {
  ids: Uint32Array;
  /** Empty: all 0. */
  regions: Uint32Array;
}

export interface Constraints {
  ids: Uint32Array;
  owners: Uint32Array;
}

export interface VertexRows {
  ids: Uint32Array;
  coordinates: Float64Array;
  containingDimensions: Uint8Array;
  owners: Uint32Array;
}

export interface Removed {
  simplices: Simplices;
  subsegments: Constraints;
  subfacets: Constraints;
  vertices: Uint32Array;
}

export interface Added {
  vertices: VertexRows;
  subsegments: Constraints;
  subfacets: Constraints;
  simplices: Simplices;
}

const none = new Uint8Array(0);

export function removedBy(diff: MeshDiff): Removed {
  return {
    simplices: simplices(diff.removedSimplices, diff.dimension),
    subsegments: subsegments(diff.removedSubsegments),
    subfacets: subfacets(diff.removedSubfacets),
    vertices: words(diff.removedVertices),
  };
}

export function addedBy(diff: MeshDiff): Added {
  return {
    vertices: vertices(diff.addedVertices, diff.dimension),
    subsegments: subsegments(diff.addedSubsegments),
    subfacets: subfacets(diff.addedSubfacets),
    simplices: simplices(diff.addedSimplices, diff.dimension),
  };
}

export function addedByChunk(chunk: SnapshotChunk): Added {
  return {
    vertices: vertices(chunk.vertices, chunk.dimension),
    subsegments: subsegments(chunk.subsegments),
    subfacets: subfacets(chunk.subfacets),
    simplices: simplices(chunk.simplices, chunk.dimension),
  };
}

function vertices(rows: VertexColumns | undefined, dimension: number): VertexRows {
  const result = {
    ids: words(rows?.ids ?? none),
    coordinates: doubles(rows?.coordinates ?? none),
    // A copy: a view would keep the bytes of the whole message.
    containingDimensions: rows?.containingDimensions.slice() ?? none,
    owners: varints(rows?.owners ?? none),
  };
  const count = result.ids.length / 2;
  expectLength(result.coordinates, count * dimension);
  expectLength(result.containingDimensions, count);
  expectLength(result.owners, 2 * count);
  return result;
}

function simplices(rows: SimplexColumn | undefined, dimension: number): Simplices {
  const result = { ids: words(rows?.vertexIds ?? none), regions: words(rows?.regions ?? none) };
  if (result.regions.length > 0) {
    expectLength(result.ids, result.regions.length * (dimension + 1));
  } else if (result.ids.length % (2 * (dimension + 1)) !== 0) {
    throw new RangeError('a simplex is cut off');
  }
  return result;
}

function subsegments(rows: SubsegmentColumns | undefined): Constraints {
  const result = { ids: words(rows?.ends ?? none), owners: varints(rows?.owners ?? none) };
  expectLength(result.ids, 2 * result.owners.length);
  return result;
}

function subfacets(rows: SubfacetColumns | undefined): Constraints {
  const result = { ids: words(rows?.corners ?? none), owners: varints(rows?.owners ?? none) };
  expectLength(result.ids, 3 * result.owners.length);
  return result;
}

function expectLength(column: { length: number }, length: number): void {
  if (column.length !== length) throw new RangeError('columns disagree in length');
}
