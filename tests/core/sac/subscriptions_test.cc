// Subscriptions against maps.
#include "core/sac/subscriptions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "tests/core/sac/random_script.h"

namespace dynmesh::sac {
namespace {

using testing::NewSeed;
using testing::Random;

// By operation: which parts, and whether it is attentive.
using Told = std::map<std::uint32_t, std::pair<Parts, bool>>;
Told At(const Subscriptions& s, Place place) {
  Told told;
  const auto attentive = s.attentive_at(place);
  for (const auto& subscriber : s.at(place)) {
    const bool is_attentive = told.size() < attentive.size();
    if (is_attentive) {
      EXPECT_EQ(&attentive[told.size()], &subscriber);
    }
    const auto& [op, parts] = subscriber;
    EXPECT_TRUE(told.emplace(op, std::pair(parts, is_attentive)).second);
  }
  return told;
}

TEST(Subscriptions, NobodyIsAtAPlaceNeverNamed) {
  Subscriptions s;
  EXPECT_TRUE(s.at(0).empty());
  EXPECT_TRUE(s.at(1'000'000'000).empty());
  EXPECT_TRUE(s.Take(7).empty());
  s.Add(3, 1);
  EXPECT_TRUE(s.at(2).empty());
  EXPECT_TRUE(s.at(4).empty());
}

TEST(Subscriptions, TakeEmptiesThePlaceAndOnlyThat) {
  Subscriptions s;
  for (std::uint32_t op = 0; op < 50; ++op) s.Add(op % 2, op);
  EXPECT_EQ(s.Take(0).size(), 25u);
  EXPECT_TRUE(s.at(0).empty());
  EXPECT_EQ(s.at(1).size(), 25u);
  s.Add(0, 99);
  EXPECT_EQ(At(s, 0), (Told{{99, {kAllParts, false}}}));
}

TEST(Subscriptions, ALoadSortsTheAttentiveOut) {
  Subscriptions s;
  s.BeginLoad();
  for (std::uint32_t op = 0; op < 60; ++op) s.Add(op % 3, op, op, op % 7 == 0);
  s.EndLoad();
  for (Place place = 0; place < 3; ++place) {
    Told wanted;
    for (std::uint32_t op = place; op < 60; op += 3) wanted[op] = {op, op % 7 == 0};
    EXPECT_EQ(At(s, place), wanted);
  }
}

TEST(Subscriptions, AgreesWithSetsUnderRandomScripts) {
  const std::uint64_t seed = NewSeed();
  for (int script = 0; script < 6; ++script) {
    Random random(seed + script);
    // Crowds at few places, or a few at many.
    const std::uint32_t places = script % 2 == 0 ? 8 : 5000;
    Subscriptions s;
    std::map<Place, Told> told;
    std::vector<std::pair<Place, std::uint32_t>> all;
    for (int step = 0; step < 30'000; ++step) {
      const bool shrinking = step % 10'000 > 7000;
      if (!all.empty() && random.Below(10) < (shrinking ? 8 : 3)) {
        std::swap(all[random.Below(all.size())], all.back());
        const auto [place, op] = all.back();
        if (random.Below(4) == 0) {
          const auto [parts, attentive] =
              told[place][op] = {random.Below(1 << 20), random.Below(3) == 0};
          s.Set(place, op, parts, attentive);
        } else {
          all.pop_back();
          s.Remove(place, op);
          told[place].erase(op);
        }
      } else {
        const Place place = random.Below(places);
        const std::uint32_t op = random.Below(1000), parts = random.Below(1 << 20);
        const bool attentive = random.Below(3) == 0;
        if (told[place].emplace(op, std::pair(parts, attentive)).second) {
          s.Add(place, op, parts, attentive);
          all.emplace_back(place, op);
        }
      }
      if (step % 2000 == 0) {
        const Place place = random.Below(places);
        auto taken = s.Take(place);
        std::sort(taken.begin(), taken.end());
        std::vector<std::uint32_t> expected;
        for (const auto& [op, parts] : told[place]) expected.push_back(op);
        ASSERT_EQ(taken, expected);
        told.erase(place);
        std::erase_if(all, [&](const auto& a) { return a.first == place; });
      }
      if (step % 1000 == 0) {
        for (Place p = 0; p < places; ++p) ASSERT_EQ(At(s, p), told[p]);
      }
    }
  }
}

}  // namespace
}  // namespace dynmesh::sac
