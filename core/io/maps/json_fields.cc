#include "core/io/maps/json_fields.h"

#include <cmath>

#include "core/base/text.h"
#include "core/io/common/file_writer.h"

namespace dynmesh::io {

using text::Concat;

namespace {

using Index = JsonDocument::Index;
using Kind = JsonDocument::Kind;

constexpr double kMaxMagnitude = 0x1p200;  // the limit for the box of a mesh

std::string_view NameOf(Kind kind) {
  switch (kind) {
    case Kind::kNull:
      return "null";
    case Kind::kBool:
      return "true or false";
    case Kind::kNumber:
      return "a number";
    case Kind::kString:
      return "a string";
    case Kind::kArray:
      return "an array";
    case Kind::kObject:
      return "an object";
  }
  return "";
}

}  // namespace

absl::StatusOr<Index> Member(const JsonDocument& json, Index object, std::string_view key,
                             Kind kind, std::string_view what) {
  if (json.kind(object) != Kind::kObject) {
    return json.Error(object,
                      Concat(what, " must be an object, found ", NameOf(json.kind(object))));
  }
  const std::optional<Index> member = json.Find(object, key);
  if (!member) return json.Error(object, Concat(what, " has no member \"", key, "\""));
  if (json.kind(*member) != kind) {
    return json.Error(*member, Concat("member \"", key, "\" of ", what, " must be ", NameOf(kind),
                                      ", found ", NameOf(json.kind(*member))));
  }
  return *member;
}

absl::StatusOr<std::string_view> TypeOf(const JsonDocument& json, Index object,
                                        std::string_view what) {
  const absl::StatusOr<Index> type = Member(json, object, "type", Kind::kString, what);
  if (!type.ok()) return type.status();
  return std::string_view(json.text(*type));
}

absl::Status ExpectArray(const JsonDocument& json, Index v, std::string_view what) {
  if (json.kind(v) == Kind::kArray) return absl::OkStatus();
  return json.Error(v, Concat(what, " must be an array, found ", NameOf(json.kind(v))));
}

PolygonName NamesOf(const JsonDocument& json, Index object) {
  const auto text = [&](Index of, std::string_view key) -> std::string {
    const std::optional<Index> member = json.Find(of, key);
    if (member && json.kind(*member) == Kind::kString) return json.text(*member);
    if (member && json.kind(*member) == Kind::kNumber) return FormatDouble(json.number(*member));
    return "";
  };
  PolygonName names;
  names.key = text(object, "id");
  const std::optional<Index> properties = json.Find(object, "properties");
  if (properties && json.kind(*properties) == Kind::kObject) {
    names.name = text(*properties, "name");
  }
  return names;
}

std::size_t Count(const JsonDocument& json, Index v) {
  std::size_t count = 0;
  for (Index i = json.First(v); i < json.End(v); i = json.Next(v, i)) ++count;
  return count;
}

absl::StatusOr<Position> ReadPosition(const JsonDocument& json, Index v) {
  if (auto status = ExpectArray(json, v, "a position"); !status.ok()) return status;
  Position position;
  std::size_t count = 0;
  for (Index i = json.First(v); i < json.End(v); i = json.Next(v, i), ++count) {
    if (json.kind(i) != Kind::kNumber) {
      return json.Error(i, Concat("a coordinate must be a number, found ", NameOf(json.kind(i))));
    }
    if (count < 2) position.at[count] = json.number(i);
  }
  if (count < 2)
    return json.Error(
        v, Concat("a position needs x and y, found ", count, " number", count == 1 ? "" : "s"));
  position.has_more = count > 2;
  return position;
}

absl::Status CheckMagnitude(const JsonDocument& json, Index v, const std::array<double, 2>& at) {
  for (const double x : at) {
    if (!(std::abs(x) <= kMaxMagnitude)) {
      return json.Error(v, Concat("the coordinate ", FormatDouble(x),
                                  " is above 2^200 in magnitude; choose a larger unit of length"));
    }
  }
  return absl::OkStatus();
}

}  // namespace dynmesh::io
