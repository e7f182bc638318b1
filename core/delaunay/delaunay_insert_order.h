// A fast order for inserting many points into a Delaunay triangulation. Pure, thread-safe.
// O(n log n).
#ifndef DYNMESH_CORE_DELAUNAY_DELAUNAY_INSERT_ORDER_H_
#define DYNMESH_CORE_DELAUNAY_DELAUNAY_INSERT_ORDER_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/steps.h"
#include "core/geometry/point.h"

namespace dynmesh::delaunay {

// A permutation of 0 .. points.size()-1: a biased randomized insertion order.
// 1. Points are sorted along a Hilbert curve. Where many share one of the curve's cells, they are
//    sorted along a finer curve of their own.
// 2. A hash of their rank in this order puts them into rounds. Each round is some times larger than
//    all before it together.
// 3. Within a round they keep the order of the curve, so that each is near the one before.
// 4. Each stretch of the curve has its share of every round, for points on a circle, too. So the
//    work is expected O(n log n). No choice of coordinates empties a round.
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point2> points);
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point3> points);
// The same; empty if `steps` stop it.
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point2> points, Steps& steps);
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point3> points, Steps& steps);

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_CORE_DELAUNAY_DELAUNAY_INSERT_ORDER_H_
