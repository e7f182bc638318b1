// Many meshes that are edited at the same time, each by a stream of its own.
#ifndef DYNMESH_TESTS_E2E_MANY_MESHES_H_
#define DYNMESH_TESTS_E2E_MANY_MESHES_H_

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"

namespace dynmesh::test {

// Makes `count` meshes of `points` random points each, in 2D or 3D, sends `edits` single edits to
// each, and deletes them. Of several servers ("HOST:PORT" with commas between) each makes as many
// meshes. Returns the edits a second of all together, from the first sent to the last answered.
absl::StatusOr<double> EditManyMeshes(const std::string& servers, int dimension, int count,
                                      std::size_t points, int edits);

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_E2E_MANY_MESHES_H_
