// Reads a text file line by line, split at blanks, without comments, and keeps the line of every
// value: all readers report `file:line: what is wrong`.
#ifndef DYNMESH_CORE_IO_COMMON_TEXT_READER_H_
#define DYNMESH_CORE_IO_COMMON_TEXT_READER_H_

#include <algorithm>
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

// Parses exactly one number, the whole of `text`; allows a leading +. False if it is no number, not
// finite, or outside the range of doubles.
bool ParseDouble(std::string_view text, double* value);
bool ParseUint64(std::string_view text, std::uint64_t* value);
bool ParseInt64(std::string_view text, std::int64_t* value);

// The numbers of a line one after the other, in place. Takes what the functions above take, but for
// a leading +: what is false here may still be right.
class NumberCursor {
 public:
  // Of the line that starts at `text`.
  explicit NumberCursor(std::string_view text) : at_(text.data()), end_(at_ + text.size()) {}

  bool Take(double* value);
  bool Take(std::uint64_t* value);
  bool Take(std::int64_t* value);
  // Is that all of the line? Then goes behind its end.
  bool TakeEnd();
  const char* at() const { return at_; }

 private:
  template <class T>
  bool TakeNumber(T* value);
  void SkipBlanks();

  const char* at_;
  const char* end_;
};

// Thread-compatible; move-only.
class TextReader {
 public:
  // `name` is for messages.
  TextReader(std::string name, std::string text);
  static absl::StatusOr<TextReader> Open(const std::string& path);

  // Goes to the next line with a value; false at the end of the file. `#` starts a comment,
  // anywhere.
  bool Next();
  // Goes behind the next line if take(NumberCursor&) takes all of it; else nothing changes. Many
  // times as fast as Next for rows of numbers. There are no tokens then.
  template <class TakeLine>
  bool TakeNext(TakeLine take) {
    NumberCursor cursor(std::string_view(*text_).substr(std::min(next_, text_->size())));
    if (!take(cursor) || !cursor.TakeEnd()) return false;
    next_ = static_cast<std::size_t>(cursor.at() - text_->data());
    ++line_;
    joined_ = 0;
    tokens_.clear();
    return true;
  }
  // While the line ends in a backslash, adds the values of the next one to it. `line` stays.
  void JoinContinued();

  // The next `count` bytes as they are, from behind the current line; less at the end of the file.
  std::string_view Bytes(std::size_t count);

  const std::vector<std::string_view>& tokens() const { return tokens_; }
  std::size_t size() const { return tokens_.size(); }
  std::string_view token(std::size_t i) const { return tokens_[i]; }
  // What stands behind token i on its line, comments, too; without blanks at the ends.
  std::string_view RestOfLine(std::size_t i) const;
  // The current line, from 1; after the end, the last line.
  int line() const { return line_ - joined_; }
  const std::string& name() const { return name_; }
  const std::string& text() const { return *text_; }  // all of it, unchanged
  std::size_t text_size() const { return text_->size(); }

  // Comments so far that start with "# dynmesh ", without that start.
  const std::vector<std::string>& notes() const { return notes_; }

  // "name:line: message", INVALID_ARGUMENT.
  absl::Status Error(std::string_view message) const;
  static absl::Status ErrorAt(std::string_view name, int line, std::string_view message);

  // Token i as a value; `what` names it in the message.
  absl::StatusOr<double> Double(std::size_t i, std::string_view what) const;
  absl::StatusOr<std::uint64_t> Uint64(std::size_t i, std::string_view what) const;

 private:
  // Appends the values of the line after `next_`.
  void ReadLine();
  void Split(std::string_view line);

  std::string name_;
  std::unique_ptr<const std::string>
      text_;  // tokens point into it; it does not move with the reader
  std::size_t next_ = 0;
  int line_ = 0;
  int joined_ = 0;  // lines added to the current one
  std::vector<std::string_view> tokens_;
  std::vector<std::string> notes_;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_TEXT_READER_H_
