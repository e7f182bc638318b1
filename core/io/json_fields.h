// What the readers of both kinds of map ask of a JSON value.
#ifndef DYNMESH_CORE_IO_JSON_FIELDS_H_
#define DYNMESH_CORE_IO_JSON_FIELDS_H_

#include <array>
#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/file_features.h"
#include "core/io/json_document.h"

namespace dynmesh::io {

// The member `key` of a value, which must be an object that has it and of that kind.
// Errors name `what`, the thing that the object is.
absl::StatusOr<JsonDocument::Index> Member(const JsonDocument& json, JsonDocument::Index object,
                                           std::string_view key, JsonDocument::Kind kind,
                                           std::string_view what);
// The text of member "type".
absl::StatusOr<std::string_view> TypeOf(const JsonDocument& json, JsonDocument::Index object,
                                        std::string_view what);

absl::Status ExpectArray(const JsonDocument& json, JsonDocument::Index v, std::string_view what);
std::size_t Count(const JsonDocument& json, JsonDocument::Index v);

// The member `id` and, in `properties`, the member `name` of an object: texts as they are, numbers
// as text, empty where there is none.
PolygonName NamesOf(const JsonDocument& json, JsonDocument::Index object);

struct Position {
  std::array<double, 2> at{};
  bool has_more = false;  // a height, measures
};
// [x, y, ...].
absl::StatusOr<Position> ReadPosition(const JsonDocument& json, JsonDocument::Index v);
// Within what the mesher can compute with?
absl::Status CheckMagnitude(const JsonDocument& json, JsonDocument::Index v,
                            const std::array<double, 2>& at);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_JSON_FIELDS_H_
