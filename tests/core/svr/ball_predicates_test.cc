// Predicates of any dimension, against those of 2D and 3D and against exact rationals.
#include "tests/core/svr/variants/ball_predicates.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "core/geometry/space_predicates.h"

namespace dynmesh::geometry::ball_predicates_test {
namespace {

constexpr std::uint64_t kSeed = 24;

// Few different values, so that there are many ties; any; tiny differences.
double Coordinate(int mode, std::mt19937_64& random) {
  if (mode == 0) return static_cast<double>(random() % 4);
  if (mode == 1) return std::uniform_real_distribution<double>(-1, 1)(random);
  return static_cast<double>(random() % 3) * 0x1p-40 + static_cast<double>(random() % 2);
}
// Distinct points.
template <int D, std::size_t N>
std::array<Point<D>, N> RandomPoints(int mode, std::mt19937_64& random) {
  while (true) {
    std::array<Point<D>, N> p;
    for (auto& q : p) {
      for (double& x : q.c) x = Coordinate(mode, random);
    }
    bool distinct = true;
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < i; ++j) distinct = distinct && !(p[i] == p[j]);
    }
    if (distinct) return p;
  }
}

TEST(BallPredicates, AreThoseOf2D) {
  std::mt19937_64 random(kSeed);
  for (int i = 0; i < 30'000; ++i) {
    auto p = RandomPoints<2, 4>(i % 3, random);
    const int side = Orientation(p[0], p[1], p[2]);
    ASSERT_EQ(OrientationOf<2>({&p[0], &p[1], &p[2]}), side);
    if (side == 0) continue;
    if (side < 0) std::swap(p[0], p[1]);
    ASSERT_EQ(InBall<2>({&p[0], &p[1], &p[2]}, p[3]), InCircle(p[0], p[1], p[2], p[3]));
  }
}

TEST(BallPredicates, AreThoseOf3D) {
  std::mt19937_64 random(kSeed);
  for (int i = 0; i < 30'000; ++i) {
    auto p = RandomPoints<3, 5>(i % 3, random);
    const int side = Orientation(p[0], p[1], p[2], p[3]);
    ASSERT_EQ(OrientationOf<3>({&p[0], &p[1], &p[2], &p[3]}), side);
    if (side == 0) continue;
    if (side < 0) std::swap(p[0], p[1]);
    ASSERT_EQ(InBall<3>({&p[0], &p[1], &p[2], &p[3]}, p[4]),
              InSphere(p[0], p[1], p[2], p[3], p[4]));
  }
}

// By Gauss's elimination in rationals.
template <std::size_t N>
int SignOfDeterminant(std::array<std::array<mpq_class, N>, N> m) {
  int sign = 1;
  for (std::size_t column = 0; column < N; ++column) {
    std::size_t pivot = column;
    while (pivot < N && m[pivot][column] == 0) ++pivot;
    if (pivot == N) return 0;
    if (pivot != column) std::swap(m[pivot], m[column]), sign = -sign;
    if (m[column][column] < 0) sign = -sign;
    for (std::size_t i = column + 1; i < N; ++i) {
      const mpq_class factor = m[i][column] / m[column][column];
      for (std::size_t k = column; k < N; ++k) m[i][k] -= factor * m[column][k];
    }
  }
  return sign;
}

TEST(BallPredicates, AreExactIn4D) {
  std::mt19937_64 random(kSeed);
  int ties = 0;
  for (int i = 0; i < 6'000; ++i) {
    auto p = RandomPoints<4, 6>(i % 3, random);
    std::array<std::array<mpq_class, 4>, 4> rows;
    for (std::size_t r = 0; r < 4; ++r) {
      for (int k = 0; k < 4; ++k)
        rows[r][static_cast<std::size_t>(k)] = mpq_class(p[r + 1][k]) - mpq_class(p[0][k]);
    }
    const int side = SignOfDeterminant(rows);
    ASSERT_EQ(OrientationOf<4>({&p[0], &p[1], &p[2], &p[3], &p[4]}), side);
    if (side == 0) continue;
    if (side < 0) std::swap(p[0], p[1]);
    // The lifted points: x and |x|^2, from the sixth.
    std::array<std::array<mpq_class, 5>, 5> lifted;
    for (std::size_t r = 0; r < 5; ++r) {
      lifted[r][4] = 0;
      for (int k = 0; k < 4; ++k) {
        const mpq_class x = mpq_class(p[r][k]) - mpq_class(p[5][k]);
        lifted[r][static_cast<std::size_t>(k)] = x;
        lifted[r][4] += x * x;
      }
    }
    // Of a positive simplex it is positive for a point inside, in 4D.
    const int expected = SignOfDeterminant(lifted);
    const bool inside = InBall<4>({&p[0], &p[1], &p[2], &p[3], &p[4]}, p[5]);
    if (expected == 0) {
      ++ties;
    } else {
      ASSERT_EQ(inside, expected > 0);
    }
    // Even permutations change nothing, at ties neither.
    ASSERT_EQ((InBall<4>({&p[1], &p[2], &p[0], &p[3], &p[4]}, p[5])), inside);
    ASSERT_EQ((InBall<4>({&p[0], &p[1], &p[3], &p[4], &p[2]}, p[5])), inside);
  }
  EXPECT_GT(ties, 10);
}

}  // namespace
}  // namespace dynmesh::geometry::ball_predicates_test
