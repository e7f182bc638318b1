// The meshes of an SQLite journal by its rows, to be compared with the record. Reads only;
// O(meshes) searches.
#ifndef DYNMESH_SERVER_JOURNAL_FOUND_MESHES_H_
#define DYNMESH_SERVER_JOURNAL_FOUND_MESHES_H_

#include <vector>

#include "absl/status/statusor.h"
#include "server/journal/heads_file.h"
#include "server/journal/losses.h"
#include "server/journal/sqlite.h"

namespace dynmesh::server {

// For a journal of the present schema. `recorded` is the record. Errors are SQLite's.
absl::StatusOr<std::vector<FoundMesh>> FindMeshes(sqlite::Connection& connection,
                                                  const std::vector<HeadsFile::Head>& recorded);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_FOUND_MESHES_H_
