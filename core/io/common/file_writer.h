// Buffered text output that never leaves an incomplete file: writes to a file beside the target,
// and renames it when all is on disk. Numbers are the shortest that read back bit for bit.
#ifndef DYNMESH_CORE_IO_COMMON_FILE_WRITER_H_
#define DYNMESH_CORE_IO_COMMON_FILE_WRITER_H_

#include <charconv>
#include <concepts>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace dynmesh::io {

// The shortest decimal that reads back as the same double; "-0", "1e+300", "0.1".
std::string FormatDouble(double value);

// Thread-compatible. The first error is kept and returned by Close.
class FileWriter {
 public:
  // Opens path. Writes directly to what is not a regular file (a pipe, /dev/stdout).
  explicit FileWriter(std::string path);
  ~FileWriter();  // without Close: the target stays as it was
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  FileWriter& operator<<(std::string_view text) {
    if (text.size() >= kFlushAt) return WriteLarge(text), *this;
    buffer_.append(text);
    if (buffer_.size() >= kFlushAt) Flush();
    return *this;
  }
  FileWriter& operator<<(char c) {
    buffer_.push_back(c);
    return *this;
  }
  template <std::integral T>
  FileWriter& operator<<(T value) {
    char digits[24];
    const auto end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
    return *this << std::string_view(digits, static_cast<std::size_t>(end - digits));
  }
  FileWriter& operator<<(double value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
    return *this << std::string_view(digits, static_cast<std::size_t>(end - digits));
  }

  // Flushes all output; the target is still as before. Call it on each of several files that belong
  // together before Close on any. Do not write after it.
  absl::Status Finish();

  // Renames the file to its target. UNAVAILABLE, naming the path, on any error.
  absl::Status Close();

 private:
  static constexpr std::size_t kFlushAt = std::size_t{1} << 16;
  void Flush();
  void WriteLarge(std::string_view text);  // without a copy
  void Write(std::string_view text);
  void Fail(std::string_view what);
  void Discard();

  std::string path_;
  std::string partial_;  // the file written; empty: writes directly to path_
  std::FILE* file_ = nullptr;
  std::string buffer_;
  absl::Status status_;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_FILE_WRITER_H_
