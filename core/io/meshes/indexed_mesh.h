// A mesh as in files: vertices by number, every edge listed. The order of rows is canonical, so the
// same mesh gives the same file, byte by byte:
//   vertices:  input points by feature id (a `.node` file's points 1..n keep their
//              numbers), then the domain box's, those on segments, free ones; each
//              of these by coordinates, lexicographically
//   simplices: in 2D triangles, counter-clockwise from the least number; in 3D
//              tetrahedra, positively oriented (dynmesh/mesh.h), the least number first, the
//              second least second; lexicographically; with the number of each one's region
//   edges:     lesser number first; lexicographically
//   faces:     in 3D, the subfacets and the triangles with only one tetrahedron (these
//              belong to the box unless they are subfacets), no others. Numbers ascending;
//              lexicographically
// Plain data.
#ifndef DYNMESH_CORE_IO_MESHES_INDEXED_MESH_H_
#define DYNMESH_CORE_IO_MESHES_INDEXED_MESH_H_

#include <array>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/meshes/region_numbers.h"
#include "core/io/meshes/row_labels.h"
#include "dynmesh/mesh.h"
#include "dynmesh/quality.h"

namespace dynmesh::io {

struct IndexedMesh {
  struct Vertex {
    double x = 0;
    double y = 0;
    int containing_dimension = 0;
    FeatureId owner = kNoFeature;
    double z = 0;  // 0 in 2D
    std::array<double, 3> position() const { return {x, y, z}; }
    friend bool operator==(const Vertex&, const Vertex&) = default;
  };
  template <int D>
  using Simplex = std::array<std::uint32_t, D + 1>;
  using Triangle = Simplex<2>;
  using Tetrahedron = Simplex<3>;
  struct Edge {
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    FeatureId owner = kNoFeature;  // of the subsegment, if it is one
    friend bool operator==(const Edge&, const Edge&) = default;
  };

  struct Face {
    std::array<std::uint32_t, 3> corners = {0, 0, 0};
    FeatureId owner = kNoFeature;  // of the subfacet, if it is one, else the box
    friend bool operator==(const Face&, const Face&) = default;
  };

  int dimension = 2;
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;      // 2D
  std::vector<Tetrahedron> tetrahedra;  // 3D
  RegionNumbers regions;                // of the simplices
  std::vector<Edge> edges;              // all of them
  std::vector<Face> faces;              // 3D
  // Order 2: the vertices from here on are the midpoints of `edges`, in their order. 0: order 1.
  std::uint32_t first_midpoint = 0;
  RowLabels labels;  // what the input says of rows; IndexMesh leaves it empty
  // Of IndexMesh: the mesh's ids are those that ToMesh makes, so its hash is that of ToMesh.
  bool has_plain_ids = false;

  // Of the mesh's dimension.
  std::size_t simplex_count() const {
    return dimension == 2 ? triangles.size() : tetrahedra.size();
  }
  int order() const { return first_midpoint == 0 ? 1 : 2; }
  // O(lg n). REQUIRES: order 2, and a and b are the ends of an edge.
  std::uint32_t MidpointOf(std::uint32_t a, std::uint32_t b) const;
  std::size_t subsegment_count() const;
  std::size_t subfacet_count() const;
};

// The simplices of a mesh of dimension D.
template <int D, class M>
auto& SimplicesOf(M& mesh) {
  if constexpr (D == 2) {
    return mesh.triangles;
  } else {
    return mesh.tetrahedra;
  }
}

// Calls f(corners) for each simplex, corners an array of three or four.
template <class F>
void ForEachSimplex(const IndexedMesh& mesh, F f) {
  for (const auto& t : mesh.triangles) f(t);
  for (const auto& t : mesh.tetrahedra) f(t);
}

// INVALID_ARGUMENT if a simplex, subsegment or subfacet names an unknown vertex, an id occurs twice
// or columns disagree. O(n lg n).
absl::StatusOr<IndexedMesh> IndexMesh(const Mesh& mesh);

// Makes the mesh one of order 2: adds a vertex in the middle of each edge (straight elements), with
// the owner of the edge, in 3D else of the face that it is in, and labels likewise. REQUIRES: order
// 1. O(n lg n).
void AddMidpoints(IndexedMesh& mesh);

// Back to ids, with revision 0 and the hash of the parts. Rows keep their order. Accepts any
// content, valid mesh or not. Of several vertices with equal coordinates all but the first get
// other salts. REQUIRES: numbers are in range.
Mesh ToMesh(const IndexedMesh& indexed);

// The indices in `mesh` of those `simplices` that are in it.
std::vector<std::uint32_t> FindSimplices(const IndexedMesh& mesh, const SimplexColumn& simplices);

// The quality of triangle or tetrahedron i. REQUIRES: its numbers are in range.
TriangleQuality MeasureTriangle(const IndexedMesh& mesh, std::size_t i);
TetrahedronQuality MeasureTetrahedron(const IndexedMesh& mesh, std::size_t i);
// The measures of both kinds. Angles of tetrahedra are dihedral.
struct SimplexMeasures {
  double radius_edge = 0;
  double shortest_edge = 0;
  double min_angle_deg = 0;
};
SimplexMeasures MeasureSimplex(const IndexedMesh& mesh, std::size_t i);
// dynmesh::JudgeSimplices for each simplex, in the order of rows. `min_dihedral` in degrees is for
// 3D; 0: no bound. O(size).
std::vector<SimplexVerdict> JudgeSimplices(const IndexedMesh& mesh, double rho,
                                           double min_dihedral = 0);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_INDEXED_MESH_H_
