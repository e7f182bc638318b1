// Makes the mesh of `dynmesh mesh` on a server. Implemented in remote/.
#ifndef DYNMESH_CLIENT_CLI_REMOTE_MESHER_H_
#define DYNMESH_CLIENT_CLI_REMOTE_MESHER_H_

#include <memory>
#include <span>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::cli {

class RemoteMesher {
 public:
  virtual ~RemoteMesher() = default;
  // --server and what belongs to a connection.
  virtual void AddFlags(CLI::App& command) = 0;
  // True if --server is given.
  virtual bool is_chosen() const = 0;
  // As BuildMesh, of `build` by its engine and only_inside. Errors of the server have an
  // ErrorDetail, too.
  virtual absl::StatusOr<Mesh> Build(std::span<const Feature> features, const MeshOptions& options,
                                     const BuildOptions& build) = 0;
};

std::shared_ptr<RemoteMesher> MakeRemoteMesher();

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_REMOTE_MESHER_H_
