// The history in a journal: what is kept, what is deleted, and damage.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <deque>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "tests/server/journal/journal_contract.h"
#include "tests/server/journal/told.h"
#include "tests/support/deadline.h"
#include "tests/support/seed.h"

namespace dynmesh::server {
namespace {

TEST_P(JournalGenerationsTest, TheOneBeforeTheNewestIsKept) {
  JournalBackend::Options options;
  options.history_bytes = 0;
  Open(options);
  const auto key = *journal_->Create("a", "");
  EXPECT_EQ(ToldPast(*journal_, key, 0, 0), "");
  Append(key, 1, "a");
  Append(key, 2, "b");
  ASSERT_TRUE(journal_->Compact(key, 2, {"p", "q"}).ok());
  Append(key, 3, "c");
  EXPECT_EQ(*journal_->Oldest(key), 0u);
  EXPECT_EQ(ToldPast(*journal_, key, 0, 0), "");
  EXPECT_EQ(ToldPast(*journal_, key, 1, 1), "1:a ");
  EXPECT_EQ(ToldPast(*journal_, key, 1, 3), "1:a 2:b 3:c ");
  EXPECT_EQ(ToldPast(*journal_, key, 2, 3), "@2:p @2:q 3:c ");
  EXPECT_TRUE(absl::StrContains(ToldPast(*journal_, key, 4, 4), "OUT_OF_RANGE"));
  EXPECT_TRUE(absl::StrContains(ToldPast(*journal_, key, 3, 2), "OUT_OF_RANGE"));
  ASSERT_TRUE(journal_->Compact(key, 3, {"r"}).ok());
  ASSERT_TRUE(journal_->Compact(key, 3, {"s"}).ok()) << "there is one already";
  Open(options);
  EXPECT_EQ(*journal_->Oldest(key), 2u);
  EXPECT_EQ(ToldPast(*journal_, key, 2, 2), "@2:p @2:q ");
  EXPECT_EQ(ToldPast(*journal_, key, 3, 3), "@3:r ");
  EXPECT_TRUE(absl::StrContains(ToldPast(*journal_, key, 1, 3), "OUT_OF_RANGE"));
  EXPECT_EQ(backend_->Rows("entries"), 1);
  EXPECT_EQ(backend_->Rows("snapshots"), 3);
  EXPECT_TRUE(absl::IsNotFound(journal_->Oldest(key + 1).status()));
}

// A snapshot is written while batches are appended, which are behind it then.
TEST_P(JournalGenerationsTest, ASnapshotMayBeOfAnEarlierRevision) {
  JournalBackend::Options options;
  options.history_bytes = 0;
  Open(options);
  const auto key = *journal_->Create("a", "");
  for (std::uint64_t r = 1; r <= 5; ++r) Append(key, r, absl::StrCat("e", r));
  ASSERT_TRUE(journal_->Compact(key, 3, {"p", "q"}).ok());
  EXPECT_EQ(Told(*journal_, key), "@3:p @3:q 4:e4 5:e5 ");
  EXPECT_EQ(ToldPast(*journal_, key, 2, 4), "1:e1 2:e2 3:e3 4:e4 ");
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Compact(key, 2, {"x"})));
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Compact(key, 6, {"x"})));
  ASSERT_TRUE(journal_->Compact(key, 3, {"again"}).ok()) << "there is one already";
  Append(key, 6, "e6");
  ASSERT_TRUE(journal_->Compact(key, 5, {"s"}).ok());
  Open(options);
  EXPECT_EQ(*journal_->Oldest(key), 3u);
  EXPECT_EQ(Told(*journal_, key), "@5:s 6:e6 ");
  EXPECT_EQ(ToldPast(*journal_, key, 3, 6), "@3:p @3:q 4:e4 5:e5 6:e6 ");
  EXPECT_EQ(backend_->Rows("entries"), 3);
  EXPECT_EQ(journal_->List()->front().entries, 2u);
}

