// A small journal, its files as bytes to be damaged, and what was acknowledged of its meshes.
#ifndef DYNMESH_TESTS_SERVER_JOURNAL_DAMAGE_FIXTURE_H_
#define DYNMESH_TESTS_SERVER_JOURNAL_DAMAGE_FIXTURE_H_

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "server/journal/heads_file.h"
#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/told.h"

namespace dynmesh::server {

inline constexpr char kDatabase[] = "journal.sqlite", kLog[] = "journal.sqlite-wal";
inline constexpr const char* kFiles[] = {kDatabase, kLog, HeadsFile::kFileName};

// In memory if there is such a place: tens of thousands of journals are opened.
class QuickFolder {
 public:
  QuickFolder() {
    std::string pattern =
        (std::filesystem::exists("/dev/shm") ? "/dev/shm"
                                             : std::filesystem::temp_directory_path().string()) +
        "/dynmesh-test-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) std::abort();
    path_ = pattern;
  }
  ~QuickFolder() { std::filesystem::remove_all(path_); }
  QuickFolder(const QuickFolder&) = delete;
  QuickFolder& operator=(const QuickFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

// The files of a folder, as they are at a moment.
using Files = std::map<std::string, std::string>;

inline std::string ReadFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
inline Files ReadFiles(const std::string& folder) {
  Files files;
  for (const char* name : kFiles) {
    if (std::filesystem::exists(folder + "/" + name)) files[name] = ReadFile(folder + "/" + name);
  }
  return files;
}
inline void WriteFiles(const Files& files, const std::string& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    std::filesystem::remove_all(entry.path());
  for (const auto& [name, bytes] : files) {
    std::ofstream(folder + "/" + name, std::ios::binary) << bytes;
  }
}

// What was acknowledged of a mesh.
struct Known {
  Journal::Key key = 0;
  std::string told;
};
using Truth = std::map<std::string, Known>;

class DamageTest : public ::testing::Test {
 protected:
  DamageTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }

  absl::Status Open(const std::vector<std::string>& accept = {}) {
    journal_.reset();
    SqliteJournal::Options options;
    options.accept_loss = accept;
    auto opened = SqliteJournal::Open(folder_.path(), options);
    if (opened.ok()) journal_ = *std::move(opened);
    return opened.status();
  }
  // Small pages make a small log.
  void OpenFresh() {
    {
      auto db = *sqlite::Connection::Open(folder_.path() + "/" + kDatabase, nullptr);
      ASSERT_TRUE(db.Run("PRAGMA page_size=512; VACUUM").ok());
    }
    ASSERT_TRUE(Open().ok());
  }
  void Create(const std::string& id) {
    const auto key = journal_->Create(id, "about " + id);
    ASSERT_TRUE(key.ok()) << key.status();
    truth_[id].key = *key;
    Remember(id);
  }
  void Append(const std::string& id, std::uint64_t revision, const std::string& request = "") {
    std::optional<Journal::Request> asked;
    if (!request.empty()) asked = {request, "A"};
    const absl::Status s = journal_->Append(
        truth_[id].key, Journal::Entry{revision, absl::StrCat(id, "-", revision)}, asked);
    ASSERT_TRUE(s.ok()) << s;
    Remember(id);
  }
  void Remember(const std::string& id) { truth_[id].told = Told(*journal_, truth_[id].key); }
  // Three meshes, the last commit is of c.
  void Fill() {
    for (const char* id : {"a", "b", "c"}) Create(id);
    Append("a", 1);
    Append("b", 1, "r1");
    Append("a", 2, "r1");
    Append("c", 1);
  }
  // As a crash leaves them.
  Files Snap() const { return ReadFiles(folder_.path()); }

  // The meshes reported with a loss; all others must be intact.
  std::vector<std::string> Named() {
    std::vector<std::string> named;
    const auto meshes = journal_->List();
    EXPECT_TRUE(meshes.ok()) << meshes.status();
    if (!meshes.ok()) return named;
    std::map<std::string, Journal::Mesh> by_id;
    for (const Journal::Mesh& mesh : *meshes) by_id[mesh.id] = mesh;
    for (const auto& [id, known] : truth_) {
      const auto it = by_id.find(id);
      if (it == by_id.end()) {
        ADD_FAILURE() << id << " is gone in silence";
      } else if (!it->second.damage.ok() || !it->second.loss.ok()) {
        named.push_back(id);
        const absl::Status s = journal_->Append(known.key, Journal::Entry{99, "x"}, std::nullopt);
        EXPECT_FALSE(s.ok());
      } else {
        EXPECT_EQ(Told(*journal_, known.key), known.told) << id;
      }
    }
    return named;
  }
  absl::Status LossOf(const std::string& id) {
    const auto meshes = journal_->List();
    for (const Journal::Mesh& mesh : *meshes) {
      if (mesh.id == id) return mesh.damage.ok() ? mesh.loss : mesh.damage;
    }
    return absl::NotFoundError(id);
  }

  QuickFolder folder_;
  std::unique_ptr<SqliteJournal> journal_;
  Truth truth_;
};

using Names = std::vector<std::string>;

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_JOURNAL_DAMAGE_FIXTURE_H_
