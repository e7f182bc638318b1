// A Watch call. It has no thread of its own. The thread with the next step drives it: the hub that
// wakes it, the pool that prepares a snapshot, or gRPC when a message was sent. Its messages are
// bytes of v1::WatchEvent: watches of the same diff share them (SharedEvents).
#ifndef DYNMESH_SERVER_CALLS_WATCH_CALL_H_
#define DYNMESH_SERVER_CALLS_WATCH_CALL_H_

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"

namespace dynmesh::server {

// Starts a call that frees itself. A call that is not admitted ends with the error. `request` is
// not used after the return. `rpc` is cancelled when the pass loses the right to read.
grpc::ServerWriteReactor<grpc::ByteBuffer>* StartWatchCall(ServiceContext& context,
                                                           const v1::WatchRequest& request,
                                                           const absl::StatusOr<Pass>& pass,
                                                           grpc::CallbackServerContext* rpc);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_WATCH_CALL_H_
