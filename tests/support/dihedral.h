// Dihedral angles by a formula of their own, for tests.
#ifndef DYNMESH_TESTS_SUPPORT_DIHEDRAL_H_
#define DYNMESH_TESTS_SUPPORT_DIHEDRAL_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <vector>

#include "core/geometry/circumball.h"
#include "core/geometry/point.h"
#include "dynmesh/mesh.h"

namespace dynmesh::test {

// The least dihedral angle in degrees, by atan2.
inline double LeastDihedral(const std::array<geometry::Point3, 4>& p) {
  double least = 180;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < i; ++j) {
      std::array<int, 2> rest;
      int count = 0;
      for (int k = 0; k < 4; ++k) {
        if (k != i && k != j) rest[static_cast<std::size_t>(count++)] = k;
      }
      const auto edge = geometry::Difference(p[j].c, p[i].c);
      const auto u = geometry::Cross(edge, geometry::Difference(p[rest[0]].c, p[i].c));
      const auto w = geometry::Cross(edge, geometry::Difference(p[rest[1]].c, p[i].c));
      const auto across = geometry::Cross(u, w);
      least = std::min(
          least, std::atan2(std::sqrt(geometry::Dot(across, across)), geometry::Dot(u, w)) * 180 /
                     std::numbers::pi);
    }
  }
  return least;
}

// Of each tetrahedron of a mesh.
inline std::vector<double> LeastDihedrals(const Mesh& mesh) {
  std::unordered_map<VertexId, std::size_t> rows;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) rows[mesh.vertices.ids[i]] = i;
  std::vector<double> angles;
  for (std::size_t t = 0; t < mesh.simplex_count(); ++t) {
    std::array<geometry::Point3, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t row = rows.at(mesh.simplices[4 * t + k]);
      for (std::size_t a = 0; a < 3; ++a) {
        corners[k].c[a] = mesh.vertices.coordinates[3 * row + a];
      }
    }
    angles.push_back(LeastDihedral(corners));
  }
  return angles;
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_DIHEDRAL_H_
