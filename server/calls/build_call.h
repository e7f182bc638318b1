// A BuildMesh call: features in, in parts; progress out, then the mesh in chunks at the client's
// pace. Nothing of it outlives the call.
#ifndef DYNMESH_SERVER_CALLS_BUILD_CALL_H_
#define DYNMESH_SERVER_CALLS_BUILD_CALL_H_

#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"
#include "server/calls/open_streams.h"
#include "server/calls/received.h"

namespace dynmesh::server {

// As StartEditStreamCall.
grpc::ServerBidiReactor<Received<v1::BuildMeshRequest>, v1::BuildMeshResponse>* StartBuildCall(
    ServiceContext& context, OpenStreams& streams, const absl::StatusOr<Pass>& pass,
    grpc::CallbackServerContext* rpc);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_BUILD_CALL_H_
