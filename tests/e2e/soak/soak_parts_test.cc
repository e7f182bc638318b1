// The soak finds nothing in a server without faults. Here its parts get faults, to show that they
// find them.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/e2e/soak/figures.h"
#include "tests/e2e/soak/ledger.h"
#include "tests/e2e/soak/revision_check.h"

namespace dynmesh::soak {
namespace {

using Step = RevisionCheck::Step;

v1::WatchEvent Chunk(std::uint64_t revision, std::uint32_t index, bool more) {
  v1::WatchEvent event;
  event.mutable_snapshot()->set_revision(revision);
  event.mutable_snapshot()->set_index(index);
  event.mutable_snapshot()->set_more(more);
  if (!more) event.mutable_snapshot()->set_hash("at " + std::to_string(revision));
  return event;
}
v1::WatchEvent Diff(std::uint64_t from, std::uint64_t to, bool more = false) {
  v1::WatchEvent event;
  event.mutable_diff()->set_from_revision(from);
  event.mutable_diff()->set_to_revision(to);
  event.mutable_diff()->set_more(more);
  if (!more) event.mutable_diff()->set_hash("at " + std::to_string(to));
  return event;
}
v1::WatchEvent Progress(std::uint64_t revision, const std::string& hash) {
  v1::WatchEvent event;
  event.mutable_progress()->set_revision(revision);
  event.mutable_progress()->set_hash(hash);
  return event;
}

// At revision 5.
RevisionCheck AtFive() {
  RevisionCheck check;
  EXPECT_EQ(*check.Take(Chunk(5, 0, false)), Step::kSnapshot);
  return check;
}
absl::StatusCode After(RevisionCheck check, const v1::WatchEvent& event) {
  return check.Take(event).status().code();
}

TEST(RevisionCheck, FollowsSnapshotsDiffsAndProgress) {
  RevisionCheck check;
  EXPECT_EQ(check.revision(), std::nullopt);
  EXPECT_EQ(*check.Take(Chunk(5, 0, true)), Step::kPart);
  EXPECT_EQ(check.revision(), std::nullopt);
  EXPECT_EQ(*check.Take(Chunk(5, 1, false)), Step::kSnapshot);
  EXPECT_EQ(*check.Take(Diff(5, 6)), Step::kRevision);
  EXPECT_EQ(*check.Take(Diff(6, 9, true)), Step::kPart);
  EXPECT_EQ(check.revision(), 6u);
  EXPECT_EQ(*check.Take(Diff(6, 9)), Step::kCoalesced);
  EXPECT_EQ(*check.Take(Progress(9, "at 9")), Step::kProgress);
  EXPECT_EQ(*check.Take(Chunk(12, 0, false)), Step::kSnapshot);
  EXPECT_EQ(check.revision(), 12u);
  EXPECT_EQ(check.hash(), "at 12");
}

TEST(RevisionCheck, FindsWhatWasLost) {
  EXPECT_EQ(After(AtFive(), Diff(6, 7)), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(After(AtFive(), Progress(6, "at 6")), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(After(RevisionCheck(), Diff(0, 1)), absl::StatusCode::kDataLoss);
}

TEST(RevisionCheck, FindsWhatCameTwice) {
  EXPECT_EQ(After(AtFive(), Diff(4, 5)), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(After(AtFive(), Diff(4, 6)), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(After(AtFive(), Diff(5, 5)), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(After(AtFive(), Chunk(5, 0, false)), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(After(AtFive(), Progress(4, "at 4")), absl::StatusCode::kAlreadyExists);
}

TEST(RevisionCheck, FindsPartsThatDoNotFit) {
  EXPECT_EQ(After(AtFive(), Chunk(6, 1, false)), absl::StatusCode::kDataLoss);
  EXPECT_EQ(After(AtFive(), Progress(5, "other")), absl::StatusCode::kDataLoss);
  RevisionCheck in_diff = AtFive();
  ASSERT_TRUE(in_diff.Take(Diff(5, 7, true)).ok());
  EXPECT_EQ(After(in_diff, Diff(5, 8)), absl::StatusCode::kDataLoss);
  EXPECT_EQ(After(in_diff, Chunk(9, 0, false)), absl::StatusCode::kDataLoss);
  EXPECT_EQ(After(in_diff, Progress(5, "at 5")), absl::StatusCode::kDataLoss);
  RevisionCheck in_snapshot = AtFive();
  ASSERT_TRUE(in_snapshot.Take(Chunk(7, 0, true)).ok());
  EXPECT_EQ(After(in_snapshot, Chunk(8, 1, false)), absl::StatusCode::kDataLoss);
  EXPECT_EQ(After(in_snapshot, Chunk(7, 2, false)), absl::StatusCode::kDataLoss);
  EXPECT_EQ(After(in_snapshot, Diff(5, 6)), absl::StatusCode::kDataLoss);
  EXPECT_EQ(After(AtFive(), v1::WatchEvent()), absl::StatusCode::kDataLoss);
}

TEST(RevisionCheck, DropsWhatTheEndOfAStreamCutShort) {
  RevisionCheck check = AtFive();
  ASSERT_TRUE(check.Take(Diff(5, 7, true)).ok());
  check.EndOfStream();
  EXPECT_EQ(check.revision(), 5u);
  EXPECT_EQ(*check.Take(Diff(5, 6)), Step::kRevision);
}

client::EditResult Result(std::uint64_t from, std::uint64_t to) {
  client::EditResult result;
  result.diff.from_revision = from;
  result.diff.to_revision = to;
  return result;
}

TEST(Ledger, KnowsWhichRevisionsWereAnswered) {
  Ledger ledger;
  EXPECT_EQ(ledger.Lost(0), 0u);
  EXPECT_EQ(ledger.Lost(2), 2u);
  ledger.Answered(Result(1, 2));
  ledger.Answered(Result(0, 1));
  ledger.Answered(Result(2, 2));  // no change
  EXPECT_EQ(ledger.head(), 2u);
  EXPECT_EQ(ledger.doubled(), 0u);
  EXPECT_EQ(ledger.Lost(2), 0u);
  EXPECT_EQ(ledger.Lost(4), 2u);
  EXPECT_EQ(ledger.Lost(1), 1u);  // answered, and not there
  ledger.Answered(Result(3, 4));
  EXPECT_EQ(ledger.Lost(4), 1u);
  ledger.Answered(Result(3, 4));
  EXPECT_EQ(ledger.doubled(), 1u);
}

std::vector<MemorySample> Samples(double slope, double jitter) {
  std::vector<MemorySample> samples;
  for (int i = 0; i < 1'000; ++i) {
    // Fills at first, as rings do.
    const double t = i, filled = 100 * std::min(1.0, t / 150);
    samples.push_back({t, 300 + filled + slope * t + (i % 7 == 0 ? jitter : 0)});
  }
  return samples;
}

TEST(Growth, IsNoneWhereMemoryOnlyFillsAtFirst) {
  const Growth growth = JudgeGrowth(Samples(0, 50));
  EXPECT_EQ(growth.warm, 400);
  EXPECT_EQ(growth.last, 400);
  EXPECT_EQ(growth.highest, 450);
  EXPECT_NEAR(growth.per_hour, 0, 5);
}

TEST(Growth, IsFoundUnderJitter) {
  const Growth growth = JudgeGrowth(Samples(0.1, 50));
  EXPECT_NEAR(growth.last - growth.warm, 70, 1);
  EXPECT_NEAR(growth.per_hour, 360, 5);
}

TEST(Growth, OfTooFewSamplesIsNone) { EXPECT_EQ(JudgeGrowth({{0, 1}, {1, 100}}).last, 0); }

TEST(Latencies, AreReportedOnceAndKept) {
  Latencies times;
  times.Add(1);
  times.Add(2);
  EXPECT_EQ(times.TakeRecent(), std::vector<double>({1, 2}));
  times.Add(3);
  EXPECT_EQ(times.TakeRecent(), std::vector<double>({3}));
  EXPECT_EQ(times.All(), std::vector<double>({1, 2, 3}));
}

}  // namespace
}  // namespace dynmesh::soak
