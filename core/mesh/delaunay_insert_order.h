// An order in which many points are quickly inserted into a Delaunay triangulation.
// Pure, thread-safe. O(n log n).
#ifndef DYNMESH_CORE_MESH_DELAUNAY_INSERT_ORDER_H_
#define DYNMESH_CORE_MESH_DELAUNAY_INSERT_ORDER_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/steps.h"
#include "core/geometry/point.h"

namespace dynmesh::mesh {

// A permutation of 0 .. points.size()-1: a biased randomized insertion order. Points are
// sorted along a Hilbert curve; where many share one of the curve's cells, along a finer curve
// of their own. They fall into rounds by a hash of their rank there, each round some times larger
// than all before it together, and within a round go along the curve, so that each is near the one
// before. Each stretch of the curve has its share of every round, points on a circle included, so
// the work is expected O(n log n). No choice of coordinates empties a round.
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point2> points);
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point3> points);
// The same; empty if `steps` are stopped.
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point2> points, Steps& steps);
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point3> points, Steps& steps);

}  // namespace dynmesh::mesh

#endif  // DYNMESH_CORE_MESH_DELAUNAY_INSERT_ORDER_H_
