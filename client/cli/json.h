// One JSON object on one line: the output of --json. Keys are literals, in the order added. Doubles
// are the shortest that read back exactly, null if not finite.
//
// Only texts are nlohmann's. Its writer prints the double 1 as 1.0, some doubles with more digits
// than needed, and no space in `"key": 1`, which scripts search for.
#ifndef DYNMESH_CLIENT_CLI_JSON_H_
#define DYNMESH_CLIENT_CLI_JSON_H_

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace dynmesh::cli {

class JsonObject {
 public:
  // Counts and measures. 64-bit ids and hashes are strings in JSON: use AddText.
  template <std::integral T>
  requires(!std::same_as<T, bool>) JsonObject& Add(std::string_view key, T value) {
    return AddRaw(key, std::to_string(value));
  }
  JsonObject& Add(std::string_view key, double value);
  template <std::same_as<bool> T>
  JsonObject& Add(std::string_view key, T value) {
    return AddRaw(key, value ? "true" : "false");
  }
  JsonObject& AddText(std::string_view key, std::string_view value);
  JsonObject& AddTexts(std::string_view key, const std::vector<std::string>& values);
  JsonObject& AddCounts(std::string_view key, const std::vector<std::uint64_t>& values);
  JsonObject& AddNumbers(std::string_view key, const std::vector<double>& values);
  JsonObject& AddObject(std::string_view key, const JsonObject& value);
  JsonObject& AddObjects(std::string_view key, const std::vector<JsonObject>& values);

  std::string ToString() const { return "{" + members_ + "}"; }
  std::string ToLine() const { return ToString() + "\n"; }

 private:
  JsonObject& AddRaw(std::string_view key, std::string_view value);

  std::string members_;
};

// A JSON string, with quotes. Invalid UTF-8 becomes U+FFFD.
std::string JsonQuote(std::string_view text);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_JSON_H_
