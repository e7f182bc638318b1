// The checks that need exact predicates: CGAL's kernel decides.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <utility>

#include "client/verify/verify_internal.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;

Point At(const io::IndexedMesh& mesh, std::uint32_t v) {
  return Point(mesh.vertices[v].x, mesh.vertices[v].y);
}

bool IsCounterClockwise(const io::IndexedMesh& mesh, const io::IndexedMesh::Triangle& t) {
  return CGAL::orientation(At(mesh, t[0]), At(mesh, t[1]), At(mesh, t[2])) == CGAL::LEFT_TURN;
}

Kernel::Point_3 InSpace(const io::IndexedMesh& mesh, std::uint32_t v) {
  const io::IndexedMesh::Vertex& vertex = mesh.vertices[v];
  return Kernel::Point_3(vertex.x, vertex.y, vertex.z);
}

bool IsPositive(const io::IndexedMesh& mesh, const io::IndexedMesh::Tetrahedron& t) {
  return CGAL::orientation(InSpace(mesh, t[0]), InSpace(mesh, t[1]), InSpace(mesh, t[2]),
                           InSpace(mesh, t[3])) == CGAL::POSITIVE;
}

}  // namespace

VerifyCheck CheckOrientation(const io::IndexedMesh& mesh) {
  Findings findings("orientation");
  for (std::uint32_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    if (!IsPositive(mesh, mesh.tetrahedra[t])) {
      findings.Add(TetrahedronName(t) + " is flat or turned inside out");
    }
  }
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!IsCounterClockwise(mesh, mesh.triangles[t])) {
      findings.Add(TriangleName(t) + " is flat or clockwise");
    }
  }
  return findings.Take();
}

VerifyCheck CheckDelaunay(const io::IndexedMesh& mesh, const std::vector<Side>& sides,
                          bool is_constrained) {
  Findings findings("delaunay");
  std::set<std::pair<std::uint32_t, std::uint32_t>> walls;
  if (is_constrained) {
    for (const io::IndexedMesh::Edge& edge : mesh.edges) {
      if (edge.owner != kNoFeature) walls.insert(std::minmax(edge.a, edge.b));
    }
  }
  ForEachEdge(sides, [&](const Side* side, std::size_t count) {
    if (count != 2 || walls.contains({side->a, side->b})) return;
    const auto& t = mesh.triangles[side[0].triangle];
    const std::uint32_t across = mesh.triangles[side[1].triangle][(side[1].k + 2U) % 3];
    if (!IsCounterClockwise(mesh, t)) return;  // without a circle; reported elsewhere
    if (CGAL::side_of_oriented_circle(At(mesh, t[0]), At(mesh, t[1]), At(mesh, t[2]),
                                      At(mesh, across)) == CGAL::ON_POSITIVE_SIDE) {
      findings.Add(text::Concat(VertexName(across), " is inside the circle of ",
                                TriangleName(side[0].triangle), " beyond ",
                                EdgeName(side->a, side->b)));
    }
  });
  return findings.Take();
}

VerifyCheck CheckDelaunay(const io::IndexedMesh& mesh, const std::vector<Face>& faces) {
  Findings findings("delaunay");
  ForEachTriangle(faces, [&](const Face* face, std::size_t count) {
    if (count != 2) return;
    const auto& t = mesh.tetrahedra[face[0].tetrahedron];
    const std::uint32_t across = mesh.tetrahedra[face[1].tetrahedron][face[1].k];
    if (!IsPositive(mesh, t)) return;  // without a sphere; reported elsewhere
    if (CGAL::side_of_oriented_sphere(InSpace(mesh, t[0]), InSpace(mesh, t[1]), InSpace(mesh, t[2]),
                                      InSpace(mesh, t[3]),
                                      InSpace(mesh, across)) == CGAL::ON_POSITIVE_SIDE) {
      findings.Add(text::Concat(VertexName(across), " is inside the sphere of ",
                                TetrahedronName(face[0].tetrahedron), " beyond ",
                                FaceName(face->v)));
    }
  });
  return findings.Take();
}

}  // namespace dynmesh::cli
