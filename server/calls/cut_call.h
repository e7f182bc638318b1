// Ends a call from outside, with a reason. A cancelled call can be finished with a status only
// behind the message that it is sending, and gRPC would tell the client nothing but CANCELLED.
#ifndef DYNMESH_SERVER_CALLS_CUT_CALL_H_
#define DYNMESH_SERVER_CALLS_CUT_CALL_H_

#include <grpc/grpc.h>
#include <grpcpp/server_context.h>

#include <string>

namespace dynmesh::server {

// The client gets `code` and `why`, which cannot carry details. `rpc` has not ended. Thread-safe.
inline void CutCall(grpc::CallbackServerContext& rpc, grpc_status_code code,
                    const std::string& why) {
  grpc_call_cancel_with_status(rpc.c_call(), code, why.c_str(), nullptr);
}

// For Access::Open.
inline auto CutWhenRevoked(grpc::CallbackServerContext* rpc) {
  return [rpc](const std::string& why) { CutCall(*rpc, GRPC_STATUS_CANCELLED, why); };
}

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_CUT_CALL_H_
