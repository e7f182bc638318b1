// Results as plain data: a whole mesh, the diff of two meshes, and hashes that identify them. All
// ids are functions of coordinates alone. So a restarted server, a replica and a file name the same
// vertices alike.
//
//   for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
//     const dynmesh::VertexId* ids = &mesh.simplices[i * (mesh.dimension + 1)];
//     Use(ids, mesh.region(i));
//   }
//   absl::Status status = dynmesh::ApplyDiff(mesh, diff);  // now at diff.to_revision
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

// A fixed hash of a vertex's coordinates, never 0. Ids are unique in a mesh. A batch after which
// two vertices would have the same id, even with the salts below, is undone: FAILED_PRECONDITION
// (ID_COLLISION).
using VertexId = std::uint64_t;

// The id of the vertex at `coordinates` (`dimension` of them; -0 counts as +0). `salt` is 0. If
// several vertices have the same id with salt 0, those after the first, in the order of
// coordinates, get `salt` 1, 2, ...
VertexId VertexIdAt(const double* coordinates, int dimension, std::uint64_t salt = 0);

// 128 bits, added and subtracted per word modulo 2^64. The hash of a mesh is the sum of the hashes
// of its vertices, simplices, subsegments and subfacets. So a diff updates it.
struct MeshHash {
  std::uint64_t hi = 0;  // the first word
  std::uint64_t lo = 0;  // the second word
  // Adds the hash of an added part.
  MeshHash& operator+=(const MeshHash& o) {
    hi += o.hi, lo += o.lo;
    return *this;
  }
  // Subtracts the hash of a removed part.
  MeshHash& operator-=(const MeshHash& o) {
    hi -= o.hi, lo -= o.lo;
    return *this;
  }
  friend bool operator==(const MeshHash&, const MeshHash&) = default;
  std::string ToHex() const;  // 32 lower-case hex digits, hi first
  // The hash that ToHex writes as `hex`; INVALID_ARGUMENT if `hex` is not 32 hex digits.
  static absl::StatusOr<MeshHash> FromHex(std::string_view hex);
};

// The version of the function from features to meshes. It increases whenever a release makes
// another mesh of some features (CHANGELOG, "Bits"). Compare hashes only within a version.
inline constexpr std::uint32_t kMeshBits = 10;

// A vertex's part of the hash of its mesh: from its `coordinates` (`dimension` of them), its
// `containing_dimension` and its `owner`, as in VertexColumns.
MeshHash HashVertex(const double* coordinates, int dimension, int containing_dimension,
                    FeatureId owner);
// The set of polygon features that a simplex lies in: 0 for none, the polygon's id for one, else
// RegionIdOf(polygons). Ids of sets are 2^63 and up, those of polygons below. They are unique in a
// mesh, for regions and for edges of polygons. A batch after which two sets would have the same id
// is undone: FAILED_PRECONDITION (ID_COLLISION).
//
// In 3D, the set of closed surfaces around a tetrahedron. A surface has the id of one of its
// polygons, which stands for "polygon's id" here: without inner walls, that of its polygon of least
// id. In general:
//   1. Polygons are joined where they share an edge. Not counted are polygons that fall into parts
//      that touch at most in corners.
//   2. Polygons with an edge that no other polygon has are removed repeatedly: plates and flaps
//      that dangle do not count.
//   3. The rest falls into components joined by edges. Each component leaves an outside and
//      chambers between its polygons. The polygons around a chamber are a closed surface; a wall
//      between two chambers is part of two.
//   4. Surfaces get ids from the outside inwards. Repeatedly, among the polygons that lead from the
//      outside or from a chamber with an id into a chamber without, that of least id gives the
//      chamber its id.
using RegionId = std::uint64_t;
inline constexpr RegionId kNoRegion = 0;  // in no polygon

// The most polygons that a position may lie in. A batch that exceeds it is undone:
// RESOURCE_EXHAUSTED (POLYGON_LIMIT). A region lists its polygons, so without a limit n nested
// polygons would take n^2 numbers.
inline constexpr std::size_t kMostPolygonsAtAPlace = 1024;

