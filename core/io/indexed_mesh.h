// A mesh as files hold it: vertices by number, every edge listed. The order of rows
// is canonical, so that the same mesh is the same file, byte by byte:
//   vertices:  input points by feature id (a `.node` file's points 1..n keep their
//              numbers), then the domain box's, those on segments, free ones; each
//              of these by coordinates, lexicographically
//   triangles: counter-clockwise from the least number; lexicographically; with the
//              number of the region that each lies in
//   edges:     lesser number first; lexicographically
// Plain data; dimension 2 only.
#ifndef DYNMESH_CORE_IO_INDEXED_MESH_H_
#define DYNMESH_CORE_IO_INDEXED_MESH_H_

#include <array>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/region_numbers.h"
#include "dynmesh/mesh.h"
#include "dynmesh/quality.h"

namespace dynmesh::io {

struct IndexedMesh {
  struct Vertex {
    double x = 0;
    double y = 0;
    int containing_dimension = 0;
    FeatureId owner = kNoFeature;
    friend bool operator==(const Vertex&, const Vertex&) = default;
  };
  using Triangle = std::array<std::uint32_t, 3>;
  struct Edge {
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    FeatureId owner = kNoFeature;  // of the subsegment that it is, if it is one
    friend bool operator==(const Edge&, const Edge&) = default;
  };

  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;
  RegionNumbers regions;    // of the triangles
  std::vector<Edge> edges;  // all of them
};

// INVALID_ARGUMENT if a simplex or subsegment names an unknown vertex, an id stands
// twice or columns disagree; UNIMPLEMENTED for dimension 3. O(n lg n).
absl::StatusOr<IndexedMesh> IndexMesh(const Mesh& mesh);

// Back to ids, with revision 0 and the hash of the parts. Rows keep their order.
// Takes any content, valid mesh or not; of several vertices in one place all but the
// first get other salts. Numbers must be in range.
Mesh ToMesh(const IndexedMesh& indexed);

// How good triangle i is. A number out of range is not allowed.
TriangleQuality MeasureTriangle(const IndexedMesh& mesh, std::size_t i);
// What JudgeSimplices says of each triangle, in the order of rows. O(size).
std::vector<SimplexVerdict> JudgeTriangles(const IndexedMesh& mesh, double rho);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_INDEXED_MESH_H_
