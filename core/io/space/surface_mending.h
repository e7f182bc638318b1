// Mends what programs that write surfaces do, and what has one remedy: points that are there for
// each face of theirs, faces twice, faces without area.
//
//   * Points at one place are one, with the least of their ids. So are points nearer to each other
//     than a distance, at the place that most faces have, of several the least.
//   * A face without area goes: corners at one place, or all on one line (coplanar/needles.h).
//     Where it was beside a longer edge, the faces there get its corners on that edge.
//   * Of faces with the same edges the one with the least id stays.
//   * Segments lose what points and faces lose.
//
// What is left is a function of coordinates, not of the order of points, faces and corners; ids
// depend on ids. A face that visits a place several times becomes faces that touch there: further
// ones get new ids, with the line of theirs.
//
// Thread-safe. Expected O(n lg n).
#ifndef DYNMESH_CORE_IO_SPACE_SURFACE_MENDING_H_
#define DYNMESH_CORE_IO_SPACE_SURFACE_MENDING_H_

#include <cstddef>

#include "core/io/common/file_features.h"

namespace dynmesh::io {

struct SurfaceMends {
  std::size_t equal_points = 0;  // made one with another
  std::size_t near_points = 0;   // the same, nearer than the distance
  std::size_t faces_twice = 0;   // left out
  std::size_t faces_without_area = 0;
};

// Polygons have one ring each. A distance of 0 makes equal points one only.
SurfaceMends MendSurface(double distance, FileFeatures& file);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SPACE_SURFACE_MENDING_H_
