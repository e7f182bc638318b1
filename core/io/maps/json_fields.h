// Access to JSON values for the readers of both kinds of maps.
#ifndef DYNMESH_CORE_IO_MAPS_JSON_FIELDS_H_
#define DYNMESH_CORE_IO_MAPS_JSON_FIELDS_H_

#include <array>
#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/maps/json_document.h"

namespace dynmesh::io {

// The member `key` of an object. Error if the value is no object, or has no such member of that
// kind. Errors name `what`, the meaning of the object.
absl::StatusOr<JsonDocument::Index> Member(const JsonDocument& json, JsonDocument::Index object,
                                           std::string_view key, JsonDocument::Kind kind,
                                           std::string_view what);
// The text of member "type".
absl::StatusOr<std::string_view> TypeOf(const JsonDocument& json, JsonDocument::Index object,
                                        std::string_view what);

absl::Status ExpectArray(const JsonDocument& json, JsonDocument::Index v, std::string_view what);
std::size_t Count(const JsonDocument& json, JsonDocument::Index v);

// The member `id` of an object, and the member `name` of its `properties`: texts as they are,
// numbers as text, empty if absent.
PolygonName NamesOf(const JsonDocument& json, JsonDocument::Index object);

struct Position {
  std::array<double, 2> at{};
  bool has_more = false;  // more numbers: a height, measures
};
// [x, y, ...].
absl::StatusOr<Position> ReadPosition(const JsonDocument& json, JsonDocument::Index v);
// Can the mesher compute with it?
absl::Status CheckMagnitude(const JsonDocument& json, JsonDocument::Index v,
                            const std::array<double, 2>& at);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MAPS_JSON_FIELDS_H_
