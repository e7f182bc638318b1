#include "server/journal/journal_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/journal/heads_file.h"

namespace dynmesh::server {

namespace fs = std::filesystem;
using sqlite::Statement;

// The file's header has the versions required to read and to write it: 2 for the WAL mode.
DatabaseFormat DatabaseFormatOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  char header[20] = {};
  if (!file.read(header, sizeof(header))) return DatabaseFormat::kNone;
  return header[18] == 2 || header[19] == 2 ? DatabaseFormat::kWithLog : DatabaseFormat::kWhole;
}

std::uint64_t FileSizeOf(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  return error ? 0 : size;
}

std::string OtherFilesIn(const std::string& folder) {
  std::vector<std::string> others;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename();
    if (name != "lock" && name.rfind("journal.sqlite", 0) != 0 &&
        name.rfind(HeadsFile::kFileName, 0) != 0) {
      others.push_back(name);
    }
  }
  std::sort(others.begin(), others.end());
  return absl::StrJoin(others, " ");
}

absl::Status MakeDatabaseFile(const std::string& path) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0 && errno == EEXIST) return absl::OkStatus();
  if (file < 0) {
    return absl::UnavailableError(absl::StrCat("cannot make ", path, ": ", std::strerror(errno)));
  }
  close(file);
  return absl::OkStatus();
}

std::string RandomJournalId() {
  std::random_device random;
  std::string id(HeadsFile::kIdBytes, '\0');
  for (char& c : id) c = static_cast<char>(random());
  return id;
}

absl::StatusOr<std::string> JournalIdOf(sqlite::Connection& connection) {
  Statement statement(connection, "SELECT id FROM journal");
  const bool row = statement.Step();
  if (!statement.status().ok()) return statement.status();
  const std::string found = row ? statement.Bytes(0) : std::string();
  // If the id is damaged: the same number of bytes.
  std::string id(HeadsFile::kIdBytes, '\0');
  std::copy_n(found.begin(), std::min(found.size(), id.size()), id.begin());
  return id;
}

absl::StatusOr<std::int64_t> NumberOf(sqlite::Connection& connection, const char* sql) {
  Statement statement(connection, sql);
  const bool row = statement.Step();
  if (!statement.status().ok()) return statement.status();
  return row ? statement.Integer(0) : 0;
}

}  // namespace dynmesh::server
