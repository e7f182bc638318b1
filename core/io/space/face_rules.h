// Which faces of a surface file are errors.
#ifndef DYNMESH_CORE_IO_SPACE_FACE_RULES_H_
#define DYNMESH_CORE_IO_SPACE_FACE_RULES_H_

#include <cstdint>

namespace dynmesh::io {

enum class FaceRules : std::uint8_t {
  kStrict,  // those that no mesh accepts: a repeated corner, too few corners, twice the same
  // Those of which no face can be made: too few corners, one twice in a polygon of four and more.
  // The others are to be mended (surface_mending.h).
  kMended,
  kAsTheyCome,  // none: faces are to be cleaned. Rings may then have any number of corners
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SPACE_FACE_RULES_H_
