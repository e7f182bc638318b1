// What was mended of the rings of a map while it was read.
#ifndef DYNMESH_CORE_IO_MAPS_MENDED_RINGS_H_
#define DYNMESH_CORE_IO_MAPS_MENDED_RINGS_H_

#include <cstdint>

namespace dynmesh::io {

// Rings of polygons that RFC 7946 does not allow, and what became of them.
struct MendedRings {
  std::uint64_t closed = 0;   // the last position was not the first
  std::uint64_t dropped = 0;  // of no position, or of two places: they have no area
  std::uint64_t points = 0;   // of one place, which is a point now
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MAPS_MENDED_RINGS_H_
