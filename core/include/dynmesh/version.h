// The version of the library, for the preprocessor and for the program. It stands here and nowhere
// else: CMake reads the three numbers.
#ifndef DYNMESH_VERSION_H_
#define DYNMESH_VERSION_H_

#define DYNMESH_VERSION_MAJOR 0
#define DYNMESH_VERSION_MINOR 1
#define DYNMESH_VERSION_PATCH 0

// "MAJOR.MINOR.PATCH".
#define DYNMESH_VERSION_STRING \
  DYNMESH_INTERNAL_JOIN(DYNMESH_VERSION_MAJOR, DYNMESH_VERSION_MINOR, DYNMESH_VERSION_PATCH)
#define DYNMESH_INTERNAL_JOIN(a, b, c) DYNMESH_INTERNAL_TEXT(a, b, c)
#define DYNMESH_INTERNAL_TEXT(a, b, c) #a "." #b "." #c

namespace dynmesh {

inline constexpr int kVersionMajor = DYNMESH_VERSION_MAJOR;
inline constexpr int kVersionMinor = DYNMESH_VERSION_MINOR;
inline constexpr int kVersionPatch = DYNMESH_VERSION_PATCH;
inline constexpr char kVersion[] = DYNMESH_VERSION_STRING;

}  // namespace dynmesh

#endif  // DYNMESH_VERSION_H_
