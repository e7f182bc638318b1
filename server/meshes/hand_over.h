// Hands the meshes of a node that ends to other nodes.
#ifndef DYNMESH_SERVER_MESHES_HAND_OVER_H_
#define DYNMESH_SERVER_MESHES_HAND_OVER_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "server/journal/shared_journal.h"
#include "server/meshes/mesh_host.h"

namespace dynmesh::server {

// A mesh of this node.
struct OwnedHost {
  std::shared_ptr<MeshHost> host;
  Journal::Key key = 0;
};

// Makes other nodes the owners of `meshes`: of each a node that follows it, else any other live
// node. Does nothing without another live node. `address` is this node's. Waits until each mesh is
// handed over or has failed, and for at most `limit`.
//
// The meshes are handed over one after the other. The next one has its turn when the new owner has
// claimed the former, or when `turn` is over. All at once would wait for each other at the new
// owners, and so would their clients. With many meshes turns are shorter: all are over after a
// quarter of `limit`. (A new owner without clients of the mesh claims it when it asks the journal
// next, within 50 ms.)
void HandMeshesOver(SharedJournal* journal, const std::string& address,
                    const std::vector<OwnedHost>& meshes, absl::Duration limit,
                    absl::Duration turn = absl::Milliseconds(100));

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_HAND_OVER_H_
