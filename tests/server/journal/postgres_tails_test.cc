// What followers of meshes read, and meshes that are handed over.
#include <gtest/gtest.h>

#include <future>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/support/deadline.h"

namespace dynmesh::server {
namespace {

using Entry = Journal::Entry;
using Request = Journal::Request;
using Position = SharedJournal::Position;
using Tail = SharedJournal::Tail;

constexpr std::uint64_t kEverything = std::numeric_limits<std::int64_t>::max();

class PostgresTailsTest : public PostgresTest {
 protected:
  PostgresTailsTest() {
    EXPECT_TRUE(a_->Renew("host-a:1").ok());
    EXPECT_TRUE(b_->Renew("host-b:1").ok());
  }

  JournalPtr OpenNode() {
    PostgresOptions options;
    options.lease = absl::Hours(1);
    options.history_bytes = 0;
    return Open(options);
  }
  // Revisions `from` to `to`, "e" and the number, each with a request.
  void Grow(Journal::Key mesh, std::uint64_t from, std::uint64_t to) {
    for (std::uint64_t r = from; r <= to; ++r) {
      ASSERT_TRUE(a_->Append(mesh, Entry{r, absl::StrCat("e", r)},
                             Request{absl::StrCat("id", r), absl::StrCat("answer", r)})
                      .ok());
    }
  }
  Tail Read(const Position& position) {
    const auto tails = b_->ReadTails({position});
    EXPECT_TRUE(tails.ok()) << tails.status();
    return tails.ok() && tails->size() == 1 ? tails->front() : Tail();
  }
  // "1:e1 2:e2 | id1:answer1"
  static std::string Text(const Tail& tail) {
    std::string text;
    for (const Entry& e : tail.entries) absl::StrAppend(&text, e.revision, ":", e.data, " ");
    absl::StrAppend(&text, "|");
    for (const Request& r : tail.requests) absl::StrAppend(&text, " ", r.id, ":", r.answer);
    return text;
  }

