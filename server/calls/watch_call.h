// One Watch: a stream that is driven by whoever has the next thing to do - the hub
// that wakes it, the pool that prepares a snapshot, gRPC when a message is out. No
// thread belongs to it.
#ifndef DYNMESH_SERVER_CALLS_WATCH_CALL_H_
#define DYNMESH_SERVER_CALLS_WATCH_CALL_H_

#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"

namespace dynmesh::server {

// Starts a call that frees itself; one that was not admitted ends with why. `request` is not used
// after the return. `rpc` is cancelled when the pass no longer allows to read.
grpc::ServerWriteReactor<v1::WatchEvent>* StartWatchCall(ServiceContext& context,
                                                         const v1::WatchRequest& request,
                                                         const absl::StatusOr<Pass>& pass,
                                                         grpc::CallbackServerContext* rpc);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_WATCH_CALL_H_
