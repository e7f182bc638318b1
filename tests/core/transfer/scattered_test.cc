#include "core/transfer/scattered.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "tests/support/seed.h"

namespace dynmesh::transfer {
namespace {

std::mt19937_64 MakeRandom() { return std::mt19937_64(test::NewSeed()); }

std::vector<double> AnyPositions(std::mt19937_64& random, int dimension, std::size_t count,
                                 double lo, double hi) {
  std::uniform_real_distribution<double> coordinate(lo, hi);
  std::vector<double> positions;
  for (std::size_t i = 0; i < count * static_cast<std::size_t>(dimension); ++i) {
    positions.push_back(coordinate(random));
  }
  return positions;
}

TEST(Scattered, ReproducesLinearFieldsInTheHull) {
  std::mt19937_64 random = MakeRandom();
  for (const int dimension : {2, 3}) {
    const auto d = static_cast<std::size_t>(dimension);
    std::vector<double> sources = AnyPositions(random, dimension, 200, 0, 1);
    for (unsigned corner = 0; corner < 1U << d; ++corner) {  // the hull is the unit box
      for (std::size_t k = 0; k < d; ++k) sources.push_back(corner >> k & 1);
    }
    const auto field = [&](const double* x) {
      return std::array{x[0] - 3 * x[1] + (d == 3 ? 2 * x[2] : 0) + 5, 0.25};
    };
    std::vector<double> values;
    for (std::size_t i = 0; i < sources.size(); i += d) {
      for (const double value : field(&sources[i])) values.push_back(value);
    }
    const std::vector<double> targets = AnyPositions(random, dimension, 500, 0, 1);
    const std::vector<double> found = InterpolateScattered(dimension, sources, values, targets);
    ASSERT_EQ(found.size(), 1000U);
    for (std::size_t i = 0; i < 500; ++i) {
      EXPECT_NEAR(found[2 * i], field(&targets[d * i])[0], 1e-12);
      EXPECT_EQ(found[2 * i + 1], 0.25);
    }
  }
}

TEST(Scattered, KeepsTheValuesOfSourcesAndTheirRange) {
  std::mt19937_64 random = MakeRandom();
  for (const int dimension : {2, 3}) {
    const std::vector<double> sources = AnyPositions(random, dimension, 60, 0, 1);
    const std::vector<double> values = AnyPositions(random, 1, 60, -4, 9);
    EXPECT_EQ(InterpolateScattered(dimension, sources, values, sources), values);
    const auto far = AnyPositions(random, dimension, 300, -3, 5);
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    for (const double value : InterpolateScattered(dimension, sources, values, far)) {
      EXPECT_GE(value, *least);
      EXPECT_LE(value, *most);
    }
  }
}

TEST(Scattered, TakesFewAndDegenerateSources) {
  const std::vector<double> one = {3, 4}, value = {7};
  EXPECT_EQ(InterpolateScattered(2, one, value, std::vector<double>{0, 0, 3, 4, 100, -5}),
            (std::vector<double>{7, 7, 7}));
  // All on a line: linear along it.
  const std::vector<double> line = {0, 0, 0, 1, 1, 1, 4, 4, 4}, values = {0, 1, 4};
  const auto found =
      InterpolateScattered(3, line, values, std::vector<double>{.5, .5, .5, 2, 2, 2});
  EXPECT_NEAR(found[0], 0.5, 1e-14);
  EXPECT_NEAR(found[1], 2, 1e-14);
  EXPECT_TRUE(InterpolateScattered(2, one, value, {}).empty());
}

}  // namespace
}  // namespace dynmesh::transfer
