// What a mesh is asked to be. Fixed when the mesh is created.
#ifndef DYNMESH_OPTIONS_H_
#define DYNMESH_OPTIONS_H_

#include <array>
#include <cstdint>

#include "absl/status/status.h"

namespace dynmesh {

// An axis-parallel box, closed. Entries past the dimension are ignored.
struct Box {
  std::array<double, 3> lo = {0, 0, 0};  // the least coordinates
  std::array<double, 3> hi = {1, 1, 1};  // the greatest, each above that of lo
  friend bool operator==(const Box&, const Box&) = default;
};

// When is refinement done? kEdge: every simplex has circumradius / shortest
// edge <= quality. kThesis: every vertex's Voronoi cell lies within quality
// times its nearest-neighbour distance (stronger, 1.6 to 2.2 times the vertices).
enum class Criterion : std::uint8_t { kEdge = 1, kThesis = 2 };

// As many vertices as a mesh of that `dimension` can have, whatever its limits: what refers to
// vertices, simplices and operations has 32 bits, of which some mean something else.
//   * 2D: 2^27. An edit may hold the vertices before and after it, and those of its way back: 2^29
//     of the 2^30 that outputs of operations tell apart. Triangles are two to a vertex: 2^28 of
//     2^30; operations about three: 2^29 of 2^31.
//   * 3D: 60 million. Tetrahedra are 6.8 to a vertex in meshes of ordinary input, and an insertion
//     may hold two more for each vertex while it lasts: 528 of 2^29 = 537 million. A mesh with
//     more of them to a vertex, as a high `quality` allows, has room for fewer vertices.
//
// What fills an index all the same is undone and refused with RESOURCE_EXHAUSTED (SIZE_LIMIT), and
// so is a vertex with more than 2^24 neighbours.
constexpr std::uint64_t MostVertices(int dimension) {
  return dimension == 3 ? 60'000'000 : std::uint64_t{1} << 27;
}

// What a mesh may grow to.
struct Limits {
  // Most vertices a mesh may have, those of the domain box included; at most
  // MostVertices(dimension). An edit that would pass it is undone and refused with
  // RESOURCE_EXHAUSTED.
  std::uint64_t max_vertices = 50'000'000;
  // Most halvings of an input segment; a fuse, far above what valid input needs.
  int max_depth = 60;
  friend bool operator==(const Limits&, const Limits&) = default;
};

inline constexpr double kMinQuality2D = 1.0;  // the least MeshOptions::quality in the plane
inline constexpr double kMinThesisQuality2D = 1.4142;  // below, kThesis need not end
inline constexpr double kMinQuality3D = 1.2;           // the same in space
inline constexpr double kMinPolygonQuality3D = 1.4;    // below, refinement at facets need not end
inline constexpr double kMinThesisQuality3D = 2.0;     // the thesis's proof wants more than 2
inline constexpr double kMaxQuality = 100.0;           // the greatest
inline constexpr double kDefaultQuality2D = 1.4142135623730951;  // no angle below 20.7 degrees
inline constexpr double kDefaultQuality3D = 2.0;                 // suits most input
inline constexpr double kMaxMinDihedral = 20;        // the greatest MeshOptions::min_dihedral
inline constexpr double kDefaultMinDihedral3D = 10;  // suits most input
// What the service, scripts and commands take for a mesh of `dimension` (2 or 3) where no quality
// is asked for.
constexpr double DefaultQuality(int dimension) {
  return dimension == 3 ? kDefaultQuality3D : kDefaultQuality2D;
}
// The same of MeshOptions::min_dihedral: 10 if `dimension` is 3, 0 if it is 2.
constexpr double DefaultMinDihedral(int dimension) {
  return dimension == 3 ? kDefaultMinDihedral3D : 0;
}

// What is asked of a mesh. The length of everything is in the units of `box`.
struct MeshOptions {
  int dimension = 2;  // 2 or 3
  Box box;            // where features may lie
  // rho, the largest circumradius / shortest edge: 1 to 100 in the plane, where
  // the least angle is arcsin(1 / (2 rho)): 20.7 degrees at the default, 30 at 1; 1.2 to 100
  // in space, 1.4 if there are to be polygons, where DefaultQuality(3) suits most. For kThesis from
  // 1.4142 and 2.
  double quality = kDefaultQuality2D;
  Criterion criterion = Criterion::kEdge;  // what `quality` bounds
  // No edge of a simplex that meets `box` is longer than sqrt(2) times this; 0: any may be.
  double max_edge = 0;
  // In 3D: no tetrahedron is to have a dihedral angle less than that many degrees. Of those that
  // have, each gets a Steiner point where there is one that makes no other: up to
  // kMaxMinDihedral; DefaultMinDihedral(3) suits most. Below 0.01 as if it were 0.01: 0 leaves
  // slivers, but hardly a tetrahedron that is flat but for rounding.
  double min_dihedral = 0;
  Limits limits;  // an edit that would pass one is refused
  friend bool operator==(const MeshOptions&, const MeshOptions&) = default;
};

// INVALID_ARGUMENT, naming the field, unless a mesh can be made with `options`.
absl::Status ValidateOptions(const MeshOptions& options);

// The square or cube that is meshed for `options`: the user's box in its middle (algorithm:
// Sec. 4.4 of the thesis). Vertices and segments of its border belong to
// kBoxFeature.
Box DomainBox(const MeshOptions& options);
// Vertices along each side of the border of DomainBox(`options`), corners included: N of Sec. 4.4.
int BorderVertices(const MeshOptions& options);

}  // namespace dynmesh

#endif  // DYNMESH_OPTIONS_H_
