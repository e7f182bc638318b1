// The values of a `.msh` one after the other: of text, or in a binary file of bytes. There, ints
// have 4 bytes, sizes and doubles 8; headers, names and the lines around sections are text.
#ifndef DYNMESH_CORE_IO_ELEMENTS_MSH_STREAM_H_
#define DYNMESH_CORE_IO_ELEMENTS_MSH_STREAM_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "core/io/elements/token_stream.h"

namespace dynmesh::io {

enum class MshNumber : std::uint8_t { kInt, kSize, kReal };

// Thread-compatible. Errors are as of TokenStream; in bytes at the last line of text before them.
class MshStream {
 public:
  explicit MshStream(TextReader reader) : text_(std::move(reader)) {}

  // Lines and names, which are text in any file.
  TokenStream& text() { return text_; }
  const TokenStream& text() const { return text_; }

  bool is_binary() const { return is_binary_; }
  // From now on numbers are bytes; the next int is 1, in the order of the file's bytes.
  absl::Status BeginBinary() {
    is_binary_ = true;
    const absl::StatusOr<std::int64_t> one = Int("the number 1, for the order of bytes");
    if (!one.ok()) return one.status();
    is_swapped_ = *one == 1 << 24;
    if (*one == 1 || is_swapped_) return absl::OkStatus();
    return text_.Error("a binary file must have the number 1 behind the size of numbers");
  }

  absl::StatusOr<std::int64_t> Int(std::string_view what) {
    return is_binary_ ? Bytes<std::int64_t, std::int32_t>(what) : text_.Int64(what);
  }
  // An int or a size that is not negative.
  absl::StatusOr<std::uint64_t> Unsigned(MshNumber number, std::string_view what) {
    if (!is_binary_) return text_.Uint64(what);
    if (number == MshNumber::kSize) return Bytes<std::uint64_t, std::uint64_t>(what);
    const absl::StatusOr<std::int64_t> value = Int(what);
    if (!value.ok()) return value.status();
    if (*value < 0) return text_.Error(text::Concat(what, " is below 0: ", *value));
    return static_cast<std::uint64_t>(*value);
  }
  absl::StatusOr<double> Real(std::string_view what) {
    if (!is_binary_) return text_.Double(what);
    const absl::StatusOr<double> value = Bytes<double, double>(what);
    if (!value.ok() || std::isfinite(*value)) return value;
    return text_.Error(
        text::Concat(what, " is not a finite number within a double's range: ", *value));
  }
  // A count as that of TokenStream.
  absl::StatusOr<std::uint64_t> Count(MshNumber number, std::string_view what) {
    if (!is_binary_) return text_.Count(what);
    const absl::StatusOr<std::uint64_t> count = Unsigned(number, what);
    if (!count.ok() || *count <= text_.text_size() / 2) return count;
    return text_.Error(text::Concat(what, ": the file is too short for ", *count));
  }
  absl::Status Skip(MshNumber number, std::uint64_t count, std::string_view what) {
    if (!is_binary_) return text_.Skip(count, what);
    const std::uint64_t each = number == MshNumber::kInt ? 4 : 8;
    if (count > text_.text_size() / each || text_.Bytes(count * each).size() < count * each) {
      return text_.EndsBefore(what);
    }
    return absl::OkStatus();
  }

 private:
  // A value of type `Stored`.
  template <class Value, class Stored>
  absl::StatusOr<Value> Bytes(std::string_view what) {
    char bytes[sizeof(Stored)];
    const std::string_view found = text_.Bytes(sizeof(Stored));
    if (found.size() < sizeof(Stored)) return text_.EndsBefore(what);
    std::copy(found.begin(), found.end(), bytes);
    if (is_swapped_) std::reverse(bytes, bytes + sizeof(Stored));
    Stored value;
    std::memcpy(&value, bytes, sizeof(Stored));
    return static_cast<Value>(value);
  }

  TokenStream text_;
  bool is_binary_ = false, is_swapped_ = false;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_ELEMENTS_MSH_STREAM_H_
