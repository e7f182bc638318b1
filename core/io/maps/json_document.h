// A JSON text as a flat list of values, each with its line. A JSON library has no lines, and its
// trees take many times the size of a map's text; this takes 24 bytes per value.
#ifndef DYNMESH_CORE_IO_MAPS_JSON_DOCUMENT_H_
#define DYNMESH_CORE_IO_MAPS_JSON_DOCUMENT_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dynmesh::io {

struct JsonLimits {
  int depth = 64;                            // of nested arrays and objects
  std::size_t bytes = std::size_t{1} << 30;  // of the text
};

// Immutable after parsing, so thread-safe. Values are named by their index; 0 is the whole
// document.
class JsonDocument {
 public:
  using Index = std::uint32_t;
  enum class Kind : std::uint8_t { kNull, kBool, kNumber, kString, kArray, kObject };

  // INVALID_ARGUMENT as `name:line: ...` for invalid JSON, for a number outside the range of
  // doubles, and beyond a limit.
  static absl::StatusOr<JsonDocument> Parse(std::string name, std::string_view text,
                                            const JsonLimits& limits = {});
  // The file at `path`; NOT_FOUND and the like if it cannot be read.
  static absl::StatusOr<JsonDocument> Read(const std::string& path, const JsonLimits& limits = {});

  Kind kind(Index v) const { return nodes_[v].kind; }
  int line(Index v) const { return nodes_[v].line; }
  const std::string& name() const { return name_; }
  // REQUIRES: of that kind.
  double number(Index v) const { return nodes_[v].number; }
  const std::string& text(Index v) const {
    return strings_[static_cast<std::size_t>(nodes_[v].number)];
  }

  // The first member of an object with that key; nothing if absent. O(members).
  std::optional<Index> Find(Index object, std::string_view key) const;

  // The elements of an array or the values of an object: from First(v), by Next, to End(v). The key
  // of an object's value v is text(v - 1).
  Index First(Index v) const { return v + (kind(v) == Kind::kObject ? 2 : 1); }
  Index Next(Index parent, Index v) const {
    return nodes_[v].end + (kind(parent) == Kind::kObject ? 1 : 0);
  }
  Index End(Index v) const { return nodes_[v].end; }
  // Like a range-for, as long as `visit(Index)` returns OK.
  template <class Visit>
  absl::Status ForEach(Index v, Visit visit) const {
    for (Index i = First(v); i < End(v); i = Next(v, i)) {
      if (absl::Status status = visit(i); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  // "name:line: message", INVALID_ARGUMENT, with the line of a value.
  absl::Status Error(Index v, std::string_view message) const;

 private:
  friend class JsonBuilder;
  // Preorder. In an object each value comes after a string, its key.
  struct Node {
    Kind kind = Kind::kNull;
    int line = 0;
    Index end = 0;      // past the last value inside
    double number = 0;  // or the index of a string in strings_
  };

  std::string name_;
  std::vector<Node> nodes_;
  std::vector<std::string> strings_;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MAPS_JSON_DOCUMENT_H_
