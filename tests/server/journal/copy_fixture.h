// Journals with meshes of all shapes, and whether two journals have the same: for copies.
#ifndef DYNMESH_TESTS_SERVER_JOURNAL_COPY_FIXTURE_H_
#define DYNMESH_TESTS_SERVER_JOURNAL_COPY_FIXTURE_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "proto/codec/journal_codec.h"
#include "server/journal/journal_copy.h"
#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/told.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server {

inline std::unique_ptr<SqliteJournal> OpenSqlite(const std::string& folder,
                                                 const SqliteJournal::Options& options = {}) {
  auto opened = SqliteJournal::Open(folder, options);
  EXPECT_TRUE(opened.ok()) << opened.status();
  return opened.ok() ? *std::move(opened) : nullptr;
}

// Writes meshes as a server does, with made-up hashes.
class JournalFiller {
 public:
  JournalFiller(Journal& journal, std::uint64_t seed) : journal_(journal), random_(seed) {}

  // A mesh after `batches` batches, with a snapshot after each `compacts`-th; 0: without.
  Journal::Key Fill(const std::string& id, int dimension, int batches, int compacts) {
    codec::JournalMesh made;
    made.options.dimension = dimension;
    made.request_id = "made-" + id;
    const auto key = journal_.Create(id, codec::EncodeJournalMesh(made));
    EXPECT_TRUE(key.ok()) << key.status();
    features_.clear();
    head_ = 0;
    for (int i = 1; i <= batches; ++i) {
      Batch(*key, dimension);
      if (compacts > 0 && i % compacts == 0) {
        const absl::Status status = journal_.Compact(
            *key, head_, codec::EncodeJournalSnapshot(features_, Hash(head_), dimension));
        EXPECT_TRUE(status.ok()) << status;
      }
    }
    return *key;
  }
  // A batch, with or without a request id; now and then only an answer.
  void Batch(Journal::Key key, int dimension) {
    std::optional<Journal::Entry> entry;
    std::optional<Journal::Request> request;
    const std::uint64_t before = head_;
    if (random_() % 8 != 0) {
      EditBatch edits;
      for (std::uint64_t i = 1 + random_() % 5; i > 0; --i) {
        const FeatureId id = features_.size() + 1;
        features_.push_back(Feature::Point(id, static_cast<double>(random_() % 1'000), 0.5));
        edits.push_back(Edit::Add(features_.back()));
      }
      ++head_;
      entry = {head_, codec::EncodeJournalEntry(edits, Hash(head_), dimension)};
    }
    if (!entry.has_value() || random_() % 2 == 0) {
      request = {
          absl::StrCat("request-", random_()),
          codec::EncodeJournalAnswer({random_(), random_(), before, head_, Hash(head_), {}})};
    }
    const absl::Status status = journal_.Append(key, entry, request);
    EXPECT_TRUE(status.ok()) << status;
  }

  // Meshes with and without entries, snapshots, a past that was dropped, in 2D and 3D.
  void FillAll() {
    Fill("empty", 2, 0, 0);
    Fill("entries", 2, 17, 0);
    Fill("generations", 2, 90, 7);
    Fill("at-its-snapshot", 3, 40, 10);
    Fill("one-snapshot", 3, 9, 5);
    Fill("one", 2, 1, 1);
  }

 private:
  static MeshHash Hash(std::uint64_t revision) { return {revision * 77, revision * 99}; }

  Journal& journal_;
  std::mt19937_64 random_;
  std::vector<Feature> features_;
  std::uint64_t head_ = 0;
};

// Everything that a reader sees of a mesh.
inline std::string ToldWhole(Journal& journal, const Journal::Mesh& mesh) {
  std::string text = absl::StrCat(mesh.id, " ", mesh.description, " ", mesh.entries, "\n",
                                  Told(journal, mesh.key), "\n");
  const auto oldest = journal.Oldest(mesh.key);
  EXPECT_TRUE(oldest.ok()) << oldest.status();
  for (std::uint64_t revision = 0;; ++revision) {
    const std::string past = ToldPast(journal, mesh.key, revision, revision);
    absl::StrAppend(&text, revision, " ", past, "\n");
    if (revision > *oldest && past.find("OUT_OF_RANGE") == 0) return text;
  }
}

inline std::vector<Journal::Mesh> MeshesOf(Journal& journal) {
  auto meshes = journal.List();
  EXPECT_TRUE(meshes.ok()) << meshes.status();
  return meshes.ok() ? *std::move(meshes) : std::vector<Journal::Mesh>();
}

inline std::vector<std::string> ToldAll(Journal& journal) {
  std::vector<std::string> all;
  for (const Journal::Mesh& mesh : MeshesOf(journal)) all.push_back(ToldWhole(journal, mesh));
  return all;
}

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_JOURNAL_COPY_FIXTURE_H_
