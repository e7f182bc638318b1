// A GetSnapshot call: the mesh at its present revision, in chunks at the client's pace.
#ifndef DYNMESH_SERVER_CALLS_SNAPSHOT_CALL_H_
#define DYNMESH_SERVER_CALLS_SNAPSHOT_CALL_H_

#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"

namespace dynmesh::server {

// Starts a call that frees itself. A call that is not admitted ends with the error. `request` is
// not used after the return; `rpc` is used until the call is done.
grpc::ServerWriteReactor<v1::SnapshotChunk>* StartSnapshotCall(
    ServiceContext& context, const v1::GetSnapshotRequest& request,
    const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_SNAPSHOT_CALL_H_
