#include "proto/codec/grpc_status.h"

#include "dynmesh/v1/status_details.pb.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::codec {

grpc::Status ToGrpcStatus(const absl::Status& status, absl::string_view edits_field) {
  if (status.ok()) return grpc::Status::OK;
  const v1::Status proto = StatusToProto(status, edits_field);
  return grpc::Status(static_cast<grpc::StatusCode>(proto.code()), proto.message(),
                      proto.SerializeAsString());
}

absl::Status FromGrpcStatus(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  v1::Status proto;
  if (!status.error_details().empty() && proto.ParseFromString(status.error_details()) &&
      proto.code() == static_cast<int>(status.error_code())) {
    return StatusFromProto(proto);
  }
  proto.Clear();
  proto.set_code(static_cast<int>(status.error_code()));
  proto.set_message(status.error_message());
  return StatusFromProto(proto);
}

}  // namespace dynmesh::codec