// A region that lies in several polygons.
struct RegionSet {
  RegionId id = kNoRegion;          // RegionIdOf(polygons)
  std::vector<FeatureId> polygons;  // at least two, ascending
  friend bool operator==(const RegionSet&, const RegionSet&) = default;
};
// The id of the region inside exactly `polygons`, ascending and without duplicates. For several
// polygons a fixed hash with the top bit set.
RegionId RegionIdOf(std::span<const FeatureId> polygons);
// The polygons of a `region`, ascending. `sets` are in ascending order of id; an id not among them
// is a polygon's.
std::vector<FeatureId> PolygonsOf(RegionId region, std::span<const RegionSet> sets);

// A simplex's part of the hash of its mesh: from its `count` vertex `ids` in canonical order
// (SimplexColumn) and its `region`.
MeshHash HashSimplex(const VertexId* ids, int count, RegionId region = kNoRegion);
// A subsegment's part: of the ends `a` and `b`, in any order, and `owner`, as in SubsegmentColumns.
MeshHash HashSubsegment(VertexId a, VertexId b, FeatureId owner);
// A subfacet's part: of `corners`, in any order, and `owner`, as in SubfacetColumns.
MeshHash HashSubfacet(const VertexId (&corners)[3], FeatureId owner);

// Columns of n vertices.
struct VertexColumns {
  std::vector<VertexId> ids;        // n
  std::vector<double> coordinates;  // n x dimension, vertex by vertex
  // The dimension of the input that the vertex lies on. 0: an input point or a point of the
  // domain's grid. 1: a segment. 2 in 3D: a polygon. The mesh's dimension: none (a free vertex).
  std::vector<std::uint8_t> containing_dimensions;
  // The feature that the vertex lies on; kNoFeature if it is free. On an edge of polygons: the
  // segment feature with the same ends if present, else the polygon of least id.
  std::vector<FeatureId> owners;
  std::size_t size() const { return ids.size(); }  // n
  friend bool operator==(const VertexColumns&, const VertexColumns&) = default;
};

// n simplices, dimension + 1 vertex ids each, positively oriented. 2D: counter-clockwise. 3D:
// (b - a) . ((c - a) x (d - a)) > 0. The least id comes first and, in 3D, the second least second:
// the *canonical order*.
using SimplexColumn = std::vector<VertexId>;

// The subsegments: vertices cut the input segments and the sides of the domain box into them.
struct SubsegmentColumns {
  std::vector<VertexId> ends;                         // n x 2, the lesser id first
  std::vector<FeatureId> owners;                      // n; as in VertexColumns
  std::size_t size() const { return owners.size(); }  // n
  friend bool operator==(const SubsegmentColumns&, const SubsegmentColumns&) = default;
};

// 3D: the subfacets, triangles into which vertices cut the input polygons. Empty in 2D.
struct SubfacetColumns {
  std::vector<VertexId> corners;                      // n x 3, ascending
  std::vector<FeatureId> owners;                      // n; as in VertexColumns
  std::size_t size() const { return owners.size(); }  // n
  friend bool operator==(const SubfacetColumns&, const SubfacetColumns&) = default;
};

// The region of each of n simplices; empty if none lies in a polygon.
using RegionColumn = std::vector<RegionId>;

// A feature's label.
struct LabelOfFeature {
  FeatureId id = kNoFeature;  // the feature
  FeatureLabel label = {};    // its marker and name
  friend bool operator==(const LabelOfFeature&, const LabelOfFeature&) = default;
};
// Labels by ascending id, one a feature. They are functions of the features, as a mesh is. No hash
// depends on them.
using LabelColumn = std::vector<LabelOfFeature>;

// Work of one propagation.
struct WorkCounters {
  std::uint64_t executed = 0;        // operations run, new ones included
  std::uint64_t created = 0;         // new operations
  std::uint64_t dropped = 0;         // removed operations
  double microseconds = 0;           // whole Apply: validation, propagation, diff, hash
  double validate_microseconds = 0;  // the validation's part of it
  double diff_microseconds = 0;      // the diff's part; the rest is the propagation
  std::uint64_t notified = 0;        // operations asked whether a change matters to them
  std::uint64_t visited_cells = 0;   // of the vertex tree, because of sizes that came or went
  std::uint64_t visited_nodes = 0;   // of lattices, one by one or in groups, because of those
};

