#include "core/io/common/file_writer.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/base/text.h"

namespace dynmesh::io {

using text::Concat;

std::string FormatDouble(double value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
  return std::string(digits, end);
}

FileWriter::FileWriter(std::string path) : path_(std::move(path)) {
  std::error_code error;
  const auto kind = std::filesystem::status(path_, error).type();
  const bool renameable =
      kind == std::filesystem::file_type::not_found || kind == std::filesystem::file_type::regular;
  if (renameable) {
    // Resolves a link to the file behind it: the link stays a link.
    const auto target = std::filesystem::weakly_canonical(path_, error);
    if (!error && !target.empty()) path_ = target.string();
    partial_ = path_ + ".partial";
  }
  file_ = std::fopen(renameable ? partial_.c_str() : path_.c_str(), "wb");
  if (file_ == nullptr) {
    Fail("open for writing");
  } else {
    std::setvbuf(file_, nullptr, _IONBF, 0);  // there is a buffer here
  }
}

FileWriter::~FileWriter() {
  if (file_ != nullptr) std::fclose(file_);
  Discard();
}

void FileWriter::Fail(std::string_view what) {
  if (status_.ok()) {
    status_ = absl::UnavailableError(Concat(path_, ": cannot ", what, ": ", std::strerror(errno)));
  }
}

void FileWriter::Write(std::string_view text) {
  if (file_ != nullptr && status_.ok() && !text.empty() &&
      std::fwrite(text.data(), 1, text.size(), file_) != text.size()) {
    Fail("write");
  }
}

void FileWriter::Flush() {
  Write(buffer_);
  buffer_.clear();
}

void FileWriter::WriteLarge(std::string_view text) {
  Flush();
  Write(text);
}

absl::Status FileWriter::Finish() {
  Flush();
  if (file_ != nullptr && std::fclose(std::exchange(file_, nullptr)) != 0) Fail("write");
  if (!status_.ok()) Discard();
  return status_;
}

absl::Status FileWriter::Close() {
  if (!Finish().ok() || partial_.empty()) return status_;
  if (std::rename(partial_.c_str(), path_.c_str()) != 0) {
    Fail("put in place");
    Discard();
  }
  partial_.clear();
  return status_;
}

void FileWriter::Discard() {
  if (!partial_.empty()) std::remove(partial_.c_str());
  partial_.clear();
}

}  // namespace dynmesh::io
