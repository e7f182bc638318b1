#include "core/io/common/text_reader.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/base/text.h"

namespace dynmesh::io {

using text::Concat;
using text::Quoted;

namespace {

constexpr std::string_view kNotePrefix = "# dynmesh ";

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

template <class T>
bool ParseNumber(std::string_view text, T* value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T parsed{};
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, parsed);
  if (result.ec != std::errc() || result.ptr != end) return false;
  *value = parsed;
  return true;
}

absl::Status SystemError(int error, const std::string& path, std::string_view what) {
  const std::string message = Concat(path, ": cannot ", what, ": ", std::strerror(error));
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return absl::NotFoundError(message);
    case EACCES:
    case EPERM:
      return absl::PermissionDeniedError(message);
    default:
      return absl::UnavailableError(message);
  }
}

}  // namespace

absl::StatusOr<std::string> ReadWholeFile(const std::string& path) {
  std::FILE* const file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return SystemError(errno, path, "open");
  std::string text;
  // Only a hint: a pipe has no size, and that of a sparse file may be more than there is memory.
  constexpr std::uintmax_t kMostAhead = std::uintmax_t{1} << 30, kMostAtOnce = 1 << 24;
  std::error_code unknown;
  std::uintmax_t size = std::filesystem::file_size(path, unknown);
  if (unknown) size = 0;
  text.reserve(std::min(size, kMostAhead));
  // Small files without a large block beside them.
  text.resize(std::min(size, kMostAtOnce));
  std::size_t got = std::fread(text.data(), 1, text.size(), file);
  const bool is_all = got < text.size();
  text.resize(got);
  std::vector<char> buffer(is_all ? 0
                                  : std::size_t{1} << (0 < size && size <= kMostAtOnce ? 8 : 18));
  while (!is_all && (got = std::fread(buffer.data(), 1, buffer.size(), file)) > 0) {
    text.append(buffer.data(), got);
  }
  const int error = std::ferror(file) ? errno : 0;
  std::fclose(file);
  if (error == EISDIR) return absl::InvalidArgumentError(path + ": is a folder, not a file");
  if (error != 0) return SystemError(error, path, "read");
  return text;
}

bool ParseDouble(std::string_view text, double* value) {
  double parsed = 0;
  if (!ParseNumber(text, &parsed) || !std::isfinite(parsed)) return false;
  *value = parsed;
  return true;
}

bool ParseUint64(std::string_view text, std::uint64_t* value) { return ParseNumber(text, value); }

bool ParseInt64(std::string_view text, std::int64_t* value) { return ParseNumber(text, value); }

void NumberCursor::SkipBlanks() {
  while (at_ != end_ && IsBlank(*at_)) ++at_;
}

template <class T>
bool NumberCursor::TakeNumber(T* value) {
  SkipBlanks();
  const auto [behind, error] = std::from_chars(at_, end_, *value);
  if (error != std::errc() || (behind != end_ && *behind != '\n' && !IsBlank(*behind))) {
    return false;
  }
  at_ = behind;
  return true;
}

bool NumberCursor::Take(double* value) { return TakeNumber(value) && std::isfinite(*value); }
bool NumberCursor::Take(std::uint64_t* value) { return TakeNumber(value); }
bool NumberCursor::Take(std::int64_t* value) { return TakeNumber(value); }

bool NumberCursor::TakeEnd() {
  SkipBlanks();
  if (at_ == end_) return true;
  return *at_++ == '\n';
}

TextReader::TextReader(std::string name, std::string text)
    : name_(std::move(name)), text_(std::make_unique<const std::string>(std::move(text))) {
  if (text_->starts_with("\xef\xbb\xbf")) next_ = 3;  // a byte order mark is no value
}

absl::StatusOr<TextReader> TextReader::Open(const std::string& path) {
  absl::StatusOr<std::string> text = ReadWholeFile(path);
  if (!text.ok()) return text.status();
  return TextReader(path, *std::move(text));
}

bool TextReader::Next() {
  tokens_.clear();
  joined_ = 0;
  while (next_ < text_->size()) {
    ReadLine();
    if (!tokens_.empty()) return true;
  }
  return false;
}

std::string_view TextReader::Bytes(std::size_t count) {
  const std::string_view rest = std::string_view(*text_).substr(std::min(next_, text_->size()));
  const std::string_view bytes = rest.substr(0, count);
  next_ += bytes.size();
  return bytes;
}

void TextReader::JoinContinued() {
  while (!tokens_.empty() && tokens_.back().ends_with('\\')) {
    tokens_.back().remove_suffix(1);
    if (tokens_.back().empty()) tokens_.pop_back();
    if (next_ >= text_->size()) return;
    ++joined_;
    ReadLine();
  }
}

void TextReader::ReadLine() {
  const std::string_view text = *text_;
  std::size_t end = text.find('\n', next_);
  if (end == std::string_view::npos) end = text.size();
  ++line_;
  Split(text.substr(next_, end - next_));
  next_ = end + 1;
}

void TextReader::Split(std::string_view line) {
  const std::size_t comment = line.find('#');
  if (comment != std::string_view::npos) {
    std::string_view note = line.substr(comment);
    if (note.starts_with(kNotePrefix)) {
      note.remove_prefix(kNotePrefix.size());
      while (!note.empty() && IsBlank(note.back())) note.remove_suffix(1);
      notes_.emplace_back(note);
    }
    line = line.substr(0, comment);
  }
  std::size_t i = 0;
  while (i < line.size()) {
    while (i < line.size() && IsBlank(line[i])) ++i;
    const std::size_t begin = i;
    while (i < line.size() && !IsBlank(line[i])) ++i;
    if (i > begin) tokens_.push_back(line.substr(begin, i - begin));
  }
}

std::string_view TextReader::RestOfLine(std::size_t i) const {
  const std::string_view text = *text_;
  const auto begin = static_cast<std::size_t>(tokens_[i].data() + tokens_[i].size() - text.data());
  std::string_view rest = text.substr(begin, text.find('\n', begin) - begin);
  while (!rest.empty() && IsBlank(rest.front())) rest.remove_prefix(1);
  while (!rest.empty() && IsBlank(rest.back())) rest.remove_suffix(1);
  return rest;
}

absl::Status TextReader::ErrorAt(std::string_view name, int line, std::string_view message) {
  // Line 1 before the first line, as for an empty file: missing content should begin there.
  return absl::InvalidArgumentError(Concat(name, ":", std::max(line, 1), ": ", message));
}

absl::Status TextReader::Error(std::string_view message) const {
  return ErrorAt(name_, line(), message);
}

absl::StatusOr<double> TextReader::Double(std::size_t i, std::string_view what) const {
  if (i >= size()) return Error(Concat(what, " is missing"));
  double value = 0;
  if (!ParseDouble(token(i), &value)) {
    return Error(
        Concat(what, " is not a finite number within a double's range: ", Quoted(token(i))));
  }
  return value;
}

absl::StatusOr<std::uint64_t> TextReader::Uint64(std::size_t i, std::string_view what) const {
  if (i >= size()) return Error(Concat(what, " is missing"));
  std::uint64_t value = 0;
  if (!ParseUint64(token(i), &value)) {
    return Error(Concat(what, " is not a whole number from 0 to 2^64 - 1: ", Quoted(token(i))));
  }
  return value;
}

}  // namespace dynmesh::io
