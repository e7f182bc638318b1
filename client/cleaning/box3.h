// Boxes in 3D. Pure.
#ifndef DYNMESH_CLIENT_CLEANING_BOX3_H_
#define DYNMESH_CLIENT_CLEANING_BOX3_H_

#include <algorithm>
#include <cstddef>
#include <span>

#include "client/cleaning/node_table.h"

namespace dynmesh::cleaning {

struct Box3 {
  Point3 lo, hi;

  // REQUIRES: there is a point.
  static Box3 Of(std::span<const Point3> points) {
    Box3 box = {points[0], points[0]};
    for (const Point3& p : points) box.Add({p, p});
    return box;
  }
  void Add(const Box3& other) {
    for (std::size_t i = 0; i < 3; ++i) {
      lo[i] = std::min(lo[i], other.lo[i]);
      hi[i] = std::max(hi[i], other.hi[i]);
    }
  }
  // With `reach` more on each side.
  Box3 Grown(double reach) const {
    return {{lo[0] - reach, lo[1] - reach, lo[2] - reach},
            {hi[0] + reach, hi[1] + reach, hi[2] + reach}};
  }
  // Are they within `reach` along each axis?
  bool Meets(const Box3& other, double reach = 0) const {
    for (std::size_t i = 0; i < 3; ++i) {
      if (lo[i] - reach > other.hi[i] || other.lo[i] - reach > hi[i]) return false;
    }
    return true;
  }
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_BOX3_H_
