#include "client/cli/json.h"

#include <cmath>

#include "core/data/text.h"

namespace dynmesh::cli {
namespace {

// Length of the valid UTF-8 sequence that `text` starts with, else 0.
std::size_t SequenceLength(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xf5   ? 0
                             : first >= 0xf0 ? 4
                             : first >= 0xe0 ? 3
                             : first >= 0xc2 ? 2
                                             : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  // Overlong forms, surrogates, above U+10FFFF.
  if (first == 0xe0 && byte(1) < 0xa0) return 0;
  if (first == 0xed && byte(1) > 0x9f) return 0;
  if (first == 0xf0 && byte(1) < 0x90) return 0;
  if (first == 0xf4 && byte(1) > 0x8f) return 0;
  return length;
}

std::string Number(double value) { return std::isfinite(value) ? data::Concat(value) : "null"; }

}  // namespace

std::string JsonQuote(std::string_view text) {
  std::string result = "\"";
  while (!text.empty()) {
    const char c = text[0];
    const std::size_t length = SequenceLength(text);
    if (length == 0) {
      result += "\xef\xbf\xbd";
    } else if (c == '"' || c == '\\') {
      result += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20) {
      result += "\\u" + data::Hex(static_cast<unsigned char>(c)).substr(12);
    } else {
      result.append(text.substr(0, length));
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return result + "\"";
}

JsonObject& JsonObject::AddRaw(std::string_view key, std::string_view value) {
  if (!members_.empty()) members_ += ", ";
  members_ += data::Concat("\"", key, "\": ", value);
  return *this;
}

JsonObject& JsonObject::Add(std::string_view key, double value) {
  return AddRaw(key, Number(value));
}

JsonObject& JsonObject::AddText(std::string_view key, std::string_view value) {
  return AddRaw(key, JsonQuote(value));
}

JsonObject& JsonObject::AddTexts(std::string_view key, const std::vector<std::string>& values) {
  std::string list;
  for (const std::string& value : values) {
    list += (list.empty() ? "" : ", ") + JsonQuote(value);
  }
  return AddRaw(key, "[" + list + "]");
}

JsonObject& JsonObject::AddCounts(std::string_view key, const std::vector<std::uint64_t>& values) {
  std::string list;
  for (const std::uint64_t value : values) {
    list += (list.empty() ? "" : ", ") + std::to_string(value);
  }
  return AddRaw(key, "[" + list + "]");
}

JsonObject& JsonObject::AddNumbers(std::string_view key, const std::vector<double>& values) {
  std::string list;
  for (const double value : values) list += (list.empty() ? "" : ", ") + Number(value);
  return AddRaw(key, "[" + list + "]");
}

JsonObject& JsonObject::AddObject(std::string_view key, const JsonObject& value) {
  return AddRaw(key, value.ToString());
}

JsonObject& JsonObject::AddObjects(std::string_view key, const std::vector<JsonObject>& values) {
  std::string list;
  for (const JsonObject& value : values) {
    list += (list.empty() ? "" : ", ") + value.ToString();
  }
  return AddRaw(key, "[" + list + "]");
}

}  // namespace dynmesh::cli