// Of so many parts that batches are appended before its end, however quick the journal is.
TEST_P(JournalGenerationsTest, BatchesAreAppendedBesideASnapshot) {
  JournalBackend::Options options;
  options.transaction_bytes = 1'000;
  Journal::Key key = 0;
  std::string expected;
  std::uint64_t beside = 0;
  for (int count = 40; beside <= 5 && count <= 40 * 256 && !HasFailure(); count *= 4) {
    OpenFresh(options);
    key = *journal_->Create("a", "");
    const auto other = *journal_->Create("b", "");
    Append(key, 1, "x");
    expected.clear();
    std::vector<std::string> parts;
    for (int i = 0; i < count; ++i) {
      parts.push_back(absl::StrCat(std::string(800, 'p'), i));
      absl::StrAppend(&expected, "@1:", parts.back(), " ");
    }
    std::atomic<bool> ended{false};
    absl::Status compacted;
    std::thread snapshot([&] {
      compacted = journal_->Compact(key, 1, parts);
      ended = true;
    });
    std::uint64_t last = 1;
    beside = 0;
    for (std::uint64_t theirs = 1; !ended || last < 10; ++theirs) {
      Append(key, ++last, "y");
      Append(other, theirs, "z");
      beside += !ended;
    }
    snapshot.join();
    ASSERT_TRUE(compacted.ok()) << compacted;
    for (std::uint64_t r = 2; r <= last; ++r) absl::StrAppend(&expected, r, ":y ");
    EXPECT_EQ(Told(*journal_, key), expected);
  }
  EXPECT_GT(beside, 5U);
  Open(options);
  EXPECT_EQ(Told(*journal_, key), expected);
}

// Of so many parts that it is cancelled before its end.
TEST_P(JournalGenerationsTest, ASnapshotThatIsNotWantedAnyMoreEndsUnseen) {
  JournalBackend::Options options;
  options.transaction_bytes = 1'000;
  Journal::Key key = 0;
  absl::Status status;
  for (std::size_t count = 500; status.ok() && !HasFailure(); count *= 4) {
    OpenFresh(options);
    key = *journal_->Create("a", "");
    Append(key, 1, "x");
    Append(key, 2, "y");
    const std::vector<std::string> parts(count, std::string(800, 'p'));
    std::atomic<bool> ended{false}, cancelled{false};
    std::thread snapshot([&] {
      status = journal_->Compact(key, 2, parts, cancelled);
      ended = true;
    });
    test::WaitUntil("a part", [&] { return ended || backend_->Rows("snapshots") > 0; });
    cancelled = true;
    snapshot.join();
  }
  EXPECT_TRUE(absl::IsCancelled(status)) << status;
  EXPECT_GT(backend_->Rows("snapshots"), 0);
  EXPECT_EQ(Told(*journal_, key), "1:x 2:y ");
  Append(key, 3, "z");
  ASSERT_TRUE(journal_->Compact(key, 3, {"q"}).ok());
  EXPECT_EQ(Told(*journal_, key), "@3:q ");
  EXPECT_EQ(backend_->Rows("snapshots"), 1);
}

// Entries and snapshots of random sizes against a model that keeps all and counts what is kept. A
// snapshot is of the last revision, or of one before.
TEST_P(JournalGenerationsTest, AreDroppedFromTheOldestOnByTheirBytes) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  std::mt19937_64 random(seed);
  const auto text = [&] { return std::string(1 + random() % 50, 'a' + char(random() % 26)); };
  JournalBackend::Options options;
  options.history_bytes = 100 + random() % 400;
  options.transaction_bytes = 1 + random() % 100;
  Open(options);
  const auto key = *journal_->Create("a", "");
  struct Generation {
    std::uint64_t revision = 0;
    std::uint64_t bytes = 0;
    std::string told;
  };
  std::deque<Generation> kept = {{}};
  std::vector<std::string> entries = {""};  // by revision, as told
  std::vector<std::uint64_t> bytes = {0};   // the same, of the data
  std::uint64_t head = 0;
  for (int step = 0; step < 60; ++step) {
    if (random() % 4 != 0) {
      const std::string data = text();
      Append(key, ++head, data);
      entries.push_back(absl::StrCat(head, ":", data, " "));
      bytes.push_back(data.size());
      kept.back().bytes += data.size();
      continue;
    }
    std::vector<std::string> parts;
    const std::uint64_t newest = kept.back().revision;
    const std::uint64_t at = random() % 2 == 0 ? head : newest + random() % (head - newest + 1);
    Generation next{at, 0, ""};
    for (std::size_t i = 1 + random() % 3; i > 0; --i) {
      parts.push_back(text());
      next.bytes += parts.back().size();
      absl::StrAppend(&next.told, "@", at, ":", parts.back(), " ");
    }
    ASSERT_TRUE(journal_->Compact(key, at, parts).ok());
    if (newest == at) continue;
    std::uint64_t behind = 0;  // bytes of the entries after it
    for (std::uint64_t r = at + 1; r <= head; ++r) behind += bytes[r];
    kept.back().bytes -= behind;
    next.bytes += behind;
    const auto total = [&] {
      std::uint64_t sum = 0;
      for (const Generation& g : kept) sum += g.bytes;
      return sum;
    };
    while (kept.size() > 1 && total() > options.history_bytes) kept.pop_front();
    kept.push_back(next);
    if (random() % 4 == 0) Open(options);
    ASSERT_EQ(*journal_->Oldest(key), kept.front().revision);
    ASSERT_EQ(backend_->Rows("entries"), static_cast<std::int64_t>(head - kept.front().revision));
    ASSERT_EQ(backend_->Rows("generations"), static_cast<std::int64_t>(kept.size()));
    for (std::uint64_t from = 0; from <= head; ++from) {
      std::string expected = "-";
      for (const Generation& g : kept) {
        if (g.revision > from) break;
        expected = g.told;
        for (std::uint64_t r = g.revision + 1; r <= from; ++r) expected += entries[r];
      }
      const std::string told = ToldPast(*journal_, key, from, from);
      if (expected == "-") {
        EXPECT_TRUE(absl::StrContains(told, "OUT_OF_RANGE")) << told;
      } else {
        ASSERT_EQ(told, expected) << "revision " << from;
      }
    }
  }
}

