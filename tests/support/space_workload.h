// Random 3D inputs (workload.h).
#ifndef DYNMESH_TESTS_SUPPORT_SPACE_WORKLOAD_H_
#define DYNMESH_TESTS_SUPPORT_SPACE_WORKLOAD_H_

#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::test {

// MakeFeatures for a 3D distribution.
std::vector<Feature> MakeSpaceFeatures(Distribution d, int n, std::uint64_t seed);

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_SPACE_WORKLOAD_H_
