// Ends calls if the client does not take the messages.
#ifndef DYNMESH_SERVER_CALLS_SEND_TIMEOUT_H_
#define DYNMESH_SERVER_CALLS_SEND_TIMEOUT_H_

#include <grpcpp/server_context.h>

#include "absl/status/status.h"
#include "server/calls/admission.h"
#include "server/calls/open_sends.h"

namespace dynmesh::server {

// From now until sender.Leave: ends the call if a message takes longer than the limit. `rpc` must
// live until then.
void LimitSends(ServiceContext& context, grpc::CallbackServerContext* rpc,
                OpenSends::Sender& sender);

// The cause of a failed write or a cancelled call: DEADLINE_EXCEEDED (SLOW_RECEIVER) if the limit
// ended it, else CANCELLED with the text `otherwise`.
absl::Status WhyCut(const ServiceContext& context, const OpenSends::Sender& sender,
                    absl::string_view otherwise);

// To be called periodically.
void EndSlowReceivers(ServiceContext& context);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_SEND_TIMEOUT_H_
