// A request message with its parse result. If bytes are not a valid message, gRPC's callback API
// answers unary calls with UNIMPLEMENTED without text, and on streams takes it for the end. With
// this request type the call itself sees the failure. Costs a bool per message. Pure.
#ifndef DYNMESH_SERVER_CALLS_RECEIVED_H_
#define DYNMESH_SERVER_CALLS_RECEIVED_H_

#include <google/protobuf/message_lite.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/status.h>

#include "absl/status/status.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"

namespace dynmesh::server {

template <typename Message>
struct Received {
  Message message;
  bool is_parsed = false;  // if false, the message is unspecified
};

// INVALID_ARGUMENT (BAD_REQUEST).
absl::Status NotParsed(const google::protobuf::MessageLite& message);

}  // namespace dynmesh::server

template <typename Message>
class grpc::SerializationTraits<dynmesh::server::Received<Message>, void> {
 public:
  static grpc::Status Deserialize(grpc::ByteBuffer* buffer,
                                  dynmesh::server::Received<Message>* out) {
    out->is_parsed = SerializationTraits<Message>::Deserialize(buffer, &out->message).ok();
    return grpc::Status();
  }
};

#endif  // DYNMESH_SERVER_CALLS_RECEIVED_H_
