// An EditStream call: batches in, answers out in the same order.
//
// Back-pressure: at most config.edit_window batches are received and not fully answered, and no
// batch is read while more than config.edit_answer_bytes of answers wait to be sent. At those
// limits the call stops reading, and HTTP/2 flow control holds the client.
#ifndef DYNMESH_SERVER_CALLS_EDIT_STREAM_CALL_H_
#define DYNMESH_SERVER_CALLS_EDIT_STREAM_CALL_H_

#include <grpcpp/support/server_callback.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"
#include "server/calls/open_streams.h"
#include "server/calls/received.h"

namespace dynmesh::server {

// Starts a call that frees itself. A call that is not admitted ends with the error. `rpc` is
// cancelled when the pass loses the right to edit the mesh named in the first message.
grpc::ServerBidiReactor<Received<v1::EditBatch>, v1::MeshDiff>* StartEditStreamCall(
    ServiceContext& context, OpenStreams& streams, const absl::StatusOr<Pass>& pass,
    grpc::CallbackServerContext* rpc);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_EDIT_STREAM_CALL_H_
