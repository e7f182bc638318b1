// The id of a call, which marks its lines in the log: the client's metadata x-request-id if it is
// short and printable, else a fresh one. It is returned in the initial metadata. Not the request_id
// of a batch, which makes retries safe. Thread-safe.
#ifndef DYNMESH_SERVER_BASE_CALL_ID_H_
#define DYNMESH_SERVER_BASE_CALL_ID_H_

#include <grpcpp/server_context.h>

#include <string>

#include "absl/strings/string_view.h"

namespace dynmesh::server {

inline constexpr char kCallIdKey[] = "x-request-id";

// `given` if it is 1 to 64 printable ASCII characters without spaces, else 16 hex digits that are
// unique in this process.
std::string ChooseCallId(absl::string_view given);

// The call's id. CallObserver puts it into the metadata before the call is handled.
std::string CallIdOf(const grpc::CallbackServerContext& call);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_CALL_ID_H_
