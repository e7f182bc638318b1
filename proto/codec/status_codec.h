// Statuses across the wire: absl::Status <-> google.rpc.Status with its details.
//
// Inside the process an absl::Status carries either the library's ErrorDetail
// (dynmesh/error.h) or a ServiceError; on the wire both are google.rpc
// ErrorInfo, BadRequest and RetryInfo. Pure functions, thread-safe.
#ifndef DYNMESH_PROTO_CODEC_STATUS_CODEC_H_
#define DYNMESH_PROTO_CODEC_STATUS_CODEC_H_

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "dynmesh/codec/service_error.h"

namespace dynmesh::v1 {
class Status;
}

namespace dynmesh::codec {

// A status with `error` attached.
absl::Status MakeServiceError(absl::StatusCode code, absl::string_view message,
                              const ServiceError& error);

// Long messages are cut to 1 kB and feature lists to 32: a status must fit the 8 kB
// that HTTP/2 peers take as headers. `edits_field` names the request's list of edits.
v1::Status StatusToProto(const absl::Status& status, absl::string_view edits_field = "edits");
absl::Status StatusFromProto(const v1::Status& proto);

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_STATUS_CODEC_H_