TEST_P(JournalGenerationsTest, LargeSnapshotsAreWrittenInSeveralTransactions) {
  JournalBackend::Options options;
  options.transaction_bytes = 1'000;
  Open(options);
  const auto key = *journal_->Create("a", "");
  Append(key, 1, "x");
  const std::vector<std::string> parts(20, std::string(400, 'p'));
  const std::uint64_t before = journal_->counts().syncs;
  ASSERT_TRUE(journal_->Compact(key, 1, parts).ok());
  EXPECT_GE(journal_->counts().syncs - before, 11u);  // two parts a transaction, and the switch
  EXPECT_EQ(backend_->Rows("snapshots"), 20);
}

TEST_P(JournalGenerationsTest, ADamagedRowIsNamed) {
  const std::pair<const char*, const char*> damages[] = {
      {"UPDATE snapshots SET data = '00' WHERE revision = 2 AND part = 1",
       "mesh a part 1 of the snapshot of revision 2"},
      {"UPDATE snapshots SET revision = 1 WHERE revision = 2 AND part = 1",
       "mesh a the snapshot of revision 2"},
      {"DELETE FROM snapshots WHERE part = 1", "mesh a the snapshot of revision 2"},
      {"UPDATE entries SET data = '00' WHERE revision = 3", "mesh a the entry of revision 3"},
      {"UPDATE entries SET checksum = checksum + 1 WHERE revision = 3",
       "mesh a the entry of revision 3"},
      {"UPDATE entries SET data = (SELECT data FROM entries WHERE revision = 4), checksum = "
       "(SELECT checksum FROM entries WHERE revision = 4) WHERE revision = 3",
       "mesh a the entry of revision 3"},
      {"UPDATE meshes SET description = 'no'", "mesh a the description"},
  };
  for (const auto& [sql, what] : damages) {
    SCOPED_TRACE(sql);
    OpenFresh();
    const auto key = *journal_->Create("a", "about");
    for (const std::uint64_t r : {1u, 2u, 3u, 4u}) {
      Append(key, r, absl::StrCat("data", r));
      if (r == 2) {
        ASSERT_TRUE(journal_->Compact(key, 2, {"p", "q"}).ok());
      }
    }
    journal_.reset();
    backend_->Run(sql);
    Open();
    for (const std::string& told : {Told(*journal_, key), ToldPast(*journal_, key, 3, 4)}) {
      EXPECT_TRUE(absl::StrContains(told, "DATA_LOSS")) << told;
      EXPECT_TRUE(absl::StrContains(told, what)) << told;
    }
  }
}

// Whatever its size: no call waits for the removal of its rows.
TEST_P(JournalGenerationsTest, ADeletedMeshGoesAtOnceAndItsRowsPartByPart) {
  JournalBackend::Options options;
  options.transaction_bytes = 100;
  Open(options);
  const auto gone = *journal_->Create("a", ""), stays = *journal_->Create("b", "");
  for (std::uint64_t r = 1; r <= 40; ++r) Append(gone, r, std::string(20, 'x'));
  Append(stays, 1, "one");
  ASSERT_TRUE(journal_->Delete(gone).ok());
  EXPECT_EQ(journal_->List()->size(), 1u);
  EXPECT_EQ(backend_->Rows("entries"), 41);
  int parts = 1;
  while (journal_->Sweep(gone)) {
    ++parts;
    EXPECT_EQ(Told(*journal_, stays), "1:one ");
  }
  EXPECT_GE(parts, 4);
  EXPECT_EQ(backend_->Rows("entries"), 1);
  EXPECT_FALSE(journal_->Sweep(gone));
  EXPECT_FALSE(journal_->Sweep(stays));
  EXPECT_EQ(Told(*journal_, stays), "1:one ");
}

}  // namespace
}  // namespace dynmesh::server
