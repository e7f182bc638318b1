// The sizing field against examining every region.
#include "core/meshing/sizing_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::meshing::sizing_field_test {
namespace {

using geometry::Point2;

constexpr std::uint64_t kSeed = 20261121;

SizingRegion<2> RandomRegion(test::Random& random) {
  const auto length = [&] { return std::ldexp(0.5 + random.Unit(), -random.Below(20)); };
  SizingRegion<2> region;
  region.lo = region.hi = {{3 * random.Unit() - 1, 3 * random.Unit() - 1}};
  if (random.OneIn(3)) region.hi = {{region.lo[0] + length(), region.lo[1] + length()}};
  if (random.OneIn(2)) region.radius = length();
  region.target = length();
  return region;
}

TEST(SizingField, SaysWhatALookAtEveryRegionSays) {
  test::Random random(kSeed);
  for (int round = 0; round < 20; ++round) {
    SizingField<2> field({{-2.5, -2.5}}, {{3.5, 3.5}});
    std::map<SizingField<2>::Index, SizingRegion<2>> present;
    for (int step = 0; step < 300; ++step) {
      if (present.empty() || random.Below(5) < 3) {
        const SizingRegion<2> region = RandomRegion(random);
        const auto [it, is_new] = present.emplace(field.Add(region), region);
        ASSERT_TRUE(is_new);
      } else {
        auto it = present.begin();
        std::advance(it, random.Below(static_cast<int>(present.size())));
        ASSERT_EQ(field[it->first], it->second);
        field.Remove(it->first);
        present.erase(it);
      }
      ASSERT_EQ(field.empty(), present.empty());
      for (int ask = 0; ask < 10; ++ask) {
        const Point2 centre{{4 * random.Unit() - 1.5, 4 * random.Unit() - 1.5}};
        const double radius = std::ldexp(random.Unit(), 1 - random.Below(24));
        const bool wanted = std::any_of(present.begin(), present.end(), [&](const auto& entry) {
          return entry.second.most_radius() < radius && entry.second.Meets(centre, radius);
        });
        ASSERT_EQ(field.IsTooLarge(centre, radius), wanted)
            << "seed " << kSeed << ", round " << round << ", step " << step;
      }
    }
  }
}

// The definition: each region has its own lattice and those that are octaves wider, as far as they
// reach.
int FinestOfAll(const std::vector<SizingRegion<2>>& regions, const Point2& x, double margin,
                int below) {
  using Lattice = AnchorLattice<2>;
  int finest = below;
  for (const SizingRegion<2>& region : regions) {
    const int own = Lattice::LevelOf(region.target);
    for (int level = own; level < finest; level += Lattice::kOctave) {
      const double reach = Lattice::Reach(own, level) + margin;
      if (reach >= 0 && region.Meets(x, reach)) finest = level;
    }
  }
  return finest;
}

TEST(SizingField, KnowsTheFinestLattice) {
  test::Random random(kSeed + 1);
  constexpr int kWidest = 20;
  int found = 0, asked = 0;
  for (int round = 0; round < 200; ++round) {
    SizingField<2> field({{-2.5, -2.5}}, {{3.5, 3.5}});
    std::vector<SizingRegion<2>> regions;
    for (int i = random.Below(40); i >= 0; --i) {
      regions.push_back(RandomRegion(random));
      field.Add(regions.back());
    }
    for (int ask = 0; ask < 200; ++ask, ++asked) {
      Point2 x{{4 * random.Unit() - 1.5, 4 * random.Unit() - 1.5}};
      if (random.OneIn(2)) {
        const SizingRegion<2>& near = regions[random.Below(static_cast<int>(regions.size()))];
        const double off = 4 * near.target;
        x = {{near.hi[0] + near.radius + off * random.Unit(), near.hi[1] - off * random.Unit()}};
      }
      double margin = std::ldexp(random.Unit(), 1 - random.Below(24));
      if (random.OneIn(2)) margin = random.OneIn(2) ? 0 : -margin;
      const int below = random.OneIn(2) ? kWidest : random.Below(160) - 140;
      const int wanted = FinestOfAll(regions, x, margin, below);
      ASSERT_EQ(field.FinestLevel(x, margin, below), wanted)
          << "seed " << kSeed + 1 << ", round " << round << ", ask " << ask;
      ASSERT_EQ(field.HasFinerLevel(x, margin, below), wanted < below);
      found += wanted < below ? 1 : 0;
    }
  }
  EXPECT_GT(found, asked / 4);
  EXPECT_LT(found, asked * 3 / 4);
}

TEST(SizingRegion, MeetsWhatIsWithinItsRadius) {
  const SizingRegion<2> disc{{{0, 0}}, {{0, 0}}, 1, 1, nullptr};
  EXPECT_TRUE(disc.Meets({{2, 0}}, 1));
  EXPECT_FALSE(disc.Meets({{2, 0}}, 0.99));
  const SizingRegion<2> box{{{0, 0}}, {{2, 1}}, 0, 1, nullptr};
  EXPECT_TRUE(box.Meets({{1, 0.5}}, 0));
  EXPECT_TRUE(box.Meets({{5, 5}}, 5));
  EXPECT_FALSE(box.Meets({{5, 5}}, 4.9));
  const SizingRegion<2> point{{{0, 0}}, {{0, 0}}, 0, 1, nullptr};
  EXPECT_TRUE(point.Meets({{3, 4}}, 5));
  EXPECT_FALSE(point.Meets({{3, 4}}, 4.9));
}

// Unused cells are released.
TEST(SizingField, DoesNotGrowAsARegionTravels) {
  SizingField<2> field({{0, 0}}, {{1, 1}});
  std::size_t most = 0;
  for (int i = 0; i < 2000; ++i) {
    const double x = i / 2000.0;
    const auto index = field.Add({{{x, 0.3}}, {{x, 0.3}}, 0.01, 0.001, nullptr});
    field.Remove(index);
    if (i == 100) most = field.bytes();
  }
  EXPECT_EQ(field.bytes(), most);
}

}  // namespace
}  // namespace dynmesh::meshing::sizing_field_test
