// Leases: when a server may claim a mesh that another one has. No test measures time: a lease is
// long, or its end is set back in the database.
#include "server/journal/postgres_leases.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/journal/postgres_target.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/support/deadline.h"

namespace dynmesh::server {
namespace {

using postgres::ClaimFree;
using postgres::FreeClaim;
using postgres::Node;
using postgres::Session;

using Entry = Journal::Entry;

constexpr absl::Duration kTtl = absl::Hours(1);

class PostgresLeasesTest : public PostgresTest {
 protected:
  PostgresLeasesTest() { EXPECT_TRUE(postgres::PrepareLeases(*session_).ok()); }

  std::unique_ptr<Session> Connect() {
    const auto target = postgres::ParseTarget(server_.Url(database_));
    auto session = Session::Connect(target->conninfo);
    EXPECT_TRUE(session.ok()) << session.status();
    return session.ok() ? *std::move(session) : nullptr;
  }
  // "epoch E", "held by NODE at ADDRESS, epoch E" or the error.
  std::string Claim(const std::string& node) { return Claim(node, key_); }
  std::string Claim(const std::string& node, std::int64_t mesh) {
    const FreeClaim claim = ClaimFree(*session_, mesh, node, kTtl);
    if (!claim.status.ok()) return std::string(absl::StatusCodeToString(claim.status.code()));
    if (!claim.held) return absl::StrCat("epoch ", claim.belief.epoch);
    EXPECT_GT(claim.holder.left, absl::ZeroDuration());
    EXPECT_LE(claim.holder.left, kTtl);
    return absl::StrCat("held by ", claim.holder.node.id, " at ", claim.holder.node.address,
                        ", epoch ", claim.holder.epoch);
  }
  std::vector<std::int64_t> Renew(const Node& node) {
    const auto renewed = postgres::RenewLeases(*session_, node, kTtl);
    EXPECT_TRUE(renewed.ok()) << renewed.status();
    return renewed.value_or(std::vector<std::int64_t>{-1});
  }
  std::string Live() {
    const auto nodes = postgres::LiveNodes(*session_, kTtl);
    EXPECT_TRUE(nodes.ok()) << nodes.status();
    std::string live;
    for (const Node& node : *nodes) absl::StrAppend(&live, node.id, "@", node.address, " ");
    return live;
  }
  void EndLeases() {
    Sql("UPDATE dynmesh.meshes SET lease_until = clock_timestamp() - interval '1 second'");
  }

