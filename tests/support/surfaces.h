// Polygons of simple surfaces in 3D.
#ifndef DYNMESH_TESTS_SUPPORT_SURFACES_H_
#define DYNMESH_TESTS_SUPPORT_SURFACES_H_

#include <array>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::test {

// The eight corners of a box, then its six faces; ids from `first` on.
inline std::vector<Feature> BoxSurface(FeatureId first, const std::array<double, 3>& lo,
                                       const std::array<double, 3>& hi) {
  std::vector<Feature> surface;
  for (FeatureId i = 0; i < 8; ++i) {
    surface.push_back(Feature::Point(first + i, i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1],
                                     i & 4 ? hi[2] : lo[2]));
  }
  constexpr FeatureId kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                      {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
  for (FeatureId face = 0; face < 6; ++face) {
    const auto& c = kFaces[face];
    surface.push_back(Feature::Polygon(first + 8 + face,
                                       {{first + c[0], first + c[1], first + c[2], first + c[3]}}));
  }
  return surface;
}

// The triangles over n by n squares of a grid, row by row, two a square; ids from `first` on.
// `corner(x, y)`: the id of a corner, x and y from 0 to n.
template <class Corner>
std::vector<Feature> GridTriangles(int n, FeatureId first, Corner corner) {
  std::vector<Feature> triangles;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const FeatureId a = corner(x, y), c = corner(x + 1, y + 1);
      triangles.push_back(Feature::Polygon(first++, {{a, corner(x + 1, y), c}}));
      triangles.push_back(Feature::Polygon(first++, {{a, c, corner(x, y + 1)}}));
    }
  }
  return triangles;
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_SURFACES_H_
