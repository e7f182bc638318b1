// How a call ends whose client does not take what is sent to it.
#ifndef DYNMESH_SERVER_CALLS_SEND_TIMEOUT_H_
#define DYNMESH_SERVER_CALLS_SEND_TIMEOUT_H_

#include <grpcpp/server_context.h>

#include "absl/status/status.h"
#include "server/calls/admission.h"
#include "server/calls/open_sends.h"

namespace dynmesh::server {

// From now until sender.Leave the call is ended if a message takes longer than the limit. `rpc`
// must be there until then.
void LimitSends(ServiceContext& context, grpc::CallbackServerContext* rpc,
                OpenSends::Sender& sender);

// Why gRPC says that a message did not go, or that the call is cancelled: DEADLINE_EXCEEDED
// (SLOW_RECEIVER) if the limit ended it, else CANCELLED with `otherwise`.
absl::Status WhyCut(const ServiceContext& context, const OpenSends::Sender& sender,
                    absl::string_view otherwise);

// Now and then.
void EndSlowReceivers(ServiceContext& context);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_SEND_TIMEOUT_H_
