// Boxes and balls.
#ifndef DYNMESH_CORE_MESHING_EXTENT_H_
#define DYNMESH_CORE_MESHING_EXTENT_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/geometry/point.h"

namespace dynmesh::meshing {

// An axis-parallel box, closed.
template <int D>
struct Extent {
  std::array<double, D> lo, hi;

  static Extent Nothing() {
    Extent e;
    e.lo.fill(INFINITY);
    e.hi.fill(-INFINITY);
    return e;
  }
  [[gnu::always_inline]] inline void AddBall(const geometry::Point<D>& centre, double radius) {
    for (int i = 0; i < D; ++i) {
      lo[i] = std::min(lo[i], centre[i] - radius);
      hi[i] = std::max(hi[i], centre[i] + radius);
    }
  }
  bool Contains(const geometry::Point<D>& p) const {
    for (int i = 0; i < D; ++i) {
      if (!(lo[i] <= p[i] && p[i] <= hi[i])) return false;
    }
    return true;
  }
  // The box about `centre` with half those sides.
  bool MayMeet(const geometry::Point<D>& centre, const std::array<double, D>& half) const {
    for (int i = 0; i < D; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (!(lo[k] <= centre[i] + half[k] && centre[i] - half[k] <= hi[k])) return false;
    }
    return true;
  }
};

template <int D>
struct Ball {
  Ball() {}  // uninitialised room
  Ball(const geometry::Point<D>& c, double r2) : centre(c), radius2(r2) {}
  geometry::Point<D> centre;
  double radius2;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_EXTENT_H_
