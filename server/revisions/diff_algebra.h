// Diffs as sets of rows: their size, their composition, their application to a whole mesh. No
// geometry. Pure functions, thread-safe.
#ifndef DYNMESH_SERVER_REVISIONS_DIFF_ALGEBRA_H_
#define DYNMESH_SERVER_REVISIONS_DIFF_ALGEBRA_H_

#include <cstddef>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "dynmesh/mesh.h"

namespace dynmesh::server {

// Memory of the columns, in bytes.
std::size_t ByteSize(const MeshDiff& diff);
std::size_t ByteSize(const Mesh& mesh);

// Composes `diffs`, at least one and each continuing the previous, into one diff. Simplices (in the
// same region), subsegments and subfacets that are added and removed again cancel. A removed and
// re-added vertex is in both lists, as a diff allows. Of each feature the last label counts, even
// if it is that of before. Work is summed. Expected time linear in all rows.
MeshDiff Compose(const std::vector<std::shared_ptr<const MeshDiff>>& diffs);

// `mesh` at diff.to_revision. Time linear in both. FAILED_PRECONDITION if diff.from_revision is not
// the mesh's revision, DATA_LOSS if a row to remove is missing. The hash is taken from the diff.
absl::StatusOr<Mesh> Patched(const Mesh& mesh, const MeshDiff& diff);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_REVISIONS_DIFF_ALGEBRA_H_