  const JournalPtr journal_ = Open();
  const Journal::Key key_ = *journal_->Create("m", "");
  const std::unique_ptr<Session> session_ = Connect();
};

TEST_F(PostgresLeasesTest, AMeshWithoutALeaseIsFree) { EXPECT_EQ(Claim("a"), "epoch 2"); }

TEST_F(PostgresLeasesTest, AHeldMeshIsNotClaimedAndItsHolderIsNamed) {
  Renew({"a", "host-a:1"});
  EXPECT_EQ(Claim("a"), "epoch 2");
  EXPECT_EQ(Claim("b"), "held by a at host-a:1, epoch 2");
  EXPECT_EQ(Claim("a"), "epoch 3") << "a node can claim what it has";
  EXPECT_EQ(Claim("b"), "held by a at host-a:1, epoch 3");
}

TEST_F(PostgresLeasesTest, AMeshWhoseLeaseRanOutIsClaimedAndItsOldOwnerRenewsNothing) {
  EXPECT_EQ(Claim("a"), "epoch 2");
  EndLeases();
  EXPECT_EQ(Claim("b"), "epoch 3");
  EXPECT_EQ(Renew({"a", ""}), std::vector<std::int64_t>{});
  EXPECT_EQ(Claim("a"), "held by b at , epoch 3");
}

TEST_F(PostgresLeasesTest, ARenewalReachesAllMeshesOfItsNodeAndNoOthers) {
  const Journal::Key second = *journal_->Create("n", ""), third = *journal_->Create("o", "");
  Claim("a");
  Claim("a", second);
  Claim("b", third);
  EndLeases();
  EXPECT_EQ(Renew({"a", ""}), (std::vector<std::int64_t>{key_, second}));
  EXPECT_EQ(Claim("c"), "held by a at , epoch 2");
  EXPECT_EQ(Claim("c", second), "held by a at , epoch 2");
  EXPECT_EQ(Claim("c", third), "epoch 3");
}

TEST_F(PostgresLeasesTest, WhatWasGivenUpIsFreeAtOnceAndNotRenewed) {
  Renew({"a", "host-a:1"});
  Claim("a");
  ASSERT_TRUE(postgres::GiveUpLeases(*session_, "a").ok());
  EXPECT_EQ(Live(), "");
  EXPECT_EQ(Renew({"a", "host-a:1"}), std::vector<std::int64_t>{});
  EXPECT_EQ(Claim("b"), "epoch 3");
}

TEST_F(PostgresLeasesTest, NodesAreLiveWhileTheyRenew) {
  Renew({"b", "host-b:1"});
  Renew({"a", "host-a:1"});
  Renew({"a", "host-a:2"});
  EXPECT_EQ(Live(), "a@host-a:2 b@host-b:1 ");
  Sql("UPDATE dynmesh.nodes SET seen = seen - interval '61 minutes' WHERE id = 'a'");
  EXPECT_EQ(Live(), "b@host-b:1 ");
}

TEST_F(PostgresLeasesTest, AMeshThatDoesNotExistIsNotFound) {
  EXPECT_EQ(Claim("a", key_ + 1), "NOT_FOUND");
}

// The epoch fences the journal of a server that knows no leases, too.
TEST_F(PostgresLeasesTest, AClaimFencesTheJournalThatHadTheMesh) {
  ASSERT_TRUE(journal_->Append(key_, Entry{1, "x"}, std::nullopt).ok());
  const FreeClaim claim = ClaimFree(*session_, key_, "a", kTtl);
  ASSERT_TRUE(claim.status.ok()) << claim.status;
  EXPECT_EQ(claim.belief.head, 1);
  EXPECT_EQ(OutcomeOf(journal_->Append(key_, Entry{2, "y"}, std::nullopt)), AppendOutcome::kFenced);
}

TEST_F(PostgresLeasesTest, OfManyClaimsAtOnceOneIsGranted) {
  constexpr int kThreads = 6, kRounds = 20;
  std::vector<std::unique_ptr<Session>> sessions;
  for (int i = 0; i < kThreads; ++i) sessions.push_back(Connect());
  for (int round = 0; round < kRounds; ++round) {
    EndLeases();
    std::atomic<int> granted{0}, held{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&, i] {
        // Names are new in each round: an owner may claim what it has.
        const FreeClaim claim = ClaimFree(*sessions[i], key_, absl::StrCat(round, "-", i), kTtl);
        EXPECT_TRUE(claim.status.ok()) << claim.status;
        ++(claim.held ? held : granted);
      });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(granted, 1);
    EXPECT_EQ(held, kThreads - 1);
  }
  EXPECT_EQ(Sql("SELECT epoch FROM dynmesh.meshes"), absl::StrCat(kRounds + 1));
}

TEST_F(PostgresLeasesTest, AClaimThatWaitedForALockHasAWholeLease) {
  constexpr absl::Duration kShort = absl::Seconds(2);
  const auto other = Connect();
  ASSERT_TRUE(other->Execute("BEGIN; SELECT 1 FROM dynmesh.meshes FOR UPDATE").status.ok());
  FreeClaim claim;
  std::thread claiming([&] { claim = ClaimFree(*session_, key_, "a", kShort); });
  test::WaitUntil("a claim that waits",
                  [&] { return Sql("SELECT count(*) FROM pg_locks WHERE NOT granted") == "1"; });
  absl::SleepFor(2 * kShort);
  EXPECT_TRUE(other->Execute("COMMIT").status.ok());
  claiming.join();
  ASSERT_TRUE(claim.status.ok()) << claim.status;
  EXPECT_FALSE(claim.held);
  EXPECT_EQ(Sql("SELECT lease_until > clock_timestamp() FROM dynmesh.meshes"), "t");
  EXPECT_EQ(Sql("SELECT epoch FROM dynmesh.meshes"), absl::StrCat(claim.belief.epoch));
}

TEST_F(PostgresLeasesTest, NodesThatAreGoneForADayAreForgotten) {
  for (const char* node : {"a", "b", "c"}) Renew({node, ""});
  Sql("UPDATE dynmesh.nodes SET seen = seen - interval '25 hours' WHERE id <> 'b'");
  Renew({"b", ""});
  EXPECT_EQ(Sql("SELECT string_agg(id, ' ' ORDER BY id) FROM dynmesh.nodes"), "b");
  Renew({"c", ""});
  EXPECT_EQ(Sql("SELECT string_agg(id, ' ' ORDER BY id) FROM dynmesh.nodes"), "b c");
}

// ------------------------------------------------------------------ the journal with leases

class SharedPostgresTest : public PostgresTest {
 protected:
  JournalPtr OpenNode(absl::Duration lease = kTtl) {
    PostgresOptions options;
    options.lease = lease;
    return Open(options);
  }
  // "ADDRESS epoch REVISION", "mine ..." or "free ..."
  static std::string Text(const SharedJournal::Located& located) {
    const std::string at = located.left <= absl::ZeroDuration() ? "free"
                           : located.is_mine                    ? "mine"
                                                                : located.address;
    return absl::StrCat(at, " ", located.epoch, " ", located.revision);
  }
  static std::string Where(PostgresJournal& journal, const std::string& id) {
    const auto located = journal.Locate(id);
    return located.ok() ? Text(*located)
                        : std::string(absl::StatusCodeToString(located.status().code()));
  }
};

TEST_F(SharedPostgresTest, AJournalWithoutALeaseIsOfOneServer) {
  EXPECT_EQ(Open()->shared(), nullptr);
  const JournalPtr node = OpenNode();
  EXPECT_EQ(node->shared(), node.get());
}

TEST_F(SharedPostgresTest, AMeshIsItsMakersUntilThatOneGivesItUp) {
  const JournalPtr a = OpenNode(), b = OpenNode();
  ASSERT_TRUE(a->Renew("host-a:1").ok());
  ASSERT_TRUE(b->Renew("host-b:1").ok());
  const Journal::Key key = *a->Create("m", "description");
  EXPECT_EQ(*a->Renew("host-a:1"), std::vector<Journal::Key>{key});
  EXPECT_EQ(Where(*a, "m"), "mine 1 0");
  EXPECT_EQ(Where(*b, "m"), "host-a:1 1 0");
  EXPECT_EQ(b->Locate("m")->mesh.description, "description");
  EXPECT_EQ(b->Locate("m")->mesh.key, key);
  EXPECT_TRUE(absl::IsAborted(b->Claim(key))) << b->Claim(key);
  ASSERT_TRUE(a->Append(key, Journal::Entry{1, "x"}, std::nullopt).ok());
  ASSERT_TRUE(a->GiveUp().ok());
  EXPECT_EQ(Where(*b, "m"), "free 1 1");
  ASSERT_TRUE(b->Claim(key).ok());
  EXPECT_EQ(b->EpochOf(key), 2);
  EXPECT_EQ(Where(*b, "m"), "mine 2 1");
  EXPECT_EQ(*b->Renew("host-b:1"), std::vector<Journal::Key>{key});
  EXPECT_EQ(OutcomeOf(a->Append(key, Journal::Entry{2, "y"}, std::nullopt)),
            AppendOutcome::kFenced);
  EXPECT_EQ(a->EpochOf(key), 0);
  EXPECT_EQ(a->counts().fenced, 1u);
  ASSERT_TRUE(b->Append(key, Journal::Entry{2, "z"}, std::nullopt).ok());
}

TEST_F(SharedPostgresTest, AMeshCanBeClaimedWhenItsLeaseHasRunOut) {
  const JournalPtr a = OpenNode(), b = OpenNode();
  const Journal::Key key = *a->Create("m", "");
  Sql("UPDATE dynmesh.meshes SET lease_until = clock_timestamp() - interval '1 second'");
  EXPECT_EQ(Where(*b, "m"), "free 1 0");
  EXPECT_TRUE(b->Claim(key).ok());
  EXPECT_TRUE(absl::IsAborted(a->Claim(key)));
}

TEST_F(SharedPostgresTest, AllMeshesAreListedInPages) {
  const JournalPtr a = OpenNode(), b = OpenNode();
  ASSERT_TRUE(a->Renew("host-a:1").ok());
  for (const char* id : {"c", "a", "d"}) ASSERT_TRUE(a->Create(id, id).ok());
  ASSERT_TRUE(b->Create("b", "").ok());
  const auto ids = [](const absl::StatusOr<std::vector<SharedJournal::Located>>& all) {
    std::string text;
    for (const auto& located : *all) absl::StrAppend(&text, located.mesh.id, Text(located), ";");
    return text;
  };
  EXPECT_EQ(ids(b->LocateAll("", 2)), "ahost-a:1 1 0;bmine 1 0;");
  EXPECT_EQ(ids(b->LocateAll("b", 2)), "chost-a:1 1 0;dhost-a:1 1 0;");
  EXPECT_EQ(ids(b->LocateAll("d", 2)), "");
  EXPECT_EQ(Where(*b, "x"), "NOT_FOUND");
}

TEST_F(PostgresLeasesTest, TheAdditionsAreMadeOnceByServersThatStartTogether) {
  Sql("DROP TABLE dynmesh.nodes; DROP TABLE dynmesh.followers; "
      "ALTER TABLE dynmesh.meshes DROP COLUMN lease_until");
  std::vector<std::thread> threads;
  for (int i = 0; i < 6; ++i) {
    threads.emplace_back([session = Connect()] {
      const absl::Status prepared = postgres::PrepareLeases(*session);
      EXPECT_TRUE(prepared.ok()) << prepared;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(Claim("a"), "epoch 2");
  EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.followers"), "0");
}

}  // namespace
}  // namespace dynmesh::server
