// The version of the library, for the preprocessor and at run time. The only place of it: CMake
// reads the three numbers.
//
//   if (dynmesh::LinkedVersionNumber() != dynmesh::kVersionNumber) Warn();
#ifndef DYNMESH_VERSION_H_
#define DYNMESH_VERSION_H_

// Below 1.0 a new minor version may change the API; a new patch never does.
#define DYNMESH_VERSION_MAJOR 0
// The second number.
#define DYNMESH_VERSION_MINOR 2
// The third number.
#define DYNMESH_VERSION_PATCH 0

// The version `major`.`minor`.`patch` as one number, to compare with DYNMESH_VERSION. Each part is
// below 1000.
//
//   #if DYNMESH_VERSION >= DYNMESH_MAKE_VERSION(0, 2, 0)
#define DYNMESH_MAKE_VERSION(major, minor, patch) ((major)*1000000 + (minor)*1000 + (patch))
// The version of these headers as one number, such as 1002 for 0.1.2.
#define DYNMESH_VERSION \
  DYNMESH_MAKE_VERSION(DYNMESH_VERSION_MAJOR, DYNMESH_VERSION_MINOR, DYNMESH_VERSION_PATCH)

// "MAJOR.MINOR.PATCH".
#define DYNMESH_VERSION_STRING \
  DYNMESH_INTERNAL_JOIN(DYNMESH_VERSION_MAJOR, DYNMESH_VERSION_MINOR, DYNMESH_VERSION_PATCH)
#define DYNMESH_INTERNAL_JOIN(a, b, c) DYNMESH_INTERNAL_TEXT(a, b, c)
#define DYNMESH_INTERNAL_TEXT(a, b, c) #a "." #b "." #c

namespace dynmesh {

inline constexpr int kVersionMajor = DYNMESH_VERSION_MAJOR;  // of these headers
inline constexpr int kVersionMinor = DYNMESH_VERSION_MINOR;  // of these headers
inline constexpr int kVersionPatch = DYNMESH_VERSION_PATCH;  // of these headers
inline constexpr int kVersionNumber = DYNMESH_VERSION;       // the three as one number
inline constexpr char kVersion[] = DYNMESH_VERSION_STRING;   // "MAJOR.MINOR.PATCH"

// "MAJOR.MINOR.PATCH" of the linked library. It differs from kVersion if the program was compiled
// with headers of another version.
const char* LinkedVersion();
// The same as one number, as DYNMESH_VERSION.
int LinkedVersionNumber();

}  // namespace dynmesh

#endif  // DYNMESH_VERSION_H_
