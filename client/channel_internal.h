// What the parts of the client library share: stub, names, statuses. Includes gRPC;
// no public header may.
#ifndef DYNMESH_CLIENT_CHANNEL_INTERNAL_H_
#define DYNMESH_CLIENT_CHANNEL_INTERNAL_H_

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "client/edit_session.h"
#include "client/watch_session.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"

namespace dynmesh::client {

using Stub = v1::MeshService::Stub;

// "plate" or "meshes/plate" as "meshes/plate". Checked by the server.
inline std::string FullName(const std::string& mesh) {
  return mesh.rfind("meshes/", 0) == 0 ? mesh : "meshes/" + mesh;
}

// Meshes are planar as yet: features have no z on the wire.
inline constexpr int kDimension = 2;

// Edits of one message: below 1 MB, whatever they are.
inline constexpr std::size_t kEditsPerMessage = 16'384;

std::unique_ptr<EditSession> StartEditSession(std::shared_ptr<Stub> stub, const std::string& mesh,
                                              bool stop_on_error, absl::Duration timeout);

std::unique_ptr<WatchSession> StartWatchSession(std::shared_ptr<Stub> stub, const std::string& mesh,
                                                const WatchOptions& options,
                                                WatchListener* listener);

// Puts the fragments of a diff together; done when one without `more` was taken.
struct ResultAssembler {
  codec::DiffAssembler assembler;
  // Nothing while fragments are missing.
  absl::StatusOr<std::optional<EditResult>> Add(const v1::MeshDiff& fragment) {
    auto diff = assembler.Add(fragment);
    if (!diff.ok()) return diff.status();
    if (!diff->has_value()) return std::optional<EditResult>();
    return std::optional<EditResult>(
        EditResult{**std::move(diff), fragment.replayed(), fragment.columns_omitted()});
  }
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_CHANNEL_INTERNAL_H_
