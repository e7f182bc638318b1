#include "client/cli/json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "absl/strings/str_join.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

std::string Number(double value) { return std::isfinite(value) ? text::Concat(value) : "null"; }

template <class Values, class ToText>
std::string List(const Values& values, ToText to_text) {
  const auto append = [&](std::string* list, const auto& value) { *list += to_text(value); };
  return "[" + absl::StrJoin(values, ", ", append) + "]";
}

}  // namespace

std::string JsonQuote(std::string_view text) {
  using Json = nlohmann::json;
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

JsonObject& JsonObject::AddRaw(std::string_view key, std::string_view value) {
  if (!members_.empty()) members_ += ", ";
  members_ += text::Concat("\"", key, "\": ", value);
  return *this;
}

JsonObject& JsonObject::Add(std::string_view key, double value) {
  return AddRaw(key, Number(value));
}

JsonObject& JsonObject::AddText(std::string_view key, std::string_view value) {
  return AddRaw(key, JsonQuote(value));
}

JsonObject& JsonObject::AddTexts(std::string_view key, const std::vector<std::string>& values) {
  return AddRaw(key, List(values, JsonQuote));
}

JsonObject& JsonObject::AddCounts(std::string_view key, const std::vector<std::uint64_t>& values) {
  return AddRaw(key, List(values, [](std::uint64_t value) { return std::to_string(value); }));
}

JsonObject& JsonObject::AddNumbers(std::string_view key, const std::vector<double>& values) {
  return AddRaw(key, List(values, Number));
}

JsonObject& JsonObject::AddObject(std::string_view key, const JsonObject& value) {
  return AddRaw(key, value.ToString());
}

JsonObject& JsonObject::AddObjects(std::string_view key, const std::vector<JsonObject>& values) {
  return AddRaw(key, List(values, [](const JsonObject& value) { return value.ToString(); }));
}

}  // namespace dynmesh::cli
