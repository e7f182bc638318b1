// What a region with a target length is beyond a box and a radius: does a ball meet it? Immutable,
// thread-safe.
#ifndef DYNMESH_CORE_MESHING_SIZING_SHAPE_H_
#define DYNMESH_CORE_MESHING_SIZING_SHAPE_H_

#include "core/geometry/point.h"

namespace dynmesh::meshing {

template <int D>
class SizingShape {
 public:
  SizingShape() = default;
  SizingShape(const SizingShape&) = delete;
  SizingShape& operator=(const SizingShape&) = delete;
  virtual ~SizingShape() = default;

  // A function of coordinates to the bit. Monotone: true for a greater radius, too.
  virtual bool Meets(const geometry::Point<D>& centre, double radius) const = 0;
  // True if all of the ball is certainly within `reach` of the shape. Conservative: may return
  // false needlessly, never true wrongly.
  virtual bool Holds(const geometry::Point<D>& centre, double radius, double reach) const = 0;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SIZING_SHAPE_H_
