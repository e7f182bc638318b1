// dynmeshd --copy-journal: meshes move from a folder to PostgreSQL and back, between servers that
// end and start, and nothing that a client sees of them changes.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/e2e/daemon.h"
#include "tests/e2e/killed_clients.h"
#include "tests/server/journal/postgres_server.h"
#include "tests/support/nightly.h"
#include "tests/support/temp_folder.h"

namespace dynmesh {
namespace {

using client::MeshClient;
using test::Daemon;
using test::TempFolder;

// What clients know of a mesh.
struct Known {
  std::vector<codec::FeaturesAt> revisions;  // of the kept past, the oldest first
  std::vector<std::pair<std::string, EditBatch>> requests;
  std::map<std::string, std::uint64_t> answers;  // revision after each
};

class CopyJournalTest : public ::testing::Test {
 protected:
  CopyJournalTest() { std::filesystem::create_directory(Folder("first")); }

  std::string Folder(const std::string& name) const { return folder_.path() + "/" + name; }
  std::string Database() const { return database_.Url("postgres"); }
  static std::vector<std::string> Flags(const std::string& place) {
    const bool is_database = absl::StartsWith(place, "postgresql://");
    // Short generations, so that there are many, and not all are kept.
    return {is_database ? "--journal" : "--data-dir",
            place,
            "--compact-bytes",
            "1500",
            "--journal-history-mib",
            "0"};
  }
  // Runs the command to its end; returns the exit code.
  int Copy(const std::string& from, const std::string& to,
           const std::vector<std::string>& more = {}) {
    std::vector<std::string> flags = {"--copy-journal", from, to};
    flags.insert(flags.end(), more.begin(), more.end());
    EXPECT_FALSE(copy_.Start(flags)) << "it serves";
    return copy_.exit_code();
  }
  std::unique_ptr<MeshClient> Connect() const {
    client::ClientOptions options;
    options.own_connection = true;
    return MeshClient::Connect(daemon_.address(), options);
  }

