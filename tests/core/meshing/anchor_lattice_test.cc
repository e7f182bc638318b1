#include "core/meshing/anchor_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::meshing::anchor_lattice_test {
namespace {

template <class D>
class AnchorLatticeTest : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(AnchorLatticeTest, Dimensions);

template <int D>
Extent<D> Cube(double lo, double hi) {
  Extent<D> box;
  box.lo.fill(lo);
  box.hi.fill(hi);
  return box;
}

template <int D>
std::vector<geometry::Point<D>> PointsIn(const AnchorLattice<D>& lattice, const Extent<D>& box) {
  std::vector<geometry::Point<D>> points;
  lattice.ForEachIn(
      box, [](const geometry::Point<D>&, double) { return true; },
      [&](const auto&, const geometry::Point<D>& p) {
        points.push_back(p);
        return true;
      });
  return points;
}

// Squared distances from the points to the nearest of the others, least and greatest.
template <int D>
double NearestOf(const geometry::Point<D>& x, const std::vector<geometry::Point<D>>& points) {
  double best = INFINITY;
  for (const auto& p : points) {
    if (p != x) best = std::min(best, std::sqrt(geometry::SquaredDistance(x, p)));
  }
  return best;
}

TYPED_TEST(AnchorLatticeTest, SpacingIsTheWidestOfEightToTheOctaveThatATargetAllows) {
  constexpr int D = TypeParam();
  const double most = D == 2 ? 1.22 : 1.26;
  test::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const double target = std::ldexp(1 + random.Unit(), random.Below(200) - 100);
    const int level = AnchorLattice<D>::LevelOf(target);
    EXPECT_LE(AnchorLattice<D>(level).spacing(), most * target);
    EXPECT_GT(AnchorLattice<D>(level + 1).spacing(), most * target);
  }
  for (int level = -40; level < 40; ++level) {
    const double s = AnchorLattice<D>(level).spacing();
    EXPECT_NEAR(AnchorLattice<D>(level + 1).spacing() / s, std::pow(2, 0.125), 1e-12);
    EXPECT_EQ(AnchorLattice<D>(level + 8).spacing(), 2 * s);
  }
}

TYPED_TEST(AnchorLatticeTest, NearestNeighboursAreASpacingAwayOrInTheMiddleOfACube) {
  constexpr int D = TypeParam();
  const AnchorLattice<D> lattice(0);
  const auto points = PointsIn(lattice, Cube<D>(-4.01, 4.01));
  const double wanted = D == 2 ? 1 : std::sqrt(3) / 2;
  int inner = 0;
  for (const auto& p : points) {
    if (std::ranges::any_of(p.c, [](double x) { return std::fabs(x) > 2.5; })) continue;
    EXPECT_NEAR(NearestOf(p, points), wanted, 1e-12);
    ++inner;
  }
  // 25 square units at 0.866 each; 125 cubes of two points each.
  EXPECT_NEAR(inner, D == 2 ? 29 : 250, D == 2 ? 6 : 100);
}

// No position is farther from the lattice than the circumradii.
TYPED_TEST(AnchorLatticeTest, CoversWithBallsOfTheCircumradius) {
  constexpr int D = TypeParam();
  const AnchorLattice<D> lattice(0);
  const auto points = PointsIn(lattice, Cube<D>(-3, 3));
  const double circumradius = D == 2 ? 1 / std::sqrt(3) : std::sqrt(5) / 4;
  test::Random random(4);
  double farthest = 0;
  for (int i = 0; i < 3000; ++i) {
    geometry::Point<D> x;
    for (int k = 0; k < D; ++k) x[k] = 2 * random.Unit() - 1;
    farthest = std::max(farthest, NearestOf(x, points));
  }
  EXPECT_LE(farthest, circumradius + 1e-12);
  EXPECT_GT(farthest, 0.9 * circumradius);
}

TYPED_TEST(AnchorLatticeTest, PointsAreThoseInTheBoxOnceEach) {
  constexpr int D = TypeParam();
  test::Random random(5);
  for (int i = 0; i < 50; ++i) {
    const AnchorLattice<D> lattice(random.Below(9) - 12);
    const auto all = PointsIn(lattice, Cube<D>(-1.5, 1.5));
    Extent<D> box;
    for (int k = 0; k < D; ++k) {
      box.lo[k] = 2 * random.Unit() - 1;
      box.hi[k] = std::min(1.0, box.lo[k] + random.Unit());
    }
    std::set<geometry::Point<D>> wanted;
    for (const auto& p : all) {
      if (box.Contains(p)) wanted.insert(p);
    }
    const auto points = PointsIn(lattice, box);
    EXPECT_EQ(std::set(points.begin(), points.end()), wanted);
    EXPECT_EQ(points.size(), wanted.size()) << "a point came twice";
  }
}

