// Protobuf reports on stderr every message that does not parse. Including this file silences it.
#ifndef DYNMESH_TESTS_FUZZ_QUIET_H_
#define DYNMESH_TESTS_FUZZ_QUIET_H_

#include <google/protobuf/stubs/logging.h>

namespace dynmesh::fuzz {

inline void BeQuiet() {
  static const auto before = google::protobuf::SetLogHandler(nullptr);
  (void)before;
}

}  // namespace dynmesh::fuzz

#endif  // DYNMESH_TESTS_FUZZ_QUIET_H_
