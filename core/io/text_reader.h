// Reads a text file line by line, split at blanks, comments dropped, and knows for
// every value where it stood: all readers report `file:line: what is wrong`.
#ifndef DYNMESH_CORE_IO_TEXT_READER_H_
#define DYNMESH_CORE_IO_TEXT_READER_H_

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dynmesh::io {

// The whole file. NOT_FOUND or PERMISSION_DENIED, naming the path, if it cannot be read.
absl::StatusOr<std::string> ReadWholeFile(const std::string& path);

// Exactly one number, the whole of `text`; a leading + is taken. False if it is no
// number, not finite, or outside what a double can hold.
bool ParseDouble(std::string_view text, double* value);
bool ParseUint64(std::string_view text, std::uint64_t* value);
bool ParseInt64(std::string_view text, std::int64_t* value);

// Thread-compatible; move-only.
class TextReader {
 public:
  // `name` stands in messages.
  TextReader(std::string name, std::string text);
  static absl::StatusOr<TextReader> Open(const std::string& path);

  // Goes to the next line that has a value on it; false at the end of the file.
  // `#` starts a comment, anywhere.
  bool Next();

  const std::vector<std::string_view>& tokens() const { return tokens_; }
  std::size_t size() const { return tokens_.size(); }
  std::string_view token(std::size_t i) const { return tokens_[i]; }
  // Of the current line, from 1; after the end, of the last line.
  int line() const { return line_; }
  const std::string& name() const { return name_; }
  const std::string& text() const { return *text_; }  // all of it, as it is
  std::size_t text_size() const { return text_->size(); }

  // Comments that start with "# dynmesh ", met so far, without that start.
  const std::vector<std::string>& notes() const { return notes_; }

  // "name:line: message", INVALID_ARGUMENT.
  absl::Status Error(std::string_view message) const;
  static absl::Status ErrorAt(std::string_view name, int line, std::string_view message);

  // Token i as a value; `what` names it in the message.
  absl::StatusOr<double> Double(std::size_t i, std::string_view what) const;
  absl::StatusOr<std::uint64_t> Uint64(std::size_t i, std::string_view what) const;

 private:
  void Split(std::string_view line);

  std::string name_;
  std::unique_ptr<const std::string> text_;  // tokens point into it, whoever holds the reader
  std::size_t next_ = 0;
  int line_ = 0;
  std::vector<std::string_view> tokens_;
  std::vector<std::string> notes_;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_TEXT_READER_H_
