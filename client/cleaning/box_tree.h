// A tree of boxes in 3D.
#ifndef DYNMESH_CLIENT_CLEANING_BOX_TREE_H_
#define DYNMESH_CLIENT_CLEANING_BOX_TREE_H_

#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <cstdint>
#include <utility>

#include "client/cleaning/box3.h"

namespace dynmesh::cleaning {

using TreeCorner = boost::geometry::model::point<double, 3, boost::geometry::cs::cartesian>;
using TreeBox = boost::geometry::model::box<TreeCorner>;
using BoxEntry = std::pair<TreeBox, std::uint32_t>;  // with the number of what is in the box
using BoxTree = boost::geometry::index::rtree<BoxEntry, boost::geometry::index::quadratic<16>>;

inline TreeBox TreeBoxOf(const Box3& box) {
  return {TreeCorner(box.lo[0], box.lo[1], box.lo[2]), TreeCorner(box.hi[0], box.hi[1], box.hi[2])};
}

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_BOX_TREE_H_
