// What a mesh is created with. Fixed for its life.
//
//   dynmesh::MeshOptions options;
//   options.dimension = 3;
//   options.box = {{0, 0, 0}, {10, 10, 5}};
//   options.quality = dynmesh::DefaultQuality(3);
//   options.min_dihedral = dynmesh::DefaultMinDihedral(3);
#ifndef DYNMESH_OPTIONS_H_
#define DYNMESH_OPTIONS_H_

#include <array>
#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dynmesh {

// An axis-parallel box, closed. Entries past the dimension are ignored.
struct Box {
  std::array<double, 3> lo = {0, 0, 0};  // the least coordinates
  std::array<double, 3> hi = {1, 1, 1};  // the greatest, each at least that of lo
  friend bool operator==(const Box&, const Box&) = default;
};

// What follows the features. kDelaunay: a quality Delaunay mesh. kQuadtree: a size-conforming
// quadtree, in 3D an octree (quadtree.h). kTriangulation, 2D only: the constrained Delaunay
// triangulation of the points and segments, without Steiner points: no angle is bounded. It covers
// the same square as a mesh of kind kDelaunay. Sizing features are refused.
enum class MeshKind : std::uint8_t { kDelaunay = 1, kQuadtree = 2, kTriangulation = 3 };

// "delaunay", "quadtree" or "triangulation": the word for `kind` in scripts, commands and Python.
std::string_view NameOf(MeshKind kind);
// The kind with that `name`; INVALID_ARGUMENT, naming those that there are, if there is none.
absl::StatusOr<MeshKind> MeshKindOf(std::string_view name);

// The bound that `quality` is. kEdge: circumradius / shortest edge <= quality for every simplex.
// kThesis: every vertex's Voronoi cell lies within quality times the distance to its nearest
// neighbour. kThesis is stronger: 1.6 to 2.2 times the vertices.
enum class Criterion : std::uint8_t { kEdge = 1, kThesis = 2 };

// The most vertices of a mesh of `dimension`, whatever its limits. Vertices, simplices and
// operations have 32-bit indices, with some bits reserved.
//   * 2D: 2^27. An edit may hold the vertices before and after it and those of its undo: 2^29 of
//     the 2^30 that outputs of operations distinguish. Triangles are 2 a vertex: 2^28 of 2^30.
//     Operations are about 3 a vertex: 2^29 of 2^31.
//   * 3D: 60 million. Tetrahedra are 6.8 a vertex in meshes of ordinary input. An insertion may
//     hold 2 more a vertex while it lasts: 528 of 2^29 = 537 million. A mesh with more tetrahedra a
//     vertex, as a high `quality` allows, has room for fewer vertices.
//
// A batch that exhausts an index is undone: RESOURCE_EXHAUSTED (SIZE_LIMIT). So is one that makes a
// vertex with more than 2^24 neighbours.
constexpr std::uint64_t MostVertices(int dimension) {
  return dimension == 3 ? 60'000'000 : std::uint64_t{1} << 27;
}

// Limits of a mesh's growth.
struct Limits {
  // The most vertices of the mesh, domain box included; at most MostVertices(dimension). An edit
  // that needs more is undone: RESOURCE_EXHAUSTED (VERTEX_LIMIT). Of a quadtree: the most leaves.
  std::uint64_t max_vertices = 50'000'000;
  // The most halvings of an input segment, far more than valid input needs. An edit that needs more
  // is undone: RESOURCE_EXHAUSTED (DEPTH_LIMIT).
  int max_depth = 60;
  friend bool operator==(const Limits&, const Limits&) = default;
};

inline constexpr double kMinQuality2D = 1.0;           // the least MeshOptions::quality in 2D
inline constexpr double kMinThesisQuality2D = 1.4142;  // below, kThesis may not terminate
inline constexpr double kMinQuality3D = 1.2;           // the least MeshOptions::quality in 3D
inline constexpr double kMinPolygonQuality3D = 1.4;    // below, facets may refine without end
inline constexpr double kMinThesisQuality3D = 2.0;     // proof: points >1, segments >2, facets >4
inline constexpr double kMaxQuality = 100.0;           // the greatest MeshOptions::quality
inline constexpr double kDefaultQuality2D = 1.4142135623730951;  // no angle below 20.7 degrees
inline constexpr double kDefaultQuality3D = 2.0;                 // suits most input
inline constexpr double kMaxMinDihedral = 20;        // the greatest MeshOptions::min_dihedral
inline constexpr double kDefaultMinDihedral3D = 10;  // suits most input
// The default `quality` of the service, scripts and commands for a mesh of `dimension` (2 or 3).
constexpr double DefaultQuality(int dimension) {
  return dimension == 3 ? kDefaultQuality3D : kDefaultQuality2D;
}
// Their default MeshOptions::min_dihedral: 10 if `dimension` is 3 and `kind` is kDelaunay, else 0.
constexpr double DefaultMinDihedral(int dimension, MeshKind kind = MeshKind::kDelaunay) {
  return dimension == 3 && kind == MeshKind::kDelaunay ? kDefaultMinDihedral3D : 0;
}

// The options of a mesh. Lengths are in the units of `box`.
struct MeshOptions {
  int dimension = 2;  // 2 or 3
  Box box;            // where features may lie
  // The bound rho of `criterion`. 2D: 1 to 100; the least angle is arcsin(1 / (2 rho)): 20.7
  // degrees at the default, 30 at 1. 3D: 1.2 to 100, 1.4 with polygons; DefaultQuality(3) suits
  // most input. kThesis: from 1.4142 in 2D, from 2 in 3D.
  double quality = kDefaultQuality2D;
  Criterion criterion = Criterion::kEdge;  // what `quality` bounds
  // No edge of a simplex that meets `box` is longer than sqrt(2) times this; 0: no bound.
  double max_edge = 0;
  // 3D: the least dihedral angle to aim for, in degrees, 0 to kMaxMinDihedral;
  // DefaultMinDihedral(3) suits most input. Each tetrahedron with a smaller angle gets a Steiner
  // point, if a tried one makes no new such tetrahedron. Values below 0.01 act as 0.01: 0 leaves
  // slivers, but hardly a tetrahedron that is flat but for rounding.
  double min_dihedral = 0;
  Limits limits;  // an edit that exceeds one is undone
  // kQuadtree, kTriangulation: `quality`, `criterion`, `max_edge` and `min_dihedral` do not apply.
  // They must be the default of the dimension, kEdge, 0 and 0.
  MeshKind kind = MeshKind::kDelaunay;
  friend bool operator==(const MeshOptions&, const MeshOptions&) = default;
};

// OK if a mesh can be made with `options`, else INVALID_ARGUMENT (BAD_OPTION), naming the field.
absl::Status ValidateOptions(const MeshOptions& options);

// The square or cube that is meshed for `options`. kDelaunay: the user's box is in its middle (Sec.
// 4.4 of the thesis), and kBoxFeature owns the vertices and segments of its border. kQuadtree: the
// root cell, see quadtree.h.
Box DomainBox(const MeshOptions& options);
// N of Sec. 4.4: vertices along each side of DomainBox(`options`), corners included.
int BorderVertices(const MeshOptions& options);

}  // namespace dynmesh

#endif  // DYNMESH_OPTIONS_H_
