// An order in which many points are quickly inserted into a Delaunay triangulation.
// Pure, thread-safe. O(n log n).
#ifndef DYNMESH_CORE_MESH_DELAUNAY_INSERT_ORDER_H_
#define DYNMESH_CORE_MESH_DELAUNAY_INSERT_ORDER_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::mesh {

// A permutation of 0 .. points.size()-1: a biased randomized insertion order. Points
// fall into rounds by geometry::HashOf, each some times larger than all before it
// together; so the work is expected O(n log n) on any input, points on a circle
// included. Within a round they go along a Hilbert curve, so that each is near the one
// before; where many share one of the curve's cells, along a finer curve of their own.
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point2> points);
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point3> points);

}  // namespace dynmesh::mesh

#endif  // DYNMESH_CORE_MESH_DELAUNAY_INSERT_ORDER_H_
