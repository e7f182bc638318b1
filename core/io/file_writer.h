// Buffered text output that never leaves half a file: writes beside the target and
// renames when all is on disk. Numbers are the shortest that read back bit for bit.
#ifndef DYNMESH_CORE_IO_FILE_WRITER_H_
#define DYNMESH_CORE_IO_FILE_WRITER_H_

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

// Thread-compatible. Errors stick and come out of Close.
class FileWriter {
 public:
  // Opens path. What is no regular file (a pipe, /dev/stdout) is written directly.
  explicit FileWriter(std::string path);
  ~FileWriter();  // without Close: the target is as it was before
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  FileWriter& operator<<(std::string_view text) {
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

  // All is written out, the target still as before. To be called on each of several
  // files that belong together before Close on any. Nothing may be written after it.
  absl::Status Finish();

  // Puts the file in place. UNAVAILABLE, naming the path, if anything went wrong.
  absl::Status Close();

 private:
  static constexpr std::size_t kFlushAt = std::size_t{1} << 16;
  void Flush();
  void Fail(std::string_view what);
  void Discard();

  std::string path_;
  std::string partial_;  // where it is written; empty: straight to path_
  std::FILE* file_ = nullptr;
  std::string buffer_;
  absl::Status status_;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_FILE_WRITER_H_
