// Several journals with one database: at most one of them writes to a mesh.
#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/journal/postgres_generations.h"
#include "server/journal/postgres_session.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/server/journal/told.h"
#include "tests/support/deadline.h"

namespace dynmesh::server {
namespace {

using Entry = Journal::Entry;
using Request = Journal::Request;

class PostgresFencingTest : public PostgresTest {
 protected:
  AppendOutcome Append(Journal& journal, std::uint64_t revision, const std::string& data) {
    return OutcomeOf(journal.Append(key_, Entry{revision, data}, std::nullopt));
  }

  const JournalPtr a_ = Open(), b_ = Open();
  const Journal::Key key_ = *a_->Create("m", "");
};

TEST_F(PostgresFencingTest, OnlyTheLastThatClaimedAMeshWrites) {
  EXPECT_EQ(Append(*a_, 1, "a"), AppendOutcome::kAppended);
  EXPECT_EQ(Append(*b_, 2, "b"), AppendOutcome::kFenced) << "it never claimed the mesh";
  ASSERT_TRUE(b_->Claim(key_).ok());
  EXPECT_EQ(Append(*b_, 2, "b"), AppendOutcome::kAppended);
  EXPECT_EQ(Append(*a_, 2, "x"), AppendOutcome::kFenced);
  EXPECT_EQ(Append(*a_, 3, "x"), AppendOutcome::kFenced);
  EXPECT_EQ(OutcomeOf(a_->Append(key_, {}, std::vector<Request>{{"r", ""}})),
            AppendOutcome::kFenced);
  EXPECT_TRUE(absl::IsAborted(a_->Compact(key_, 2, {"p"})));
  EXPECT_EQ(Told(*a_, key_), "1:a 2:b ") << "all can read";
  ASSERT_TRUE(a_->Claim(key_).ok());
  EXPECT_EQ(Append(*a_, 3, "c"), AppendOutcome::kAppended);
  EXPECT_EQ(Append(*b_, 3, "y"), AppendOutcome::kFenced);
  EXPECT_EQ(Told(*b_, key_), "1:a 2:b 3:c ");
  EXPECT_EQ(Sql("SELECT epoch FROM dynmesh.meshes"), "3");
}

// A revision that fits is not enough: the earlier owner did not see the claim.
TEST_F(PostgresFencingTest, AnEarlierOwnerIsFencedEvenIfItsRevisionFits) {
  ASSERT_TRUE(b_->Claim(key_).ok());
  const absl::Status status = a_->Append(key_, Entry{1, "x"}, std::nullopt);
  EXPECT_EQ(OutcomeOf(status), AppendOutcome::kFenced);
  EXPECT_TRUE(absl::StrContains(status.message(), "its epoch is 2")) << status;
  EXPECT_EQ(Told(*b_, key_), "");
}

TEST_F(PostgresFencingTest, AMeshThatAnotherDeletedIsNotFound) {
  ASSERT_TRUE(b_->Delete(key_).ok());
  EXPECT_TRUE(absl::IsNotFound(a_->Append(key_, Entry{1, "x"}, std::nullopt)));
  EXPECT_TRUE(absl::IsNotFound(a_->Claim(key_)));
  EXPECT_TRUE(absl::IsNotFound(a_->Compact(key_, 0, {"x"})));
}

// A snapshot that another owner is writing has no generation yet, as a leftover.
TEST_F(PostgresFencingTest, AnEarlierOwnerSweepsNothingOfItsSuccessor) {
  ASSERT_EQ(Append(*a_, 1, "a"), AppendOutcome::kAppended);
  ASSERT_TRUE(b_->Claim(key_).ok());
  auto session = *postgres::Session::Connect(
      absl::StrCat("host=", server_.folder(), " user=postgres dbname=", database_));
  constexpr std::int64_t kEarlier = 1, kPresent = 2;  // epochs
  ASSERT_TRUE(postgres::WriteParts(*session, key_, kPresent, 1, {"p", "q"}, 0, 100).ok());
  EXPECT_FALSE(a_->Sweep(key_));
  auto other = *postgres::Session::Connect(
      absl::StrCat("host=", server_.folder(), " user=postgres dbname=", database_));
  EXPECT_TRUE(
      absl::IsAborted(postgres::WriteParts(*other, key_, kEarlier, 1, {"x", "y"}, 0, 9).status()));
  EXPECT_TRUE(absl::IsAborted(postgres::SwitchOver(*other, key_, kEarlier, 1, {"x", "y"}, 0)));
  other.reset();
  EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.snapshots"), "2");
  // Parts of another content, as a former owner's: no snapshot.
  EXPECT_TRUE(
      absl::IsUnavailable(postgres::SwitchOver(*session, key_, kPresent, 1, {"p", "other"}, 0)));
  session.reset();  // with its transaction
  auto third = *postgres::Session::Connect(
      absl::StrCat("host=", server_.folder(), " user=postgres dbname=", database_));
  ASSERT_TRUE(postgres::SwitchOver(*third, key_, kPresent, 1, {"p", "q"}, 0).ok());
  EXPECT_EQ(Told(*b_, key_), "@1:p @1:q ");
}

// Part of a snapshot takes long to write: batches are appended and the mesh is claimed meanwhile.
TEST_F(PostgresFencingTest, AppendsAndClaimsDoNotWaitForAPartOfASnapshot) {
  ASSERT_EQ(Append(*a_, 1, "a"), AppendOutcome::kAppended);
  const auto connect = [this] {
    return *postgres::Session::Connect(
        absl::StrCat("host=", server_.folder(), " user=postgres dbname=", database_));
  };
  auto writing = connect();
  constexpr std::int64_t kEpoch = 1;
  ASSERT_TRUE(writing->Execute("BEGIN").status.ok());
  ASSERT_TRUE(postgres::WriteParts(*writing, key_, kEpoch, 1, {"p", "q"}, 0, 100).ok());
  std::atomic<int> done{0};
  std::thread others([&] {
    EXPECT_EQ(Append(*a_, 2, "b"), AppendOutcome::kAppended);
    ++done;
    EXPECT_TRUE(b_->Claim(key_).ok());
    ++done;
    EXPECT_EQ(Append(*b_, 3, "c"), AppendOutcome::kAppended);
    ++done;
  });
  try {
    test::WaitUntil("an append and a claim", [&] { return done == 3; });
  } catch (const std::runtime_error& error) {
    ADD_FAILURE() << error.what() << ", after " << done;
  }
  // The former owner's parts are there, and are no snapshot of its successor.
  EXPECT_TRUE(writing->Execute("COMMIT").status.ok());
  others.join();
  EXPECT_TRUE(absl::IsAborted(postgres::SwitchOver(*writing, key_, kEpoch, 1, {"p", "q"}, 0)));
  ASSERT_TRUE(b_->Compact(key_, 2, {"r"}).ok());
  EXPECT_EQ(Told(*b_, key_), "@2:r 3:c ");
  EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.snapshots"), "1");
}

// Owners that take the mesh from each other all the time, until enough was written in between.
TEST_F(PostgresFencingTest, OwnersThatTakeTurnsWriteEachRevisionOnce) {
  constexpr int kEach = 60;
  std::atomic<int> appended{0};
  std::vector<std::thread> owners;
  for (Journal* const journal :
       {static_cast<Journal*>(a_.get()), static_cast<Journal*>(b_.get())}) {
    owners.emplace_back([&, journal] {
      const std::string name = journal == a_.get() ? "a" : "b";
      for (int i = 0; i < kEach || appended <= kEach; ++i) {
        ASSERT_TRUE(journal->Claim(key_).ok());
        std::uint64_t head = 0;
        Journal::Visitor visitor;
        visitor.snapshot = [](std::uint64_t, const std::string&) { return absl::OkStatus(); };
        visitor.entry = [&head](const Entry& entry) {
          head = entry.revision;
          return absl::OkStatus();
        };
        ASSERT_TRUE(journal->Read(key_, visitor).ok());
        while (Append(*journal, ++head, absl::StrCat(name, i)) == AppendOutcome::kAppended) {
          if (++appended % 7 == 0) break;
        }
      }
    });
  }
  for (std::thread& owner : owners) owner.join();
  EXPECT_GT(appended, kEach);
  EXPECT_EQ(
      Sql("SELECT count(*) || '=' || head FROM dynmesh.entries, dynmesh.meshes GROUP BY head"),
      absl::StrCat(appended.load(), "=", appended.load()));
}

}  // namespace
}  // namespace dynmesh::server