  // Makes meshes and edits them.
  void Work(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto client = Connect();
    for (const char* id : {"a", "b", "none"}) {
      ASSERT_TRUE(client->CreateMesh(id, MeshOptions(), absl::StrCat("make-", id)).ok());
      Known& known = known_[id];
      FeatureId last = 0;
      test::FeatureMap features;
      for (int i = 0; i < 80 && id != std::string("none"); ++i) {
        client::EditParams params;
        params.request_id = absl::StrCat(id, "-", i);
        const EditBatch batch = test::RandomBatch(features, last, random);
        const auto result = client->Apply(id, batch, params);
        ASSERT_TRUE(result.ok()) << result.status();
        test::Act(batch, features);
        known.requests.emplace_back(params.request_id, batch);
        known.answers[params.request_id] = result->diff.to_revision;
      }
    }
  }
  // Asks for the past that is kept.
  void Remember() {
    const auto client = Connect();
    for (auto& [id, known] : known_) {
      const auto now = client->GetFeatures(id);
      ASSERT_TRUE(now.ok()) << now.status();
      for (std::uint64_t revision = 0; revision <= now->revision; ++revision) {
        const auto past = client->GetFeatures(id, revision);
        if (past.ok()) known.revisions.push_back(*past);
      }
      EXPECT_EQ(known.revisions.back().hash, now->hash);
    }
    EXPECT_GT(known_["a"].revisions.size(), 2u);
    EXPECT_LT(known_["a"].revisions.size(), 81u) << "all of the past was kept";
  }
  void ExpectKnown() const {
    const auto client = Connect();
    for (const auto& [id, known] : known_) {
      SCOPED_TRACE(id);
      const auto info = client->GetMesh(id);
      ASSERT_TRUE(info.ok()) << info.status();
      EXPECT_EQ(info->revision, known.revisions.back().revision);
      EXPECT_EQ(info->hash, known.revisions.back().hash);
      for (const codec::FeaturesAt& then : known.revisions) {
        const auto now = client->GetFeatures(id, then.revision);
        ASSERT_TRUE(now.ok()) << then.revision << ": " << now.status();
        EXPECT_EQ(now->hash, then.hash);
        EXPECT_EQ(now->features, then.features);
      }
      const std::uint64_t before = known.revisions.front().revision;
      if (before > 0) {
        EXPECT_TRUE(absl::IsOutOfRange(client->GetFeatures(id, before - 1).status()));
      }
      for (const auto& [request_id, edits] : known.requests) {
        client::EditParams params;
        params.request_id = request_id;
        const auto again = client->Apply(id, edits, params);
        ASSERT_TRUE(again.ok()) << again.status();
        EXPECT_TRUE(again->replayed);
        EXPECT_EQ(again->diff.to_revision, known.answers.at(request_id));
      }
      EXPECT_EQ(client->GetMesh(id)->revision, known.revisions.back().revision);
      // The request that made the mesh is known, too.
      EXPECT_TRUE(client->CreateMesh(id, MeshOptions(), absl::StrCat("make-", id)).ok());
    }
  }
  // A server on the journal has what is known.
  void ExpectKnownAt(const std::string& place) {
    ASSERT_TRUE(daemon_.Start(Flags(place))) << daemon_.Log();
    ExpectKnown();
    EXPECT_EQ(daemon_.End(SIGTERM), 0);
  }
  void MakeSource(std::uint64_t seed) {
    ASSERT_TRUE(daemon_.Start(Flags(Folder("first")))) << daemon_.Log();
    Work(seed);
    ASSERT_FALSE(HasFatalFailure());
    ASSERT_EQ(daemon_.End(SIGTERM), 0);
    // After the edits old generations go in the background, to the end of the server at the latest.
    ASSERT_TRUE(daemon_.Start(Flags(Folder("first")))) << daemon_.Log();
    Remember();
    ASSERT_FALSE(HasFatalFailure());
    ASSERT_EQ(daemon_.End(SIGTERM), 0);
  }

  TempFolder folder_, copy_folder_;
  server::PostgresServer database_;
  Daemon daemon_{folder_.path()};
  Daemon copy_{copy_folder_.path()};
  std::map<std::string, Known> known_;
};

TEST_F(CopyJournalTest, ToADatabaseAndBackNothingChangesForClients) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  MakeSource(seed);
  ASSERT_FALSE(HasFatalFailure());
  ASSERT_EQ(Copy(Folder("first"), Database()), 0) << copy_.Log();
  EXPECT_TRUE(
      absl::StrContains(copy_.Log(), absl::StrCat("event=mesh_copied mesh=a revision=80 "
                                                  "hash=",
                                                  known_["a"].revisions.back().hash.ToHex())))
      << copy_.Log();
  ExpectKnownAt(Database());
  ASSERT_EQ(Copy(Database(), Folder("second")), 0) << copy_.Log();
  ExpectKnownAt(Folder("second"));
  ExpectKnownAt(Folder("first"));
  // Both are there: a repetition finds that they are the same.
  EXPECT_EQ(Copy(Folder("second"), Database(), {"--copy-meshes", "a,none"}), 0) << copy_.Log();
  EXPECT_TRUE(absl::StrContains(copy_.Log(), "event=copy_done copied=0 there=2")) << copy_.Log();
}

TEST_F(CopyJournalTest, KilledInTheMiddleItIsRepeatedAndGoesOn) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  std::mt19937_64 random(seed);
  MakeSource(seed);
  ASSERT_FALSE(HasFatalFailure());
  const int kills = test::IsNightly() ? 200 : 8;
  int incomplete = 0;
  for (int i = 0; i < kills; ++i) {
    const std::string database = database_.Url(database_.MakeDatabase());
    ASSERT_TRUE(copy_.Spawn({"--copy-journal", Folder("first"), database}));
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 150'000));
    if (copy_.End(i % 2 == 0 ? SIGKILL : SIGTERM) != 0) ++incomplete;
    ASSERT_EQ(Copy(Folder("first"), database), 0) << copy_.Log();
    ExpectKnownAt(database);
    ASSERT_FALSE(HasFailure()) << "kill " << i;
  }
  std::printf("%d of %d copies were ended before they were complete\n", incomplete, kills);
  EXPECT_GT(incomplete, 0);
  ExpectKnownAt(Folder("first"));
}