TYPED_TEST(AnchorLatticeTest, PassesOverBallsThatDoNotMatterOnly) {
  constexpr int D = TypeParam();
  const AnchorLattice<D> lattice(-24);
  test::Random random(6);
  for (int i = 0; i < 20; ++i) {
    geometry::Point<D> c;
    for (int k = 0; k < D; ++k) c[k] = random.Unit();
    const double radius = 0.3 * random.Unit();
    const auto distance = [&](const geometry::Point<D>& p) {
      return std::sqrt(geometry::SquaredDistance(c, p));
    };
    std::set<geometry::Point<D>> wanted, found;
    std::size_t seen = 0;
    for (const auto& p : PointsIn(lattice, Cube<D>(0, 1))) {
      if (distance(p) <= radius) wanted.insert(p);
    }
    lattice.ForEachIn(
        Cube<D>(0, 1),
        [&](const geometry::Point<D>& p, double r) { return distance(p) <= radius + r; },
        [&](const auto&, const geometry::Point<D>& p) {
          ++seen;
          if (distance(p) <= radius) found.insert(p);
          return true;
        });
    EXPECT_EQ(found, wanted);
    EXPECT_LE(seen, 4 * wanted.size() + 200);
  }
}

// All lattices have the same name for a point, by the widest one that contains it.
TYPED_TEST(AnchorLatticeTest, HoldsThoseThatAreOctavesWider) {
  constexpr int D = TypeParam();
  using Lattice = AnchorLattice<D>;
  constexpr int kOctaves = 4;
  const auto box = Cube<D>(-1.7, 1.7);
  const auto all = [](const geometry::Point<D>&, double) { return true; };
  for (int finest = -24; finest < -16; ++finest) {
    std::map<geometry::Point<D>, std::set<int>> places;
    std::map<geometry::Point<D>, typename Lattice::Node> names;
    for (int octave = 0; octave < kOctaves; ++octave) {
      const int level = finest + octave * Lattice::kOctave;
      EXPECT_TRUE(Lattice::AreNested(finest, level));
      EXPECT_FALSE(Lattice::AreNested(finest, level + 3));
      Lattice(level).ForEachIn(
          box, all, [&](const typename Lattice::Index& index, const geometry::Point<D>& p) {
            places[p].insert(octave);
            const auto name = Lattice::NodeOf(level, index);
            EXPECT_EQ(Lattice(name.level).At(name.index), p);
            EXPECT_EQ(names.emplace(p, name).first->second, name);
            return true;
          });
    }
    for (const auto& [p, octaves] : places) {
      const int widest = *octaves.rbegin();
      EXPECT_EQ(static_cast<int>(octaves.size()), widest + 1) << "a finer lattice lacks a point";
      const int level = finest + widest * Lattice::kOctave;
      if (widest + 1 < kOctaves)
        EXPECT_EQ(names.at(p).level, level);
      else
        EXPECT_GE(names.at(p).level, level);
    }
  }
}

TYPED_TEST(AnchorLatticeTest, NothingFinerReachesTheLeastLevelsDistance) {
  constexpr int D = TypeParam();
  using Lattice = AnchorLattice<D>;
  test::Random random(8);
  for (int i = 0; i < 1000; ++i) {
    const double distance = std::ldexp(1 + random.Unit(), random.Below(200) - 100);
    const int level = Lattice::LeastLevelAt(distance);
    EXPECT_LT(Lattice::MostReach(level - 1), distance);
    EXPECT_GE(Lattice::MostReach(level + 1), distance);
    for (int own = level - 20; own < level; ++own) {
      EXPECT_LT(Lattice::Reach(own, level - 1), distance);
      EXPECT_LE(Lattice::Reach(own, level), Lattice::MostReach(level));
    }
  }
}

TEST(AnchorLattice, EndsWhenAskedTo) {
  int seen = 0;
  EXPECT_FALSE(AnchorLattice<2>(-80).ForEachIn(
      Cube<2>(0, 1), [](const geometry::Point2&, double) { return true; },
      [&](const auto&, const geometry::Point2&) { return ++seen < 10; }));
  EXPECT_EQ(seen, 10);
}

}  // namespace
}  // namespace dynmesh::meshing::anchor_lattice_test
