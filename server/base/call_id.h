// The id of a call, by which its lines in the log are found: the client's, if it sent one in the
// metadata (x-request-id) that is short and printable, else a fresh one. It goes back in the
// initial metadata. Not to be confused with the request_id of a batch, which makes retries safe.
// Thread-safe.
#ifndef DYNMESH_SERVER_BASE_CALL_ID_H_
#define DYNMESH_SERVER_BASE_CALL_ID_H_

#include <grpcpp/server_context.h>

#include <string>

#include "absl/strings/string_view.h"

namespace dynmesh::server {

inline constexpr char kCallIdKey[] = "x-request-id";

// `given` if it is 1 to 64 printable characters of ASCII without spaces, else 16 hex digits that
// no other call of this process has.
std::string ChooseCallId(absl::string_view given);

// The id that the call has: CallObserver puts it into the metadata before the call is handled.
std::string CallIdOf(const grpc::CallbackServerContext& call);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_CALL_ID_H_
