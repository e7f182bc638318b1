// The nearest relevant feature, against examining all of them.
#include "core/meshing/input_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::meshing::input_features_test {
namespace {

template <class D>
class InputFeaturesTest : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(InputFeaturesTest, Dimensions);

template <int D>
geometry::Point<D> RandomPoint(test::Random& random) {
  geometry::Point<D> p;
  for (int k = 0; k < D; ++k) p[k] = random.Unit();
  return p;
}

// Points, short and long segments, and many segments at one point.
template <int D>
InputFeature<D> RandomFeature(std::uint32_t id, test::Random& random) {
  const auto p = RandomPoint<D>(random);
  if (random.OneIn(3)) return {2 * id, 2 * id, p, p};
  if (random.OneIn(3)) {
    geometry::Point<D> hub;
    for (int k = 0; k < D; ++k) hub[k] = 0.3;
    return {0, 2 * id + 1, hub, p};
  }
  auto q = RandomPoint<D>(random);
  const double part = std::ldexp(1.0, -random.Below(8));
  for (int k = 0; k < D; ++k) q[k] = p[k] + part * (q[k] - p[k]);
  return {2 * id, 2 * id + 1, p, q};
}

using Ends = std::array<std::uint32_t, 2>;

// Of those that have none of the ends.
template <int D>
double NaiveNearest2(const std::vector<InputFeature<D>>& features, const geometry::Point<D>& x,
                     const Ends& ends) {
  double best = INFINITY;
  for (const auto& f : features) {
    if (f.IsDisjoint(ends[0], ends[1])) {
      best = std::min(best, geometry::SquaredDistance(x, f.p, f.q));
    }
  }
  return best;
}

TYPED_TEST(InputFeaturesTest, NearestIsThatOfAllAfterAnyEdits) {
  constexpr int D = TypeParam();
  const std::uint64_t seed = 8;
  test::Random random(seed);
  geometry::Point<D> lo, hi;
  for (int k = 0; k < D; ++k) lo[k] = -1, hi[k] = 2;
  InputFeatures<D> index(lo, hi);
  std::vector<InputFeature<D>> features;
  for (std::uint32_t step = 1; step < 1500; ++step) {
    if (features.size() > 20 && random.OneIn(step < 900 ? 4 : 2)) {
      const auto i = static_cast<std::size_t>(random.Below(static_cast<int>(features.size())));
      index.Remove(features[i]);
      features[i] = features.back();
      features.pop_back();
    } else {
      features.push_back(RandomFeature<D>(step, random));
      index.Add(features.back());
    }
    const auto x = RandomPoint<D>(random);
    double r2 = random.OneIn(2) ? INFINITY : 0.1 * random.Unit();
    const double within = r2;
    double best = INFINITY;
    Ends ends = {index.kNone, index.kNone};
    if (!features.empty() && random.OneIn(2)) {
      const auto& f =
          features[static_cast<std::size_t>(random.Below(static_cast<int>(features.size())))];
      ends = {f.a, f.b};
    }
    index.VisitNear(
        x, r2, ends, [](const geometry::Point<D>&, double) { return true; },
        [&](const InputFeature<D>& f) {
          if (!f.IsDisjoint(ends[0], ends[1])) return;
          best = std::min(best, geometry::SquaredDistance(x, f.p, f.q));
          r2 = std::min(r2, best);
        });
    const double wanted = NaiveNearest2(features, x, ends);
    if (wanted < within) {
      ASSERT_EQ(best, wanted) << "seed " << seed << " step " << step;
    } else {
      ASSERT_GE(best, within);
    }
  }
}

// With thousands of segments at a point, none is queried for a subsegment of one of them.
TEST(InputFeatures, SegmentsAtOnePointAreNotAskedForOneOfThem) {
  InputFeatures<2> index({{-1, -1}}, {{1, 1}});
  for (std::uint32_t i = 1; i <= 1000; ++i) {
    const double turn = 0.00628 * i;
    index.Add({0, i, {{0, 0}}, {{0.5 * std::cos(turn), 0.5 * std::sin(turn)}}});
  }
  index.Add({2000, 2000, {{0.1, 0.1}}, {{0.1, 0.1}}});
  const double within2 = 0.01;
  for (const auto& [ends, asked] : {std::pair(Ends{0, 7}, 0), {Ends{2001, 2002}, 1}}) {
    int visits = 0;
    index.VisitNear(
        {{-0.3, -0.2}}, within2, ends, [](const geometry::Point<2>&, double) { return true; },
        [&](const InputFeature<2>&) { ++visits; });
    EXPECT_GE(visits, asked);
    EXPECT_LE(visits, 1001 * asked);
  }
}

// Any number of segments at a point causes no further cells.
TEST(InputFeatures, SegmentsAtOnePointAreListedOnceEach) {
  InputFeatures<2> index({{-1, -1}}, {{1, 1}});
  const std::size_t before = index.bytes();
  for (std::uint32_t i = 1; i <= 1000; ++i) {
    const double turn = 0.00628 * i;
    index.Add({0, i, {{0, 0}}, {{0.5 * std::cos(turn), 0.5 * std::sin(turn)}}});
  }
  EXPECT_LE(index.bytes() - before, 3000 * sizeof(InputFeature<2>));
}

}  // namespace
}  // namespace dynmesh::meshing::input_features_test
