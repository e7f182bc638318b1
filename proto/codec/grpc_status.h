// absl::Status <-> grpc::Status with google.rpc details. Pure, thread-safe.
#ifndef DYNMESH_PROTO_CODEC_GRPC_STATUS_H_
#define DYNMESH_PROTO_CODEC_GRPC_STATUS_H_

#include <grpcpp/support/status.h>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dynmesh::codec {

grpc::Status ToGrpcStatus(const absl::Status& status, absl::string_view edits_field = "edits");
absl::Status FromGrpcStatus(const grpc::Status& status);

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_GRPC_STATUS_H_
