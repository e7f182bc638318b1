// One GetSnapshot: the mesh at its present revision, chunk by chunk as the client takes them.
#ifndef DYNMESH_SERVER_CALLS_SNAPSHOT_CALL_H_
#define DYNMESH_SERVER_CALLS_SNAPSHOT_CALL_H_

#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"

namespace dynmesh::server {

// Starts a call that frees itself; one that was not admitted ends with why. `request` is not used
// after the return, `rpc` until the call is done.
grpc::ServerWriteReactor<v1::SnapshotChunk>* StartSnapshotCall(
    ServiceContext& context, const v1::GetSnapshotRequest& request,
    const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_SNAPSHOT_CALL_H_
