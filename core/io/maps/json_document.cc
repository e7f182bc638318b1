#include "core/io/maps/json_document.h"

#include <cstddef>
#include <filesystem>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "core/base/text.h"
#include "core/io/common/text_reader.h"

namespace dynmesh::io {

using text::Concat;
using text::Quoted;

namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

// The position of the parser, updated by the iterators through which it reads.
class Cursor {
 public:
  explicit Cursor(std::string_view text) : text_(text) {}

  char Get() const { return text_[at_]; }
  void Advance() { ++at_; }
  bool AtEnd() const { return at_ >= text_.size(); }

  // The line of the value that the parser has just reported. It may have read one character past
  // it, to find the end of a number.
  int Line() {
    std::size_t last = at_;
    while (last > counted_ && IsBlank(text_[last - 1])) --last;
    for (; counted_ < last; ++counted_) line_ += text_[counted_] == '\n';
    return line_;
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t counted_ = 0;  // newlines before this are in line_
  int line_ = 1;
};

class CursorIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = char;

  explicit CursorIterator(Cursor* cursor) : cursor_(cursor) {}
  char operator*() const { return cursor_->Get(); }
  CursorIterator& operator++() {
    cursor_->Advance();
    return *this;
  }
  CursorIterator operator++(int) {
    const CursorIterator before = *this;
    ++*this;
    return before;
  }
  // Only for comparison with the end, which has no cursor.
  friend bool operator==(const CursorIterator& a, const CursorIterator& b) {
    return a.IsEnd() == b.IsEnd();
  }
  friend bool operator!=(const CursorIterator& a, const CursorIterator& b) { return !(a == b); }

 private:
  bool IsEnd() const { return cursor_ == nullptr || cursor_->AtEnd(); }
  Cursor* cursor_;
};

}  // namespace

// Called by the parser for each value.
class JsonBuilder {
 public:
  using Json = nlohmann::json;
  using number_integer_t = Json::number_integer_t;
  using number_unsigned_t = Json::number_unsigned_t;
  using number_float_t = Json::number_float_t;
  using string_t = Json::string_t;
  using binary_t = Json::binary_t;
  using Kind = JsonDocument::Kind;

  JsonBuilder(JsonDocument& document, const JsonLimits& limits, Cursor& cursor)
      : document_(document), limits_(limits), cursor_(cursor) {}

  bool null() { return Add(Kind::kNull, 0); }
  bool boolean(bool value) { return Add(Kind::kBool, value ? 1 : 0); }
  bool number_integer(number_integer_t value) {
    return Add(Kind::kNumber, static_cast<double>(value));
  }
  bool number_unsigned(number_unsigned_t value) {
    return Add(Kind::kNumber, static_cast<double>(value));
  }
  bool number_float(number_float_t value, const string_t&) { return Add(Kind::kNumber, value); }
  bool string(string_t& value) {
    document_.strings_.push_back(std::move(value));
    return Add(Kind::kString, static_cast<double>(document_.strings_.size() - 1));
  }
  bool binary(binary_t&) { return Fail("binary values are no JSON"); }
  bool key(string_t& value) { return string(value); }
  bool start_object(std::size_t) { return Open(Kind::kObject); }
  bool start_array(std::size_t) { return Open(Kind::kArray); }
  bool end_object() { return Close(); }
  bool end_array() { return Close(); }

  template <class Exception>
  bool parse_error(std::size_t, const std::string& last_token, const Exception& error) {
    // The library's error 406: a number outside the range of doubles.
    if (error.id == 406) {
      return Fail(Concat("the number ", Quoted(last_token), " is outside a double's range"));
    }
    if (cursor_.AtEnd() && document_.nodes_.empty()) return Fail("the file holds no JSON");
    return Fail(cursor_.AtEnd() && !open_.empty()
                    ? std::string("the JSON text ends before its last bracket is closed")
                    : Concat("this is no JSON, from ", Quoted(last_token), " on"));
  }

  const absl::Status& status() const { return status_; }

 private:
  bool Add(Kind kind, double number) {
    if (document_.nodes_.size() >= std::numeric_limits<JsonDocument::Index>::max() - 1) {
      return Fail("the file has more than 2^32 values; split it");
    }
    const auto end = static_cast<JsonDocument::Index>(document_.nodes_.size() + 1);
    document_.nodes_.push_back({kind, cursor_.Line(), end, number});
    return true;
  }

  bool Open(Kind kind) {
    if (open_.size() >= static_cast<std::size_t>(limits_.depth)) {
      return Fail(Concat("arrays and objects stand in each other more than ", limits_.depth,
                         " deep; flatten them"));
    }
    open_.push_back(document_.nodes_.size());
    return Add(kind, 0);
  }

  bool Close() {
    document_.nodes_[open_.back()].end = static_cast<JsonDocument::Index>(document_.nodes_.size());
    open_.pop_back();
    return true;
  }

  bool Fail(std::string_view message) {
    status_ = TextReader::ErrorAt(document_.name_, cursor_.Line(), message);
    return false;
  }

  JsonDocument& document_;
  const JsonLimits& limits_;
  Cursor& cursor_;
  std::vector<std::size_t> open_;
  absl::Status status_;
};

namespace {

absl::Status TooLarge(const std::string& name, std::uint64_t bytes, const JsonLimits& limits) {
  return absl::InvalidArgumentError(Concat(name, ": the file has ", bytes, " bytes, more than the ",
                                           limits.bytes, " that are read; split it"));
}

}  // namespace

absl::StatusOr<JsonDocument> JsonDocument::Parse(std::string name, std::string_view text,
                                                 const JsonLimits& limits) {
  if (text.size() > limits.bytes) return TooLarge(name, text.size(), limits);
  JsonDocument document;
  document.name_ = std::move(name);
  Cursor cursor(text);
  JsonBuilder builder(document, limits, cursor);
  const bool parsed =
      nlohmann::json::sax_parse(CursorIterator(&cursor), CursorIterator(nullptr), &builder);
  if (!builder.status().ok()) return builder.status();
  if (!parsed) return absl::InternalError(document.name_ + ": the JSON parser gave no reason");
  return document;
}

absl::StatusOr<JsonDocument> JsonDocument::Read(const std::string& path, const JsonLimits& limits) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (!error && bytes > limits.bytes) return TooLarge(path, bytes, limits);
  const absl::StatusOr<std::string> text = ReadWholeFile(path);
  if (!text.ok()) return text.status();
  return Parse(path, *text, limits);
}

std::optional<JsonDocument::Index> JsonDocument::Find(Index object, std::string_view key) const {
  for (Index i = First(object); i < End(object); i = Next(object, i)) {
    if (text(i - 1) == key) return i;
  }
  return std::nullopt;
}

absl::Status JsonDocument::Error(Index v, std::string_view message) const {
  return TextReader::ErrorAt(name_, line(v), message);
}

}  // namespace dynmesh::io
