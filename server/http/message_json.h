// Messages between bytes of Protobuf and its JSON, by their type. Pure.
#ifndef DYNMESH_SERVER_HTTP_MESSAGE_JSON_H_
#define DYNMESH_SERVER_HTTP_MESSAGE_JSON_H_

#include <google/protobuf/descriptor.h>

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server {

// `type` is of a generated message. INVALID_ARGUMENT, with the place, for text that is no JSON of
// that type: a name that the type does not have is an error. Empty text is an empty message.
absl::StatusOr<std::string> JsonToBytes(const google::protobuf::Descriptor& type,
                                        absl::string_view json);
// Names in lowerCamelCase, 64-bit integers as text, fields with their default left out. INTERNAL
// if the bytes are not of that type.
absl::StatusOr<std::string> BytesToJson(const google::protobuf::Descriptor& type,
                                        absl::string_view bytes);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_MESSAGE_JSON_H_
