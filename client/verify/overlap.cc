// Do simplices overlap? For meshes that do not fill a box: of these, sides and orientation alone do
// not say that every place is covered at most once.
//
// Let every side have one or two simplices, on either side of it, and all simplices be positive.
// The number of simplices around a place is then constant but for steps of 1 across the border. So
// no place is covered twice if no vertex lies in a simplex that does not have it, and no two sides
// of the border cross. Exact: CGAL's kernel decides.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>

#include "client/verify/containment.h"
#include "client/verify/simplex_boxes.h"
#include "client/verify/verify_internal.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using text::Concat;

Kernel::Point_2 P2(const io::IndexedMesh& mesh, std::uint32_t v) {
  return {mesh.vertices[v].x, mesh.vertices[v].y};
}
Kernel::Point_3 P3(const io::IndexedMesh& mesh, std::uint32_t v) {
  return {mesh.vertices[v].x, mesh.vertices[v].y, mesh.vertices[v].z};
}

int Sign(const io::IndexedMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return CGAL::orientation(P2(mesh, a), P2(mesh, b), P2(mesh, c));
}
int Sign(const io::IndexedMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c,
         std::uint32_t d) {
  return CGAL::orientation(P3(mesh, a), P3(mesh, b), P3(mesh, c), P3(mesh, d));
}

// Do the insides of edges p-q and a-b cross in one point?
bool DoCross(const io::IndexedMesh& mesh, const std::array<std::uint32_t, 2>& s,
             const std::array<std::uint32_t, 2>& t) {
  return Sign(mesh, s[0], s[1], t[0]) * Sign(mesh, s[0], s[1], t[1]) < 0 &&
         Sign(mesh, t[0], t[1], s[0]) * Sign(mesh, t[0], t[1], s[1]) < 0;
}
// Does an edge of face s pierce the inside of face t?
bool DoCross(const io::IndexedMesh& mesh, const std::array<std::uint32_t, 3>& s,
             const std::array<std::uint32_t, 3>& t) {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t p = s[k], q = s[(k + 1) % 3];
    if (std::ranges::count(t, p) + std::ranges::count(t, q) != 0) continue;
    if (Sign(mesh, t[0], t[1], t[2], p) * Sign(mesh, t[0], t[1], t[2], q) >= 0) continue;
    const int side = Sign(mesh, p, q, t[0], t[1]);
    if (side != 0 && Sign(mesh, p, q, t[1], t[2]) == side && Sign(mesh, p, q, t[2], t[0]) == side) {
      return true;
    }
  }
  return false;
}

template <std::size_t N>
VerifyCheck Check(const io::IndexedMesh& mesh,
                  const std::vector<std::array<std::uint32_t, N>>& simplices,
                  const std::vector<std::array<std::uint32_t, N - 1>>& border) {
  Findings findings("overlap");
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const auto& s : simplices) {
    for (const std::uint32_t v : s) used[v] = true;
  }
  std::vector<std::uint32_t> corners;
  std::vector<Box3> places;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!used[v]) continue;
    corners.push_back(v);
    places.push_back({mesh.vertices[v].position(), mesh.vertices[v].position()});
  }
  const boxes::BoxTree<3> vertices(std::move(places));
  for (std::uint32_t i = 0; i < simplices.size(); ++i) {
    vertices.ForEachMeeting(BoxOf(mesh, simplices[i]), [&](std::uint32_t corner) {
      const std::uint32_t v = corners[corner];
      if (std::ranges::count(simplices[i], v) != 0 ||
          !Contains(mesh, simplices[i], mesh.vertices[v].position())) {
        return;
      }
      findings.Add(
          Concat(VertexName(v), " lies in ", N == 3 ? TriangleName(i) : TetrahedronName(i)));
    });
  }
  std::vector<Box3> boxes;
  for (const auto& side : border) boxes.push_back(BoxOf(mesh, side));
  const boxes::BoxTree<3> sides(std::move(boxes));
  std::vector<std::uint32_t> near;
  for (std::uint32_t i = 0; i < border.size(); ++i) {
    near.clear();
    sides.ForEachMeeting(sides.box(i), [&](std::uint32_t j) {
      if (N == 3 ? j < i : j != i) near.push_back(j);
    });
    std::ranges::sort(near);
    for (const std::uint32_t j : near) {
      if (!DoCross(mesh, border[i], border[j])) continue;
      findings.Add(Concat("sides of the border cross at ", VertexName(border[i][0]), " and ",
                          VertexName(border[j][0])));
    }
  }
  return findings.Take();
}

}  // namespace

VerifyCheck CheckOverlap(const io::IndexedMesh& mesh, const std::vector<Side>& sides) {
  std::vector<std::array<std::uint32_t, 2>> border;
  ForEachEdge(sides, [&](const Side* side, std::size_t count) {
    if (count == 1) border.push_back({side->a, side->b});
  });
  return Check<3>(mesh, mesh.triangles, border);
}

VerifyCheck CheckOverlap(const io::IndexedMesh& mesh, const std::vector<Face>& faces) {
  std::vector<std::array<std::uint32_t, 3>> border;
  ForEachTriangle(faces, [&](const Face* face, std::size_t count) {
    if (count == 1) border.push_back(face->v);
  });
  return Check<4>(mesh, mesh.tetrahedra, border);
}

}  // namespace dynmesh::cli
