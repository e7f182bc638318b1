// The Connect protocol (connectrpc.com/docs/protocol): how calls of gRPC look over plain HTTP.
// Pure.
//
// A unary call is POST /dynmesh.v1.MeshService/GetMesh with a message as body, as JSON or as bytes
// of Protobuf; its answer likewise, an error with a status of HTTP and as JSON. A stream's messages
// have five bytes before them: flags, and the length. Its last one, with the flag 2, is JSON: {} or
// the error.
#ifndef DYNMESH_SERVER_HTTP_CONNECT_PROTOCOL_H_
#define DYNMESH_SERVER_HTTP_CONNECT_PROTOCOL_H_

#include <grpcpp/support/status.h>

#include <chrono>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server::connectrpc {

inline constexpr unsigned char kCompressed = 1, kEndOfStream = 2;
inline constexpr std::size_t kPrefixBytes = 5;

// How messages are written, by the content's type.
struct Codec {
  bool is_json = false;
  bool is_stream = false;
};
// Of application/json, application/proto, application/connect+json, application/connect+proto, with
// or without parameters; nothing for others.
std::optional<Codec> CodecOf(absl::string_view content_type);
const char* TypeOf(const Codec& codec);

// The code's name: "not_found". "unknown" for a code that gRPC does not have.
const char* NameOf(grpc::StatusCode code);
int HttpStatusOf(grpc::StatusCode code);

// {"code": …, "message": …, "details": […]}. Each detail has its type, its bytes in base64, and as
// "debug" what they say.
std::string ErrorJson(const grpc::Status& status);

// Of the header Connect-Timeout-Ms: at most ten digits. INVALID_ARGUMENT otherwise.
absl::StatusOr<std::chrono::milliseconds> ParseTimeout(absl::string_view text);

std::string Envelope(unsigned char flags, absl::string_view message);
// The message of a body that has one, with its five bytes. INVALID_ARGUMENT otherwise.
absl::StatusOr<absl::string_view> OpenEnvelope(absl::string_view body);
// The last message of a stream.
std::string EndOfStream(const grpc::Status& status);

}  // namespace dynmesh::server::connectrpc

#endif  // DYNMESH_SERVER_HTTP_CONNECT_PROTOCOL_H_
