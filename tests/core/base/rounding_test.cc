#include "core/base/rounding.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dynmesh {
namespace {

TEST(Rounding, UlpIsTheSpacingOfDoubles) {
  for (const double x : {1.0, 1.5, std::nextafter(2.0, 0), 2.0, 1e-9, 0x1p200}) {
    EXPECT_EQ(UlpOf(x), std::nextafter(x, INFINITY) - x);
  }
}

TEST(Rounding, TheUlpOfABoxIsThatOfItsLargestCoordinate) {
  EXPECT_EQ(UlpOf(Box{{-5, 0, 0}, {1, 3.9, 0}}, 2), 0x1p-50);
  EXPECT_EQ(UlpOf(Box{{-5, 0, 0}, {8, 3.9, 0}}, 2), 0x1p-49);
  EXPECT_EQ(UlpOf(Box{{-5, 0, -99}, {1, 3.9, 99}}, 2), 0x1p-50) << "z does not count";
}

// Meshes depend on each bit of the slack.
TEST(Rounding, QualitySlackIsThatOfTheLeastLengthOfItsBinade) {
  EXPECT_DOUBLE_EQ(QualitySlackAt(0, 0x1p-50), 2e-9 + 0x1p-47);
  EXPECT_DOUBLE_EQ(QualitySlackAt(-80, 0x1p-50), 2e-9 + 0x1p-7);
  for (int k = -1022; k <= 1023; ++k) {
    EXPECT_EQ(QualitySlackAt(k, 0x1p-50), 2e-9 + 8 * 0x1p-50 / std::sqrt(std::ldexp(1.0, k))) << k;
  }
}

}  // namespace
}  // namespace dynmesh
