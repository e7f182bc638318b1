// 3D: which corner of a star lies in a direction.
#ifndef DYNMESH_CORE_MESHING_CORNER_TOWARDS_H_
#define DYNMESH_CORE_MESHING_CORNER_TOWARDS_H_

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace dynmesh::meshing {

// The corner of a star with direction x in its cone; -1 if rounding could decide. `directions`:
// of the neighbours, from v. corner(i), for i < count: a triple of indices into `directions`.
//
// The cones are those of the outward normals at the corners of v's Voronoi cell. So the corner
// found is extreme in direction x, and is the first one that a new point there cuts off (as in
// 2D: PlanarStar::SectorOf).
template <class Indices>
int CornerTowards(std::span<const std::array<double, 3>> directions, int count, Indices corner,
                  const std::array<double, 3>& x) {
  // Projects along x onto a plane between two axes. There the cone's shadow is a triangle around 0.
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::fabs(x[k]) > std::fabs(x[axis])) axis = k;
  }
  const int first = (axis + 1) % 3, second = (axis + 2) % 3;
  constexpr std::size_t kMost = 64;
  if (directions.size() > kMost) return -1;
  std::array<std::array<double, 2>, kMost> shadows;
  const double turn = x[axis] < 0 ? -1 : 1;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const auto& d = directions[i];
    shadows[i] = {d[first] * x[axis] - d[axis] * x[first],
                  turn * (d[second] * x[axis] - d[axis] * x[second])};
  }
  const auto side = [&](int a, int b) {
    return shadows[a][0] * shadows[b][1] - shadows[a][1] * shadows[b][0];
  };
  for (int i = 0; i < count; ++i) {
    const auto [a, b, c] = corner(i);
    const double ab = side(a, b);
    if (!(ab > 0)) continue;
    const double bc = side(b, c);
    if (!(bc > 0)) continue;
    const double ca = side(c, a);
    if (!(ca > 0)) continue;
    // Each coordinate of a shadow errs by four roundings of its terms, the cross product of two by
    // ten. Products may underflow.
    const auto size = [&](int j) {
      const auto& d = directions[j];
      return std::fabs(d[0]) + std::fabs(d[1]) + std::fabs(d[2]);
    };
    const double sa = size(a), sb = size(b), sc = size(c), bound = 1e-14 * x[axis] * x[axis];
    const bool sure = ab > bound * sa * sb + 1e-290 && bc > bound * sb * sc + 1e-290 &&
                      ca > bound * sc * sa + 1e-290;
    return sure ? i : -1;
  }
  return -1;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_CORNER_TOWARDS_H_
