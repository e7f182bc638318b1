// A message as it came in: gRPC's callback API answers bytes that are no message of the method's
// type with UNIMPLEMENTED and no text, and takes them for the end of a stream. With this as the
// type of the request, the call itself learns of them. Costs a bool a message. Pure.
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
  bool is_parsed = false;  // else the message is unspecified
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
