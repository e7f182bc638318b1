#include "server/access/file_stamp.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "absl/strings/str_cat.h"

namespace dynmesh::server {
namespace {

constexpr std::size_t kMostBytes = 1 << 20;

}  // namespace

FileStamp StampOf(const std::string& path) {
  struct stat s {};
  if (stat(path.c_str(), &s) != 0) return {};
  return {std::int64_t{s.st_mtim.tv_sec} * 1'000'000'000 + s.st_mtim.tv_nsec,
          static_cast<std::uint64_t>(s.st_size), s.st_ino};
}

absl::StatusOr<std::string> ReadSmallFile(const char* flag, const std::string& path) {
  const auto bad = [&](absl::string_view why) {
    return absl::InvalidArgumentError(absl::StrCat(flag, ": ", path, ": ", why));
  };
  struct stat s {};
  if (stat(path.c_str(), &s) != 0) return bad(std::strerror(errno));
  if (!S_ISREG(s.st_mode)) return bad("is not a file");
  std::ifstream in(path, std::ios::binary);
  if (!in) return bad(std::strerror(errno));
  std::string text(kMostBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (in.bad()) return bad("cannot be read");
  if (text.size() > kMostBytes) return bad("has more than 1 MiB");
  return text;
}

}  // namespace dynmesh::server
