// Conversion of statuses: absl::Status <-> google.rpc.Status with its details.
//
// In the process an absl::Status carries the library's ErrorDetail (dynmesh/error.h) or a
// ServiceError. In messages both are google.rpc ErrorInfo, BadRequest and RetryInfo. Pure
// functions, thread-safe.
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

// Cuts long messages to 1 kB and feature lists to 32 ids, since a status must fit the 8 kB that
// HTTP/2 peers accept as headers. `edits_field` names the request's list of edits.
v1::Status StatusToProto(const absl::Status& status, absl::string_view edits_field = "edits");
absl::Status StatusFromProto(const v1::Status& proto);

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_STATUS_CODEC_H_
