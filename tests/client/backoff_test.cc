// Pauses by a clock of its own: how late the next try comes after an outage has ended, and how
// often a server is asked that stays away.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "client/backoff_internal.h"

namespace dynmesh::client::backoff_test {
namespace {

using Clock = Backoff::Clock;

Clock::time_point At(absl::Duration since_begin) {
  return Clock::time_point() + absl::ToChronoNanoseconds(since_begin);
}

// The moments of tries, from the first failure at 0 to the first one from `end` on.
template <class Chance>
std::vector<absl::Duration> TriesUntil(absl::Duration end, const Chance& chance) {
  Backoff backoff(absl::Milliseconds(100), absl::Seconds(5));
  std::vector<absl::Duration> tries = {absl::ZeroDuration()};
  while (tries.back() < end) {
    tries.push_back(tries.back() + backoff.Failed(At(tries.back()), chance()));
  }
  return tries;
}

TEST(Backoff, ATryFollowsTheEndOfAnOutageWithinASecondOrHalfOfItsLength) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any;
  for (absl::Duration outage = absl::Milliseconds(1); outage < absl::Hours(2); outage *= 1.03) {
    const absl::Duration limit = std::max(absl::Seconds(1), outage / 2);
    for (const double fixed : {0.0, 0.5, 0.999}) {
      EXPECT_LE(TriesUntil(outage, [&] { return fixed; }).back() - outage, limit) << outage;
    }
    EXPECT_LE(TriesUntil(outage, [&] { return any(random); }).back() - outage, limit) << outage;
  }
}

TEST(Backoff, AServerThatStaysAwayIsAskedRarely) {
  // By the longest pause, and some tries before the pauses are as long.
  EXPECT_LE(TriesUntil(absl::Hours(1), [] { return 0.0; }).size(), 3600 / 4 + 30);
  EXPECT_LE(TriesUntil(absl::Seconds(1), [] { return 0.0; }).size(), 14);
}

TEST(Backoff, ClientsOfOneServerDoNotComeBackTogether) {
  const auto early = TriesUntil(absl::Minutes(1), [] { return 0.0; });
  const auto late = TriesUntil(absl::Minutes(1), [] { return 0.999; });
  EXPECT_GT(early.size(), late.size() + 5);
}

TEST(Backoff, BeginsAgainAfterASuccess) {
  Backoff backoff(absl::Milliseconds(100), absl::Seconds(5));
  EXPECT_EQ(backoff.Failed(At(absl::Seconds(0)), 0.5), absl::Milliseconds(100));
  EXPECT_GT(backoff.Failed(At(absl::Seconds(10)), 0.5), absl::Seconds(2));
  backoff.Succeeded();
  EXPECT_EQ(backoff.Failed(At(absl::Seconds(20)), 0.5), absl::Milliseconds(100));
}

}  // namespace
}  // namespace dynmesh::client::backoff_test
