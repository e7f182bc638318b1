#include "client/cleaning/point_places.h"

#include <random>

#include "gtest/gtest.h"

namespace dynmesh::cleaning {
namespace {

TEST(PointPlaces, NearAgreesWithLookingAtAll) {
  constexpr double kTolerance = 0.02;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  PointPlaces places(kTolerance);
  for (int i = 0; i < 5000; ++i) {
    const Point p = {coordinate(random), coordinate(random)};
    std::optional<Place> expected;
    for (Place v = 0; v < places.size(); ++v) {
      const double distance = SquaredDistance(p, places.at(v));
      if (distance >= kTolerance * kTolerance) continue;
      if (!expected || distance < SquaredDistance(p, places.at(*expected))) expected = v;
    }
    const std::optional<Place> near = places.Near(p);
    // Exactly at the tolerance it may count as either.
    ASSERT_EQ(near, expected) << p[0] << " " << p[1];
    if (!near) places.Add(p);
  }
  EXPECT_GT(places.size(), 1000U);
}

}  // namespace
}  // namespace dynmesh::cleaning