// A whole mesh at one revision. Rows are in no particular order unless Canonicalize was called.
struct Mesh {
  int dimension = 2;                   // 2 or 3
  std::uint64_t revision = 0;          // 0: as created, without features
  VertexColumns vertices;              // domain box included
  SimplexColumn simplices;             // triangles, in 3D tetrahedra
  RegionColumn regions;                // of the simplices
  std::vector<RegionSet> region_sets;  // those of `regions` with several polygons, by id
  SubsegmentColumns subsegments;       // of features and of the domain box
  SubfacetColumns subfacets;           // 3D only
  LabelColumn labels;                  // of all features that have one; none is empty
  MeshHash hash;                       // ComputeHash of this mesh

  // The number of triangles or tetrahedra.
  std::size_t simplex_count() const { return simplices.size() / (dimension + 1); }
  // The region of simplex number `simplex`, which is below simplex_count().
  RegionId region(std::size_t simplex) const {
    return regions.empty() ? kNoRegion : regions[simplex];
  }
};

// The mesh at `to_revision` minus the mesh at `from_revision`. A vertex that keeps its coordinates
// but changes owner or containing dimension is in both vertex lists. A simplex that keeps its
// vertices but changes region is in both simplex lists.
struct MeshDiff {
  int dimension = 2;                       // of both meshes
  std::uint64_t from_revision = 0;         // of the mesh before
  std::uint64_t to_revision = 0;           // of the mesh after
  std::vector<VertexId> removed_vertices;  // their ids
  SimplexColumn removed_simplices;         // of the first mesh only
  RegionColumn removed_regions;            // of the removed simplices
  SubsegmentColumns removed_subsegments;   // of the first mesh only
  SubfacetColumns removed_subfacets;       // 3D: of the first mesh only
  VertexColumns added_vertices;            // of the second mesh only
  SimplexColumn added_simplices;           // of the second mesh only
  RegionColumn added_regions;              // of the added simplices
  // The sets of several polygons that both region columns name, by id. If an id stands for
  // different sets before and after (only input made for it does that), the set after.
  std::vector<RegionSet> region_sets;
  SubsegmentColumns added_subsegments;  // of the second mesh only
  SubfacetColumns added_subfacets;      // 3D: of the second mesh only
  // The labels that features of the second mesh have and did not have before. An empty one says
  // that the feature has none any more: it was cleared, or went with its feature. A diff of several
  // revisions may also have labels that are as before.
  LabelColumn labels;
  WorkCounters work;  // cost of making the diff
  MeshHash hash;      // of the mesh at to_revision

  // The number of added simplices.
  std::size_t added_simplex_count() const { return added_simplices.size() / (dimension + 1); }
  // The number of removed simplices.
  std::size_t removed_simplex_count() const { return removed_simplices.size() / (dimension + 1); }
};

// The sum of the hashes of all parts of `mesh`, from scratch. O(mesh).
MeshHash ComputeHash(const Mesh& mesh);

// Sorts every column of `mesh`: vertices by id, simplices, subsegments and subfacets
// lexicographically. Clears `regions` if all are kNoRegion, and drops region sets that no simplex
// names. Labels are in order already. O(n lg n).
void Canonicalize(Mesh& mesh);
// The same with the columns of `diff`.
void Canonicalize(MeshDiff& diff);

// Applies `diff` to `mesh` and checks the hash. O(mesh); for O(diff) see dynmesh/slot_mesh.h.
// INVALID_ARGUMENT if columns disagree in length or dimension, or labels do not ascend;
// FAILED_PRECONDITION if mesh.revision is not diff.from_revision; DATA_LOSS if a removed part is
// absent, an added one present, or the hash disagrees. `mesh` is unspecified after an error.
absl::Status ApplyDiff(Mesh& mesh, const MeshDiff& diff);

}  // namespace dynmesh

#endif  // DYNMESH_MESH_H_
