// Diffs as sets of rows: their size, their sum, their application to a whole mesh.
// No geometry. Pure functions, thread-safe.
#ifndef DYNMESH_SERVER_REVISIONS_DIFF_ALGEBRA_H_
#define DYNMESH_SERVER_REVISIONS_DIFF_ALGEBRA_H_

#include <cstddef>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "dynmesh/mesh.h"

namespace dynmesh::server {

// Memory of the columns.
std::size_t ByteSize(const MeshDiff& diff);
std::size_t ByteSize(const Mesh& mesh);

// One diff that does what `diffs`, at least one and each continuing the one before,
// do in turn. Simplices (in the same region), subsegments and subfacets that come and go again
// cancel; a vertex that goes and comes again stands in both lists, as a diff may say. Work is added
// up. Expected time linear in the rows of all.
MeshDiff Compose(const std::vector<std::shared_ptr<const MeshDiff>>& diffs);

// `mesh` at diff.to_revision, in time linear in both. FAILED_PRECONDITION on a gap,
// DATA_LOSS if a row to remove is missing. The hash is taken from the diff.
absl::StatusOr<Mesh> Patched(const Mesh& mesh, const MeshDiff& diff);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_REVISIONS_DIFF_ALGEBRA_H_
