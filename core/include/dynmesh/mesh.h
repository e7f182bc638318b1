// Results as plain data: a whole mesh, the difference of two, and the hashes
// that name and prove them. All ids are functions of coordinates alone, so that
// a restarted server, a replica and a file speak of the same vertices.
#ifndef DYNMESH_MESH_H_
#define DYNMESH_MESH_H_

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh {

// A fixed hash of a vertex's coordinates, never 0. No two vertices of a mesh have one id: a batch
// after which two would, whatever the salts below, is undone and refused with
// FAILED_PRECONDITION (ID_COLLISION).
using VertexId = std::uint64_t;

// The id of the vertex at `coordinates` (`dimension` of them; -0 counts as +0).
// `salt` is 0, but 1, 2, ... for vertices that have one id with salt 0 and come after the first in
// the order of coordinates.
VertexId VertexIdAt(const double* coordinates, int dimension, std::uint64_t salt = 0);

// 128 bits, added and subtracted per word modulo 2^64: the hash of a mesh is the
// sum over its vertices, simplices, subsegments and subfacets, hence updated by a diff.
struct MeshHash {
  std::uint64_t hi = 0;  // the first word
  std::uint64_t lo = 0;  // the second word
  // Adds the hash of a part that came.
  MeshHash& operator+=(const MeshHash& o) {
    hi += o.hi, lo += o.lo;
    return *this;
  }
  // Subtracts the hash of a part that went.
  MeshHash& operator-=(const MeshHash& o) {
    hi -= o.hi, lo -= o.lo;
    return *this;
  }
  friend bool operator==(const MeshHash&, const MeshHash&) = default;
  std::string ToHex() const;  // 32 lower-case hex digits, hi first
  // The hash that ToHex writes as `hex`; INVALID_ARGUMENT if that is none.
  static absl::StatusOr<MeshHash> FromHex(std::string_view hex);
};

// The number of the function from features to meshes. It goes up when the mesh of some features
// changes from one version to the next (CHANGELOG, "Bits"). Hashes are comparable within a number.
inline constexpr std::uint32_t kMeshBits = 6;

// What a vertex adds to the hash of its mesh: its `coordinates` (`dimension` of them), its
// `containing_dimension` and its `owner`, as in VertexColumns.
MeshHash HashVertex(const double* coordinates, int dimension, int containing_dimension,
                    FeatureId owner);
// Which polygon features a simplex lies in: 0 for none, the polygon's id for one alone,
// else RegionIdOf the several. A function of the set of polygons. Ids of sets are 2^63 and up,
// those of polygons below. No two sets of a mesh, as regions or at an edge of polygons, have one
// id: a batch after which two would is undone and refused with FAILED_PRECONDITION (ID_COLLISION).
//
// In space, which closed surfaces a tetrahedron lies inside of. Polygons are joined where they
// share an edge. Those whose inside falls into parts that touch in corners at most do not count,
// and those that have an edge which belongs to no other are peeled off, again and again, so that
// plates and flaps that dangle do not count either. What remains falls into pieces joined by edges.
// Each piece by itself leaves an outside, and chambers between its polygons; those around a chamber
// are a closed surface, so a wall between two chambers is part of two. A surface stands under the
// id of one of its polygons wherever a polygon's id is spoken of here: from the outside, and from
// chambers that have an id, the polygon of least id that leads into a chamber without one gives it
// its own. For a surface without inner walls that is the least id of its polygons.
using RegionId = std::uint64_t;
inline constexpr RegionId kNoRegion = 0;  // in no polygon

// In more polygons no place may lie: a batch after which one would is undone and refused with
// RESOURCE_EXHAUSTED (POLYGON_LIMIT). Regions of several polygons list them, so that without
// a limit n polygons in each other would take n^2 numbers to tell.
inline constexpr std::size_t kMostPolygonsAtAPlace = 1024;

// A region that lies in several polygons.
struct RegionSet {
  RegionId id = kNoRegion;          // RegionIdOf(polygons)
  std::vector<FeatureId> polygons;  // at least two, ascending
  friend bool operator==(const RegionSet&, const RegionSet&) = default;
};
// The id of the region inside exactly `polygons`, which are ascending and none twice. If there are
// several a fixed hash, with the top bit set.
RegionId RegionIdOf(std::span<const FeatureId> polygons);
// The polygons of a `region`, ascending. `sets` by ascending id; an id that is not there is
// that of a polygon.
std::vector<FeatureId> PolygonsOf(RegionId region, std::span<const RegionSet> sets);

// What a simplex adds to the hash of its mesh: its `count` vertices' `ids` in canonical order
// (SimplexColumn) and its `region`.
MeshHash HashSimplex(const VertexId* ids, int count, RegionId region = kNoRegion);
// What a subsegment from `a` to `b`, in any order, adds; `owner` as in SubsegmentColumns.
MeshHash HashSubsegment(VertexId a, VertexId b, FeatureId owner);
// What a subfacet with `corners`, in any order, adds; `owner` as in SubfacetColumns.
MeshHash HashSubfacet(const VertexId (&corners)[3], FeatureId owner);

// Columns of n vertices.
struct VertexColumns {
  std::vector<VertexId> ids;        // n
  std::vector<double> coordinates;  // n x dimension, vertex by vertex
  // 0: an input point or a point of the domain's grid, 1: on a segment, 2 in space: on a
  // polygon, dimension of the mesh: free.
  std::vector<std::uint8_t> containing_dimensions;
  // The feature it lies on; kNoFeature if free. On an edge of polygons: the segment feature
  // with the same ends if there is one, else the polygon of least id.
  std::vector<FeatureId> owners;
  std::size_t size() const { return ids.size(); }  // n
  friend bool operator==(const VertexColumns&, const VertexColumns&) = default;
};

// n simplices, dimension + 1 vertex ids each, positively oriented (in the plane:
// counter-clockwise; in space (b - a) . ((c - a) x (d - a)) > 0), the least id first and, in
// space, the next least second: its *canonical order*.
using SimplexColumn = std::vector<VertexId>;

// The pieces into which vertices cut the input segments and the box's sides.
struct SubsegmentColumns {
  std::vector<VertexId> ends;                         // n x 2, the lesser id first
  std::vector<FeatureId> owners;                      // n; as of vertices
  std::size_t size() const { return owners.size(); }  // n
  friend bool operator==(const SubsegmentColumns&, const SubsegmentColumns&) = default;
};

// In space: the triangles into which vertices cut the input polygons. Empty in the plane.
struct SubfacetColumns {
  std::vector<VertexId> corners;                      // n x 3, ascending
  std::vector<FeatureId> owners;                      // n; as of vertices
  std::size_t size() const { return owners.size(); }  // n
  friend bool operator==(const SubfacetColumns&, const SubfacetColumns&) = default;
};

// The region of each of n simplices; empty if none lies in a polygon.
using RegionColumn = std::vector<RegionId>;

// What a propagation did.
struct WorkCounters {
  std::uint64_t executed = 0;        // operation bodies run, new operations included
  std::uint64_t created = 0;         // operations that are new
  std::uint64_t dropped = 0;         // operations that are gone
  double microseconds = 0;           // whole Apply: validation, propagation, diff, hash
  double validate_microseconds = 0;  // of these, what validation took
  double diff_microseconds = 0;      // what making the diff took; the rest is the propagation
};

// A whole mesh at one revision. Rows are in no particular order unless
// Canonicalize was called.
struct Mesh {
  int dimension = 2;                   // 2 or 3
  std::uint64_t revision = 0;          // 0: as created, without features
  VertexColumns vertices;              // those of the domain box included
  SimplexColumn simplices;             // triangles, in space tetrahedra
  RegionColumn regions;                // of the simplices
  std::vector<RegionSet> region_sets;  // those of `regions` with several polygons, by id
  SubsegmentColumns subsegments;       // of features and of the domain box
  SubfacetColumns subfacets;           // in space
  MeshHash hash;                       // ComputeHash of this mesh

  // The number of triangles or tetrahedra.
  std::size_t simplex_count() const { return simplices.size() / (dimension + 1); }
  // The region of the simplex of that index: `simplex` is below simplex_count().
  RegionId region(std::size_t simplex) const {
    return regions.empty() ? kNoRegion : regions[simplex];
  }
};

// Mesh at `to_revision` less the mesh at `from_revision`. A vertex that keeps its
// place but changes owner or containing dimension stands in both vertex lists; a simplex
// that keeps its vertices but changes region, in both simplex lists.
struct MeshDiff {
  int dimension = 2;                       // of both meshes
  std::uint64_t from_revision = 0;         // of the mesh before
  std::uint64_t to_revision = 0;           // of the mesh after
  std::vector<VertexId> removed_vertices;  // their ids
  SimplexColumn removed_simplices;         // those that went
  RegionColumn removed_regions;            // of the removed simplices
  SubsegmentColumns removed_subsegments;   // those that went
  SubfacetColumns removed_subfacets;       // in space, those that went
  VertexColumns added_vertices;            // those that came
  SimplexColumn added_simplices;           // those that came
  RegionColumn added_regions;              // of the added simplices
  // Those of both with several polygons, by id. Where one id is of another set after than before
  // (only input made for it does that), the set after.
  std::vector<RegionSet> region_sets;
  SubsegmentColumns added_subsegments;  // those that came
  SubfacetColumns added_subfacets;      // in space, those that came
  WorkCounters work;                    // what making the diff cost
  MeshHash hash;                        // of the mesh at to_revision

  // The number of simplices that came.
  std::size_t added_simplex_count() const { return added_simplices.size() / (dimension + 1); }
  // The number of simplices that went.
  std::size_t removed_simplex_count() const { return removed_simplices.size() / (dimension + 1); }
};

// The sum of the hashes of all parts of `mesh`, from nothing. O(mesh).
MeshHash ComputeHash(const Mesh& mesh);

// Sorts every column of `mesh`: vertices by id, simplices, subsegments and subfacets
// lexicographically. O(n lg n). Drops a column of regions that says nothing, and region sets that
// no simplex names.
void Canonicalize(Mesh& mesh);
// The same with the columns of `diff`.
void Canonicalize(MeshDiff& diff);

// Applies `diff` to `mesh` (revision must be from_revision) and checks the hash.
// FAILED_PRECONDITION on a gap, DATA_LOSS if a part to remove is missing or the
// hash disagrees; `mesh` is then unspecified. O(mesh); see dynmesh/slot_mesh.h for O(diff).
absl::Status ApplyDiff(Mesh& mesh, const MeshDiff& diff);

}  // namespace dynmesh

#endif  // DYNMESH_MESH_H_
