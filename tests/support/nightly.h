// Long settings of tests, for runs at night: DYNMESH_NIGHTLY=1.
#ifndef DYNMESH_TESTS_SUPPORT_NIGHTLY_H_
#define DYNMESH_TESTS_SUPPORT_NIGHTLY_H_

#include <cstdlib>

namespace dynmesh::test {

// DYNMESH_NIGHTLY is set, and neither empty nor 0.
inline bool IsNightly() {
  const char* const set = std::getenv("DYNMESH_NIGHTLY");
  return set != nullptr && *set != '\0' && *set != '0';
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_NIGHTLY_H_
