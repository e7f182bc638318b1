// The sizing field against examining every region.
#include "core/meshing/sizing_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "core/meshing/polygon_area.h"
#include "core/meshing/polyline.h"
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

// --- What a region holds ------------------------------------------------------------------

// Boxes with a radius, polylines and polygons.
SizingRegion<2> RegionOfAnyShape(test::Random& random) {
  SizingRegion<2> region;
  region.target = std::ldexp(0.5 + random.Unit(), -4 - random.Below(3));
  std::vector<Point2> corners;
  for (int i = 0; i < 5; ++i) {
    const double turn = 1.25 * i + 0.8 * random.Unit(), r = 0.2 + 0.4 * random.Unit();
    corners.push_back({{0.5 + r * std::cos(turn), 0.5 + r * std::sin(turn)}});
  }
  switch (random.Below(3)) {
    case 0: {
      const auto area =
          std::make_shared<const PolygonArea>(std::vector<std::vector<Point2>>{corners});
      region.lo = area->lo(), region.hi = area->hi(), region.shape = area;
      break;
    }
    case 1: {
      const auto line = std::make_shared<const Polyline<2>>(std::span<const Point2>(corners));
      region.lo = line->lo(), region.hi = line->hi(), region.shape = line;
      region.radius = 0.2 * random.Unit();
      break;
    }
    default:
      region.lo = corners[0];
      region.hi = random.OneIn(2) ? corners[0] : corners[1];
      for (int k = 0; k < 2; ++k) region.hi[k] = std::max(region.lo[k], region.hi[k]);
      region.radius = random.OneIn(3) && region.lo != region.hi ? 0 : 0.4 * random.Unit();
  }
  return region;
}

// True if all of some points of the ball about `centre`, many of them on its border, are accepted.
template <class Accept>
bool AllAround(const Point2& centre, double radius, Accept accept) {
  constexpr int kTurns = 64;
  for (int i = 0; i < kTurns; ++i) {
    const double turn = 2 * std::numbers::pi * i / kTurns;
    for (const double part : {1.0, 0.7, 0.3, 0.0}) {
      const double r = part * radius;
      if (!accept(Point2{{centre[0] + r * std::cos(turn), centre[1] + r * std::sin(turn)}}))
        return false;
    }
  }
  return true;
}

TEST(SizingRegion, HoldsWhatIsInsideEverywhere) {
  test::Random random(kSeed + 2);
  int held = 0, might = 0;
  for (int i = 0; i < 20'000; ++i) {
    const SizingRegion<2> region = RegionOfAnyShape(random);
    const Point2 centre{{random.Unit(), random.Unit()}};
    const double radius = std::ldexp(random.Unit(), -1 - random.Below(8));
    const bool inside =
        AllAround(centre, radius, [&](const Point2& x) { return region.Meets(x, 0); });
    const bool holds = region.Holds(centre, radius);
    ASSERT_TRUE(!holds || inside) << "seed " << kSeed + 2 << ", " << i;
    Extent<2> box = Extent<2>::Nothing();
    box.AddBall(centre, radius * std::numbers::sqrt2 / 2);
    if (region.Holds(box)) {
      for (const double x : {box.lo[0], box.hi[0]}) {
        for (const double y : {box.lo[1], box.hi[1]}) {
          ASSERT_TRUE(region.Meets({{x, y}}, 0));
        }
      }
    }
    ASSERT_TRUE(!inside || region.MayMeet(box));
    held += holds ? 1 : 0;
    might += inside ? 1 : 0;
  }
  EXPECT_GT(held, 2000);
  EXPECT_GT(held, 0.9 * might);
}

// A region that holds another one holds what that holds.
TEST(SizingRegion, HoldsRegions) {
  test::Random random(kSeed + 3);
  int held = 0;
  for (int i = 0; i < 20'000; ++i) {
    const SizingRegion<2> region = RegionOfAnyShape(random);
    SizingRegion<2> other = RegionOfAnyShape(random);
    for (int k = 0; k < 2 && other.shape == nullptr; ++k) {
      other.hi[k] = other.lo[k] + 0.2 * (other.hi[k] - other.lo[k]);
    }
    other.radius *= 0.3;
    if (!region.Holds(other)) continue;
    ++held;
    for (int k = 0; k < 50; ++k) {
      const Point2 x{{random.Unit(), random.Unit()}};
      ASSERT_TRUE(!other.Meets(x, 0) || region.Meets(x, 0)) << "seed " << kSeed + 3 << ", " << i;
    }
  }
  EXPECT_GT(held, 1000);
}

TEST(SizingField, KnowsALatticeThatIsEverywhereInABall) {
  test::Random random(kSeed + 4);
  constexpr int kWidest = 20;
  int found = 0;
  for (int round = 0; round < 300; ++round) {
    SizingField<2> field({{-2.5, -2.5}}, {{3.5, 3.5}});
    for (int i = random.Below(5); i >= 0; --i) field.Add(RegionOfAnyShape(random));
    const auto all = [](auto) { return true; };
    for (int ask = 0; ask < 20; ++ask) {
      const Point2 centre{{random.Unit(), random.Unit()}};
      const double radius = std::ldexp(random.Unit(), -1 - random.Below(8));
      const int level = field.LevelOver(centre, radius, kWidest, all);
      ASSERT_TRUE(
          AllAround(centre, radius,
                    [&](const Point2& x) { return field.FinestLevel(x, 0, kWidest) <= level; }))
          << "seed " << kSeed + 4;
      ASSERT_EQ(field.LevelOver(centre, 0, kWidest, all), field.FinestLevel(centre, 0, kWidest));
      found += level == field.FinestLevel(centre, 0, kWidest) ? 1 : 0;
    }
  }
  EXPECT_GT(found, 3000);
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
