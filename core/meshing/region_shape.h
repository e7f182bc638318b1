// What a region with a target length is beyond a box and a radius: does a ball meet it? Immutable,
// thread-safe.
#ifndef DYNMESH_CORE_MESHING_REGION_SHAPE_H_
#define DYNMESH_CORE_MESHING_REGION_SHAPE_H_

#include "core/geometry/point.h"

namespace dynmesh::meshing {

template <int D>
class RegionShape {
 public:
  RegionShape() = default;
  RegionShape(const RegionShape&) = delete;
  RegionShape& operator=(const RegionShape&) = delete;
  virtual ~RegionShape() = default;

  // A function of coordinates to the bit. Monotone: true for a greater radius, too.
  virtual bool Meets(const geometry::Point<D>& centre, double radius) const = 0;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_REGION_SHAPE_H_