TEST_F(CopyJournalTest, JournalsThatAServerUsesAreRefused) {
  MakeSource(1);
  ASSERT_FALSE(HasFatalFailure());
  ASSERT_TRUE(daemon_.Start(Flags(Folder("first")))) << daemon_.Log();
  EXPECT_EQ(Copy(Folder("first"), Database()), 1);
  EXPECT_TRUE(absl::StrContains(copy_.Log(), absl::StrCat(daemon_.process()))) << copy_.Log();
  ASSERT_EQ(daemon_.End(SIGTERM), 0);
  std::vector<std::string> flags = Flags(Database());
  for (const bool shares : {false, true}) {
    if (shares) flags.insert(flags.end(), {"--node-address", "127.0.0.1"});
    ASSERT_TRUE(daemon_.Start(flags)) << daemon_.Log();
    EXPECT_EQ(Copy(Folder("first"), Database()), 1);
    EXPECT_EQ(Copy(Database(), Folder("second")), 1);
    EXPECT_TRUE(absl::StrContains(copy_.Log(), "a server uses it")) << copy_.Log();
    ASSERT_EQ(daemon_.End(SIGTERM), 0);
  }
  EXPECT_EQ(Copy(Folder("first"), Database()), 0) << copy_.Log();
}

TEST_F(CopyJournalTest, WhatIsWrongIsNamed) {
  MakeSource(2);
  ASSERT_FALSE(HasFatalFailure());
  const std::string first = Folder("first");
  const auto refused = [&](const std::vector<std::string>& flags, int code, const char* word) {
    EXPECT_FALSE(copy_.Start(flags));
    EXPECT_EQ(copy_.exit_code(), code) << copy_.Log();
    EXPECT_TRUE(absl::StrContains(copy_.Log(), word)) << word << "\n" << copy_.Log();
  };
  refused({"--copy-journal", first}, 2, "copy-journal");
  refused({"--copy-journal", first, first + "/"}, 2, "are the same");
  refused({"--copy-journal", first, ""}, 2, "has no name");
  refused({"--copy-journal", first, Database(), "--data-dir", first}, 2, "without --data-dir");
  refused({"--copy-meshes", "a"}, 2, "give --copy-journal");
  refused({"--copy-journal", first, Database(), "--copy-meshes", "a,b/c"}, 2, "b/c is no");
  refused({"--copy-journal", first, Database(), "--copy-meshes", "a,other"}, 1, "no mesh other");
  refused({"--copy-journal", Folder("nothing"), Database()}, 1, "no journal.sqlite");
  EXPECT_FALSE(std::filesystem::exists(Folder("nothing")));
  refused({"--copy-journal", database_.Url(database_.MakeDatabase()), first}, 1, "no journal of");
  refused({"--copy-journal", first, "postgresql://127.0.0.1:1/x"}, 1, "127.0.0.1");
  // Another mesh with that name.
  ASSERT_TRUE(daemon_.Start(Flags(Folder("other")))) << daemon_.Log();
  ASSERT_TRUE(Connect()->CreateMesh("b", MeshOptions()).ok());
  ASSERT_EQ(daemon_.End(SIGTERM), 0);
  refused({"--copy-journal", first, Folder("other")}, 1, "has another mesh b already");
  EXPECT_EQ(Copy(first, Folder("other"), {"--copy-meshes", "a"}), 0) << copy_.Log();
}

}  // namespace
}  // namespace dynmesh
