// The tree of regions against a plain list of them.
#include "core/meshing/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::meshing::box_tree_test {
namespace {

template <int D>
geometry::Point<D> PointOf(double coordinate) {
  geometry::Point<D> p;
  p.c.fill(coordinate);
  return p;
}

template <int D>
struct Region {
  geometry::Point<D> lo = {}, hi = {};
  double radius = 0, key = 0;
  double LeastCell() const { return 0; }
  double Key() const { return key; }
  // What a search must find: the ball's box meets the region's.
  bool Meets(const geometry::Point<D>& centre, double ball) const {
    for (int k = 0; k < D; ++k) {
      if (!(lo[k] - radius - ball <= centre[k] && centre[k] <= hi[k] + radius + ball)) return false;
    }
    return true;
  }
};

// Of any size; some reach beyond the unit box.
template <int D>
Region<D> RandomRegion(test::Random& random) {
  Region<D> region;
  const double size = std::ldexp(random.Unit(), -random.Below(12));
  for (int k = 0; k < D; ++k) {
    region.lo[k] = random.Unit();
    region.hi[k] = region.lo[k] + size * random.Unit();
  }
  region.radius = random.Below(2) == 0 ? 0 : 0.5 * size;
  region.key = random.Unit();
  return region;
}

template <int D>
void ExpectFindsAll(int steps, std::uint64_t seed) {
  test::Random random(seed);
  BoxTree<D, Region<D>> tree(PointOf<D>(0), PointOf<D>(1));
  std::map<std::uint32_t, Region<D>> present;
  for (int step = 0; step < steps; ++step) {
    if (present.empty() || random.Below(5) < 3) {
      const Region<D> region = RandomRegion<D>(random);
      present[tree.Add(region)] = region;
    } else {
      const auto it = std::next(present.begin(), random.Below(static_cast<int>(present.size())));
      tree.Remove(it->first);
      present.erase(it);
    }
    const Region<D> ball = RandomRegion<D>(random);
    std::vector<std::uint32_t> expected, found;
    for (const auto& [i, region] : present) {
      if (region.key < ball.key && region.Meets(ball.lo, ball.radius)) expected.push_back(i);
    }
    tree.Any(ball.lo, ball.radius, ball.key, [&](std::uint32_t i) {
      if (tree[i].Meets(ball.lo, ball.radius)) found.push_back(i);
      return false;
    });
    std::sort(found.begin(), found.end());
    ASSERT_EQ(found, expected) << "step " << step << ", seed " << seed;
    EXPECT_EQ(tree.empty(), present.empty());
  }
}

TEST(BoxTree, FindsAllRegionsThatMayMeetABall) {
  ExpectFindsAll<2>(3000, 1);
  ExpectFindsAll<3>(3000, 2);
}

TEST(BoxTree, EndsAtTheFirstThatIsAccepted) {
  test::Random random(3);
  BoxTree<2, Region<2>> tree(PointOf<2>(0), PointOf<2>(1));
  for (int i = 0; i < 100; ++i) tree.Add(RandomRegion<2>(random));
  int asked = 0;
  EXPECT_TRUE(tree.Any(PointOf<2>(0.5), 2, INFINITY, [&](std::uint32_t) { return ++asked == 7; }));
  EXPECT_EQ(asked, 7);
}

// Tiles of a slanted plane. Cells are cubes, so most of a cell that the plane goes through is
// empty.
TEST(BoxTree, EntersFewBoxesBesideASurface) {
  constexpr int kTiles = 64;
  BoxTree<3, Region<3>> tree(PointOf<3>(0), PointOf<3>(1));
  for (int i = 0; i < kTiles; ++i) {
    for (int j = 0; j < kTiles; ++j) {
      const double x = i / double{kTiles}, y = j / double{kTiles}, side = 1 / double{kTiles};
      tree.Add({{{x, y, 0.5}}, {{x + side, y + side, 0.5}}, 0, 0});
    }
  }
  int entered = 0, asked = 0;
  const auto counted = [&](const auto&, const auto&) {
    ++entered;
    return false;
  };
  const auto ask = [&](std::uint32_t) {
    ++asked;
    return false;
  };
  // Its box ends just above the surface.
  EXPECT_FALSE(tree.Any({{0.5, 0.5, 0.751}}, 0.25, INFINITY, counted, ask));
  EXPECT_EQ(entered, 0);
  EXPECT_EQ(asked, 0);
  // One that touches a few tiles.
  EXPECT_FALSE(tree.Any({{0.508, 0.508, 0.5}}, 0.01, INFINITY, counted, ask));
  EXPECT_GE(asked, 9);
  EXPECT_LE(asked, 36);
  EXPECT_LE(entered, 60);
}

}  // namespace
}  // namespace dynmesh::meshing::box_tree_test