  const JournalPtr a_ = OpenNode(), b_ = OpenNode();
  const Journal::Key m_ = *a_->Create("m", "");
};

TEST_F(PostgresTailsTest, ATailIsWhatFollows) {
  Grow(m_, 1, 4);
  EXPECT_EQ(Text(Read({m_, 0, 0})),
            "1:e1 2:e2 3:e3 4:e4 | id1:answer1 id2:answer2 id3:answer3 id4:answer4");
  const Tail tail = Read({m_, 2, 3});
  EXPECT_EQ(Text(tail), "3:e3 4:e4 | id4:answer4");
  EXPECT_TRUE(tail.exists);
  EXPECT_EQ(tail.damage, absl::OkStatus());
  EXPECT_EQ(tail.head, 4u);
  EXPECT_EQ(tail.answers, 4);
  EXPECT_EQ(tail.snapshot, 0u);
  EXPECT_EQ(tail.address, "host-a:1");
  EXPECT_EQ(tail.epoch, 1);
  EXPECT_FALSE(tail.is_mine);
  EXPECT_FALSE(tail.is_free);
  EXPECT_EQ(Text(Read({m_, 4, 4})), "|");
  EXPECT_EQ(Text(Read({m_, kEverything, INT64_MAX})), "|");
  EXPECT_EQ(Read({m_, kEverything, INT64_MAX}).answers, 4);
}

TEST_F(PostgresTailsTest, OneReadingHasAllMeshes) {
  const Journal::Key n = *a_->Create("n", ""), gone = *a_->Create("o", "");
  Grow(m_, 1, 2);
  Grow(n, 1, 3);
  ASSERT_TRUE(a_->Delete(gone).ok());
  const auto tails = b_->ReadTails({{n, 2, 2}, {gone, 0, 0}, {m_, 0, 0}});
  ASSERT_TRUE(tails.ok()) << tails.status();
  ASSERT_EQ(tails->size(), 3u);
  EXPECT_EQ((*tails)[0].mesh, m_);
  EXPECT_EQ(Text((*tails)[0]), "1:e1 2:e2 | id1:answer1 id2:answer2");
  EXPECT_EQ(Text((*tails)[1]), "3:e3 | id3:answer3");
  EXPECT_FALSE((*tails)[2].exists);
}

TEST_F(PostgresTailsTest, LargeEntriesComeInSeveralReadings) {
  const std::string large(3 << 20, 'x');
  for (std::uint64_t r = 1; r <= 4; ++r) {
    ASSERT_TRUE(a_->Append(m_, Entry{r, large}, std::nullopt).ok());
  }
  Tail tail = Read({m_, 0, 0});
  EXPECT_EQ(tail.entries.size(), 2u);
  EXPECT_EQ(tail.head, 4u);
  tail = Read({m_, 2, 0});
  EXPECT_EQ(tail.entries.size(), 2u);
  EXPECT_EQ(tail.entries.back().revision, 4u);
  EXPECT_EQ(tail.damage, absl::OkStatus());
}

TEST_F(PostgresTailsTest, ASnapshotIsToldAndWhatItDroppedIsOutOfRange) {
  Grow(m_, 1, 3);
  ASSERT_TRUE(a_->Compact(m_, 3, {"snapshot"}).ok());
  Tail tail = Read({m_, 3, 3});
  EXPECT_EQ(tail.snapshot, 3u);
  EXPECT_EQ(tail.snapshot_bytes, 8u);
  EXPECT_EQ(tail.damage, absl::OkStatus());
  EXPECT_EQ(Text(Read({m_, 1, 3})), "2:e2 3:e3 |") << "the generation before is kept";
  Grow(m_, 4, 5);
  ASSERT_TRUE(a_->Compact(m_, 5, {"snapshot"}).ok());
  Grow(m_, 6, 6);
  tail = Read({m_, 1, 6});
  EXPECT_TRUE(absl::IsOutOfRange(tail.damage)) << tail.damage;
  EXPECT_EQ(Text(Read({m_, 4, 6})), "5:e5 6:e6 |");
  // Nothing behind it is there either.
  Sql("DELETE FROM dynmesh.entries");
  EXPECT_TRUE(absl::IsOutOfRange(Read({m_, 5, 6}).damage));
}

TEST_F(PostgresTailsTest, ADamagedRowIsTold) {
  Grow(m_, 1, 3);
  Sql("UPDATE dynmesh.entries SET data = 'other' WHERE revision = 2");
  const Tail tail = Read({m_, 0, 3});
  EXPECT_TRUE(absl::IsDataLoss(tail.damage)) << tail.damage;
  EXPECT_EQ(Text(tail), "1:e1 |");
  Sql("UPDATE dynmesh.requests SET answer = 'other' WHERE number = 2");
  EXPECT_TRUE(absl::IsDataLoss(Read({m_, 3, 0}).damage));
}

TEST_F(PostgresTailsTest, AMeshThatIsHandedOverIsTheNextOwners) {
  Grow(m_, 1, 2);
  const auto epoch = a_->HandOver(m_, "host-b:1");
  ASSERT_TRUE(epoch.ok()) << epoch.status();
  EXPECT_EQ(*epoch, 2);
  EXPECT_EQ(a_->EpochOf(m_), 0);
  const Tail tail = Read({m_, 2, 2});
  EXPECT_TRUE(tail.is_mine);
  EXPECT_FALSE(tail.is_free) << "no third node is to claim it";
  EXPECT_EQ(tail.epoch, 2);
  EXPECT_EQ(OutcomeOf(a_->Append(m_, Entry{3, "x"}, std::nullopt)), AppendOutcome::kFenced);
  EXPECT_TRUE(absl::IsAborted(a_->Claim(m_)));
  EXPECT_EQ(*a_->Renew("host-a:1"), std::vector<Journal::Key>{});
  EXPECT_EQ(*b_->Renew("host-b:1"), std::vector<Journal::Key>{m_}) << "it is kept for it";
  ASSERT_TRUE(b_->Claim(m_).ok());
  ASSERT_TRUE(b_->Append(m_, Entry{3, "x"}, std::nullopt).ok());
}

TEST_F(PostgresTailsTest, AMeshIsHandedOverToANodeThatRenewsAndByItsOwnerOnly) {
  EXPECT_TRUE(absl::IsFailedPrecondition(a_->HandOver(m_, "host-c:1").status()));
  EXPECT_FALSE(b_->HandOver(m_, "host-b:1").ok());
  Sql("UPDATE dynmesh.nodes SET seen = seen - interval '2 hours' WHERE address = 'host-b:1'");
  EXPECT_TRUE(absl::IsFailedPrecondition(a_->HandOver(m_, "host-b:1").status()));
  EXPECT_TRUE(a_->Append(m_, Entry{1, "x"}, std::nullopt).ok()) << "it is still its owner's";
  // A node that started again at its address is another one.
  const JournalPtr again = OpenNode();
  ASSERT_TRUE(again->Renew("host-b:1").ok());
  ASSERT_TRUE(a_->HandOver(m_, "host-b:1").ok());
  EXPECT_TRUE(again->Locate("m")->is_mine);
  EXPECT_FALSE(b_->Locate("m")->is_mine);
}

TEST_F(PostgresTailsTest, NodesThatFollowAMeshAreToldWhileTheyAreLive) {
  using Addresses = std::vector<std::string>;
  const JournalPtr c = OpenNode();
  ASSERT_TRUE(c->Renew("host-c:1").ok());
  EXPECT_EQ(a_->Locate("m")->followers, Addresses{});
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(c->SetFollows(m_, true).ok());
    ASSERT_TRUE(b_->SetFollows(m_, true).ok());
    EXPECT_EQ(a_->Locate("m")->followers, (Addresses{"host-b:1", "host-c:1"}));
  }
  ASSERT_TRUE(c->SetFollows(m_, false).ok());
  EXPECT_EQ(a_->Locate("m")->followers, Addresses{"host-b:1"});
  Sql("UPDATE dynmesh.nodes SET seen = seen - interval '2 hours' WHERE address = 'host-b:1'");
  EXPECT_EQ(a_->Locate("m")->followers, Addresses{});
  ASSERT_TRUE(b_->Renew("host-b:1").ok());
  EXPECT_EQ(a_->Locate("m")->followers, Addresses{"host-b:1"});
  ASSERT_TRUE(b_->GiveUp().ok());
  EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.followers"), "0");
  // Those of a node that is forgotten are forgotten, too.
  ASSERT_TRUE(c->SetFollows(m_, true).ok());
  Sql("UPDATE dynmesh.nodes SET seen = seen - interval '25 hours' WHERE address = 'host-c:1'");
  ASSERT_TRUE(a_->Renew("host-a:1").ok());
  EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.followers"), "0");
}

TEST_F(PostgresTailsTest, AnOwnerAsksNodesToFollow) {
  using Ids = std::vector<std::string>;
  const JournalPtr c = OpenNode();
  ASSERT_TRUE(c->Renew("host-c:1").ok());
  const Journal::Key n = *a_->Create("n", "");
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(a_->AskToFollow({{m_, {"host-b:1", "host-c:1"}}, {n, {"host-b:1"}}}).ok());
    EXPECT_EQ(*b_->AskedToFollow(), (Ids{"m", "n"}));
    EXPECT_EQ(*c->AskedToFollow(), Ids{"m"});
    EXPECT_EQ(*a_->AskedToFollow(), Ids{});
  }
  EXPECT_EQ(a_->Locate("m")->followers, Ids{}) << "none of them does yet";
  ASSERT_TRUE(b_->SetFollows(m_, true).ok());
  EXPECT_EQ(a_->Locate("m")->followers, Ids{"host-b:1"});
  EXPECT_EQ(*b_->AskedToFollow(), (Ids{"m", "n"}));
  // Others are asked, and nothing is asked for the other mesh.
  ASSERT_TRUE(a_->AskToFollow({{m_, {"host-c:1"}}}).ok());
  EXPECT_EQ(*b_->AskedToFollow(), Ids{"n"});
  EXPECT_EQ(*c->AskedToFollow(), Ids{"m"});
  EXPECT_EQ(a_->Locate("m")->followers, Ids{"host-b:1"}) << "it still follows";
  ASSERT_TRUE(a_->AskToFollow({{m_, {"host-b:1"}}}).ok());
  EXPECT_EQ(a_->Locate("m")->followers, Ids{"host-b:1"});
  ASSERT_TRUE(b_->SetFollows(m_, false).ok());
  EXPECT_EQ(*b_->AskedToFollow(), Ids{"n"});
  // Not what it has itself, nor what was deleted.
  ASSERT_TRUE(a_->AskToFollow({{m_, {"host-b:1"}}}).ok());
  ASSERT_TRUE(a_->HandOver(m_, "host-b:1").ok());
  EXPECT_EQ(*b_->AskedToFollow(), Ids{"n"});
  ASSERT_TRUE(a_->Delete(n).ok());
  EXPECT_EQ(*b_->AskedToFollow(), Ids{});
  EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.followers WHERE mesh <> " + absl::StrCat(m_)), "0");
  ASSERT_TRUE(a_->AskToFollow({{m_, {"host-x:1"}}}).ok()) << "there is no such node";
  ASSERT_TRUE(a_->AskToFollow({{m_, {}}}).ok());
  EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.followers WHERE asked"), "0");
}

// With a standby that does not exist no other commit ends.
TEST_F(PostgresTailsTest, WhatIsSaidOfFollowersWaitsForNoStandby) {
  const auto set = [this](const std::string& standby) {
    Sql("ALTER SYSTEM SET synchronous_standby_names = '" + standby + "'");
    Sql("SELECT pg_reload_conf()");
    test::WaitUntil("the setting",
                    [&] { return Sql("SHOW synchronous_standby_names") == standby; });
  };
  set("none");
  std::promise<absl::Status> done;
  std::thread caller([&] {
    absl::Status status = b_->SetFollows(m_, true);
    status.Update(a_->AskToFollow({{m_, {"host-b:1"}}}));
    status.Update(a_->AskToFollow({{m_, {}}}));
    status.Update(b_->AskedToFollow().status());
    status.Update(b_->SetFollows(m_, false));
    done.set_value(status);
  });
  std::future<absl::Status> end = done.get_future();
  const bool ended = end.wait_for(test::kPatience) == std::future_status::ready;
  set("");
  caller.join();
  EXPECT_TRUE(ended);
  EXPECT_EQ(end.get(), absl::OkStatus());
}

}  // namespace
}  // namespace dynmesh::server
