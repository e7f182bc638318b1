// Which boxes a feature meets, against exact or slow answers.
#include "core/quadtree/shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <random>

namespace dynmesh::quadtree {
namespace {

using geometry::Point2;
using geometry::Point3;

constexpr std::uint64_t kSeed = 24;
constexpr int kSide = 6;

// Integers, in which clipping with fractions is exact: does segment pq meet [lo, hi]?
template <int D>
bool MeetsSlowly(const geometry::Point<D>& p, const geometry::Point<D>& q, const Box<D>& box) {
  // The interval [a / c, b / d] of parameters within all slabs, denominators > 0.
  long a = 0, c = 1, b = 1, d = 1;
  for (int k = 0; k < D; ++k) {
    const long from = static_cast<long>(p[k]), along = static_cast<long>(q[k]) - from;
    long lo = static_cast<long>(box.lo[k]) - from, hi = static_cast<long>(box.hi[k]) - from;
    if (along == 0) {
      if (lo > 0 || hi < 0) return false;
      continue;
    }
    const long step = along > 0 ? along : -along;
    if (along < 0) std::swap(lo, hi), lo = -lo, hi = -hi;
    if (lo * c > a * step) a = lo, c = step;
    if (hi * d < b * step) b = hi, d = step;
  }
  return a * d <= b * c;
}

template <int D>
void ExpectExactOnIntegers() {
  std::mt19937_64 random(kSeed);
  std::uniform_int_distribution<int> any(0, kSide);
  const auto point = [&] {
    geometry::Point<D> p;
    for (int k = 0; k < D; ++k) p[k] = any(random);
    return p;
  };
  int met = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto p = point(), q = point(), r = point(), s = point();
    Box<D> box;
    for (int k = 0; k < D; ++k) box.lo[k] = std::min(r[k], s[k]), box.hi[k] = std::max(r[k], s[k]);
    const bool expected = MeetsSlowly<D>(p, q, box);
    ASSERT_EQ(MeetsSegment(p, q, box), expected) << i;
    ASSERT_EQ(MeetsSegment(q, p, box), expected) << i;
    met += expected ? 1 : 0;
  }
  EXPECT_GT(met, 2'000);
  EXPECT_LT(met, 18'000);
}

TEST(Shape, SegmentsMeetBoxesExactly) { ExpectExactOnIntegers<2>(); }
TEST(Shape, SegmentsMeetBoxesExactlyIn3D) { ExpectExactOnIntegers<3>(); }

// Integers again: ends lie on borders, corners and middles of cells.
template <int D>
void ExpectChildrenMet() {
  std::mt19937_64 random(kSeed);
  std::uniform_int_distribution<int> any(-2, 10);
  Halves<D> cell;
  cell.lo.c.fill(0), cell.middle.c.fill(4), cell.hi.c.fill(8);
  const Box<D> box = {cell.lo, cell.hi};
  int met_some = 0, passed_by = 0;
  for (int i = 0; i < 40'000; ++i) {
    geometry::Point<D> p, q;
    for (int k = 0; k < D; ++k) p[k] = any(random), q[k] = any(random);
    const bool is_point = i % 4 == 0 || p == q;
    const Shape<D> shape = is_point ? Shape<D>::OfPoint(p, 0) : Shape<D>::OfSegment(p, q, 0, 1);
    if (!shape.Meets(box)) {
      passed_by += shape.MayMeet(box) ? 1 : 0;
      continue;
    }
    ASSERT_TRUE(shape.MayMeet(box)) << i;
    std::uint32_t expected = 0;
    for (int which = 0; which < Cell<D>::kChildren; ++which) {
      if (shape.Meets(cell.Child(which))) expected |= 1u << which;
    }
    ASSERT_EQ(shape.ChildrenMet(cell), expected) << i;
    met_some += std::has_single_bit(expected) ? 0 : 1;
  }
  EXPECT_GT(met_some, 2'000);
  EXPECT_GT(passed_by, 10);
  EXPECT_LT(passed_by, 4'000);
}

TEST(Shape, ChildrenMetAreThoseThatItMeets) { ExpectChildrenMet<2>(); }
TEST(Shape, ChildrenMetAreThoseThatItMeetsIn3D) { ExpectChildrenMet<3>(); }

// A square with a square hole in a plane askew, against points of it that are in the box.
TEST(Shape, AFacetMeetsBoxesThatHoldPointsOfIt) {
  const Point3 origin{{0.1, 0.2, 0.3}}, x{{0.6, 0.1, 0.2}}, y{{-0.1, 0.5, 0.15}};
  const auto at = [&](double a, double b) {
    Point3 p;
    for (int k = 0; k < 3; ++k) p[k] = origin[k] + a * x[k] + b * y[k];
    return p;
  };
  const FacetShape facet({{at(0, 0), at(1, 0), at(1, 1), at(0, 1)},
                          {at(0.3, 0.3), at(0.6, 0.3), at(0.6, 0.6), at(0.3, 0.6)}},
                         {0, 1, 2, 3, 4, 5, 6, 7});
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> any(0, 1);
  int met = 0, held = 0;
  for (int i = 0; i < 2'000; ++i) {
    Box<3> box;
    const double side = std::exp2(-1 - 5 * any(random));
    for (int k = 0; k < 3; ++k) box.lo[k] = any(random) - side / 2, box.hi[k] = box.lo[k] + side;
    bool holds = false;
    constexpr int kSteps = 100;
    for (int a = 0; a <= kSteps && !holds; ++a) {
      for (int b = 0; b <= kSteps && !holds; ++b) {
        const double u = static_cast<double>(a) / kSteps, v = static_cast<double>(b) / kSteps;
        if (u > 0.301 && u < 0.599 && v > 0.301 && v < 0.599) continue;
        holds = box.Holds(at(u, v));
      }
    }
    const bool meets = facet.Meets(box);
    ASSERT_TRUE(meets || !holds) << i;
    met += meets ? 1 : 0;
    held += holds ? 1 : 0;
  }
  // Boxes that it meets, but in none of the points.
  EXPECT_GT(held, 200);
  EXPECT_LT(met - held, held / 10);
}

}  // namespace
}  // namespace dynmesh::quadtree
