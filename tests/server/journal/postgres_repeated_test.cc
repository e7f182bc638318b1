// Calls that are repeated when their answer is lost: each answer of each call is cut once.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/server/journal/postgres_proxy.h"
#include "tests/server/journal/told.h"

namespace dynmesh::server {
namespace {

using Cut = PostgresProxy::Cut;
using Entry = Journal::Entry;

class PostgresRepeatedTest : public PostgresTest, public ::testing::WithParamInterface<Cut> {
 protected:
  // Calls `call` with a number, from 0 on, of answers or questions that pass before the cut, until
  // there is nothing left to cut.
  template <typename Call>
  void CutEach(Call call) {
    int before = -1;
    for (int skipped = 0; before != proxy_.cuts() && !HasFailure(); ++skipped) {
      SCOPED_TRACE(absl::StrCat("after ", skipped));
      before = proxy_.cuts();
      // With connections of its own: nothing is prepared.
      journal_ = Open({.transaction_bytes = 10}, proxy_.folder());
      ASSERT_NE(journal_, nullptr);
      call(skipped);
    }
    EXPECT_GE(proxy_.cuts(), 2);
  }
  void CutAfter(int skipped) { proxy_.CutNext(GetParam(), nullptr, skipped); }

  PostgresProxy proxy_{server_.SocketFile()};
  JournalPtr journal_;
};

TEST_P(PostgresRepeatedTest, AMeshIsMadeAndDeletedOnce) {
  CutEach([this](int skipped) {
    const std::string id = absl::StrCat("m", skipped);
    CutAfter(skipped);
    const auto key = journal_->Create(id, "about");
    proxy_.CutNext(Cut::kNone);
    ASSERT_TRUE(key.ok()) << key.status();
    EXPECT_TRUE(absl::IsAlreadyExists(journal_->Create(id, "").status()));
    EXPECT_TRUE(journal_->Append(*key, Entry{1, "x"}, std::nullopt).ok());
    EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.meshes"), "1");
    CutAfter(skipped);
    const absl::Status deleted = journal_->Delete(*key);
    proxy_.CutNext(Cut::kNone);
    EXPECT_TRUE(deleted.ok()) << deleted;
    EXPECT_TRUE(absl::IsNotFound(journal_->Delete(*key)));
    EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.meshes"), "0");
  });
}

TEST_P(PostgresRepeatedTest, AClaimIsRepeated) {
  const JournalPtr other = Open();
  const Journal::Key key = *other->Create("m", "");
  std::uint64_t revision = 0;
  CutEach([&](int skipped) {
    CutAfter(skipped);
    const absl::Status claimed = journal_->Claim(key);
    ASSERT_TRUE(claimed.ok()) << claimed;
    proxy_.CutNext(Cut::kNone);
    EXPECT_TRUE(journal_->Append(key, Entry{++revision, "x"}, std::nullopt).ok());
  });
}

// A snapshot that fails is tried again later, and no reader sees a part of it.
TEST_P(PostgresRepeatedTest, ASnapshotIsWrittenWholeOrNotAtAll) {
  const std::string parts[] = {"part-zero", "part-one", "part-two"};
  int failed = 0;
  CutEach([&](int skipped) {
    const Journal::Key key = *journal_->Create(absl::StrCat("m", skipped), "");
    ASSERT_TRUE(journal_->Append(key, {{1, "x"}, {2, "y"}}, std::vector<Journal::Request>()).ok());
    CutAfter(skipped);
    const absl::Status status = journal_->Compact(key, 2, {parts[0], parts[1], parts[2]});
    proxy_.CutNext(Cut::kNone);
    failed += !status.ok();
    EXPECT_TRUE(status.ok() || absl::IsUnavailable(status)) << status;
    const std::string after = "@2:part-zero @2:part-one @2:part-two ";
    const std::string told = Told(*journal_, key);
    EXPECT_TRUE(told == after || (!status.ok() && told == "1:x 2:y ")) << told;
    EXPECT_TRUE(journal_->Append(key, Entry{3, "z"}, std::nullopt).ok());
    ASSERT_TRUE(journal_->Compact(key, 3, {"s"}).ok());
    EXPECT_EQ(Told(*journal_, key), "@3:s ");
  });
  EXPECT_GT(failed, 5);
}

// A mesh of another journal: what is written twice is there once.
TEST_P(PostgresRepeatedTest, AnImportIsRepeated) {
  CutEach([this](int skipped) {
    const std::string id = absl::StrCat("m", skipped);
    CutAfter(skipped);
    const auto key = journal_->NewKey();
    ASSERT_TRUE(key.ok()) << key.status();
    ASSERT_TRUE(journal_->WriteUnseen(*key, {{2, 0, "p"}, {2, 1, "q"}}, {{3, "a"}}).ok());
    ASSERT_TRUE(journal_->WriteUnseen(*key, {}, {{4, "b"}, {5, "c"}}).ok());
    const absl::Status made =
        journal_->Publish(*key, {id, "about", 5, {{2, 2, 2, 3}}, {{"r", "x"}, {"s", "y"}}});
    proxy_.CutNext(Cut::kNone);
    ASSERT_TRUE(made.ok()) << made;
    EXPECT_EQ(Told(*journal_, *key), "?r=x ?s=y @2:p @2:q 3:a 4:b 5:c ");
    ASSERT_TRUE(journal_->Claim(*key).ok());
    EXPECT_TRUE(journal_->Append(*key, Entry{6, "d"}, std::nullopt).ok());
  });
}

INSTANTIATE_TEST_SUITE_P(Cuts, PostgresRepeatedTest,
                         ::testing::Values(Cut::kAnswer, Cut::kQuestion));

}  // namespace
}  // namespace dynmesh::server
