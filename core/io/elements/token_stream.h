// The values of a text one after the other, whatever the lines.
#ifndef DYNMESH_CORE_IO_ELEMENTS_TOKEN_STREAM_H_
#define DYNMESH_CORE_IO_ELEMENTS_TOKEN_STREAM_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/text.h"
#include "core/io/common/text_reader.h"

namespace dynmesh::io {

// Errors are at the line of the last value. Thread-compatible.
class TokenStream {
 public:
  explicit TokenStream(TextReader reader) : reader_(std::move(reader)) {}

  // False at the end.
  bool Next() {
    while (++at_ >= reader_.size()) {
      if (!reader_.Next()) return false;
      at_ = ~std::size_t{0};
    }
    return true;
  }
  std::string_view token() const { return reader_.token(at_); }
  // What stands behind the current value on its line, to the letter. Goes to the end of the line.
  std::string RestOfLine() {
    const std::string rest(reader_.RestOfLine(at_));
    at_ = reader_.size() - 1;
    return rest;
  }
  int line() const { return reader_.line(); }
  const std::string& name() const { return reader_.name(); }
  std::size_t text_size() const { return reader_.text_size(); }
  absl::Status Error(std::string_view message) const { return reader_.Error(message); }

  // The next bytes behind the current line, whose values have all been read.
  std::string_view Bytes(std::size_t count) { return reader_.Bytes(count); }
  absl::Status EndsBefore(std::string_view what) const {
    return Error(text::Concat("the file ends before ", what));
  }

  absl::StatusOr<double> Double(std::string_view what) {
    if (!Next()) return EndsBefore(what);
    return reader_.Double(at_, what);
  }
  absl::StatusOr<std::uint64_t> Uint64(std::string_view what) {
    if (!Next()) return EndsBefore(what);
    return reader_.Uint64(at_, what);
  }
  absl::StatusOr<std::int64_t> Int64(std::string_view what) {
    if (!Next()) return EndsBefore(what);
    std::int64_t value = 0;
    if (ParseInt64(token(), &value)) return value;
    return Error(text::Concat(what, " is not a whole number: ", text::Quoted(token())));
  }
  absl::Status Skip(std::uint64_t count, std::string_view what) {
    for (std::uint64_t i = 0; i < count; ++i) {
      if (!Next()) return EndsBefore(what);
    }
    return absl::OkStatus();
  }
  // A count of things of at least two letters each: more than the file can have is an error.
  absl::StatusOr<std::uint64_t> Count(std::string_view what) {
    const absl::StatusOr<std::uint64_t> count = Uint64(what);
    if (!count.ok() || *count <= text_size() / 2) return count;
    return Error(text::Concat(what, ": the file is too short for ", *count));
  }

 private:
  TextReader reader_;
  std::size_t at_ = ~std::size_t{0} - 1;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_ELEMENTS_TOKEN_STREAM_H_
