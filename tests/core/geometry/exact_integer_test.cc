// Fixed-size integers against 128-bit arithmetic and against rationals.
#include "core/geometry/exact_integer.h"

#include <CGAL/Exact_rational.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tests/core/geometry/random_points.h"

namespace dynmesh::geometry::exact_integer_test {
namespace {

using Q = CGAL::Exact_rational;

template <int N>
Q ToRational(const WideInt<N>& x) {
  Q sum = 0, unit = 1;
  for (const std::uint64_t limb : x.limb) {
    sum += unit * (Q(double(limb >> 32)) * Q(0x1p32) + Q(double(limb & 0xffffffff)));
    unit *= Q(0x1p64);
  }
  return x.negative() ? sum - unit : sum;
}

// Random limbs, many of them all zeros or all ones, where carries run far.
template <int N>
WideInt<N> RandomInt(std::mt19937_64& random) {
  WideInt<N> x;
  for (auto& limb : x.limb) {
    const int how = static_cast<int>(random() % 4);
    limb = how == 0 ? 0 : how == 1 ? ~std::uint64_t{0} : random();
  }
  return x;
}

template <int N, int M>
void ExpectArithmeticIsExact(std::mt19937_64& random) {
  for (int i = 0; i < 2000; ++i) {
    const auto a = RandomInt<N>(random);
    const auto b = RandomInt<M>(random);
    ASSERT_EQ(ToRational(a * b), ToRational(a) * ToRational(b));
    const auto c = RandomInt<N>(random);
    const Q wrap = ToRational(WideInt<N + 1>{}) + [] {
      Q unit = 1;
      for (int k = 0; k < N; ++k) unit *= Q(0x1p64);
      return unit;
    }();
    const Q sum = ToRational(a) + ToRational(c), difference = ToRational(a) - ToRational(c);
    const auto same_mod_wrap = [&](const Q& x, const Q& y) {
      return x == y || x == y + wrap || x == y - wrap;
    };
    ASSERT_TRUE(same_mod_wrap(ToRational(a + c), sum));
    ASSERT_TRUE(same_mod_wrap(ToRational(a - c), difference));
    const Q value = ToRational(a);
    ASSERT_EQ(a.Sign(), value > 0 ? 1 : value < 0 ? -1 : 0);
  }
}

TEST(ExactInteger, SumsDifferencesAndProductsAreExact) {
  const std::uint64_t seed = testing::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  ExpectArithmeticIsExact<1, 1>(random);
  ExpectArithmeticIsExact<2, 2>(random);
  ExpectArithmeticIsExact<4, 2>(random);
  ExpectArithmeticIsExact<2, 4>(random);
  ExpectArithmeticIsExact<9, 9>(random);
}

template <int N>
void ExpectScaledDoubleIsNear(std::mt19937_64& random) {
  for (int i = 0; i < 500; ++i) {
    auto a = RandomInt<N>(random);
    for (std::size_t k = random() % (N + 1); k < N; ++k) a.limb[k] = 0;  // small ones, too
    const Q value = ToRational(a);
    const ScaledDouble scaled = ToScaledDouble(a);
    Q unit = 1;
    for (int k = 0; k < std::abs(scaled.exponent); ++k) unit *= 2;
    const Q near =
        scaled.exponent < 0 ? Q(Q(scaled.mantissa) / unit) : Q(Q(scaled.mantissa) * unit);
    const Q error = near < value ? Q(value - near) : Q(near - value);
    ASSERT_LE(error * Q(0x1p52), value < 0 ? Q(-value) : value);
  }
}

TEST(ExactInteger, ScaledDoublesAreNear) {
  const std::uint64_t seed = testing::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  ExpectScaledDoubleIsNear<1>(random);
  ExpectScaledDoubleIsNear<2>(random);
  ExpectScaledDoubleIsNear<27>(random);
}

TEST(ExactInteger, CommonUnitHoldsEveryDoubleExactly) {
  const std::uint64_t seed = testing::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  testing::PointSource<2> source(testing::Kind::kWildExponents, seed);
  for (int i = 0; i < 5000; ++i) {
    const Point2 p = source.Next();
    const CommonUnit unit = FindCommonUnit(p.c);
    ASSERT_LE(unit.width, 553);
    for (const double x : p.c) {
      const auto integer = ToInteger<9>(x, unit.exponent);
      const Q scale = unit.exponent < 0 ? Q(1) / Q(std::ldexp(1, -unit.exponent))
                                        : Q(std::ldexp(1, unit.exponent));
      ASSERT_EQ(ToRational(integer) * scale, Q(x));
      ASSERT_LT(std::fabs(x), std::ldexp(1, unit.exponent + unit.width) + (x == 0));
    }
  }
}

TEST(ExactInteger, NativeOnesAreTheSame) {
  const std::uint64_t seed = testing::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  testing::PointSource<2> source(testing::Kind::kNative, seed);
  const auto same = [](const WideInt<0>& native, const Q& value) {
    return Q(static_cast<double>(native.value)) == value;  // below 2^53
  };
  for (int i = 0; i < 5000; ++i) {
    const double shift = std::ldexp(1, static_cast<int>(seed % 40) - 20);
    const Point2 p = source.Next();
    const double x = p[0] * shift, y = p[1] * shift;
    const int exponent = static_cast<int>(seed % 40) - 20;
    const auto a = ToInteger<0>(x, exponent), b = ToInteger<0>(y, exponent);
    ASSERT_TRUE(same(a, Q(p[0])) && same(b, Q(p[1])));
    ASSERT_TRUE(same(a + b, Q(p[0]) + Q(p[1])) && same(a - b, Q(p[0]) - Q(p[1])));
    ASSERT_TRUE(same(a * b, Q(p[0]) * Q(p[1])));
    ASSERT_EQ(a.Sign(), p[0] > 0 ? 1 : p[0] < 0 ? -1 : 0);
    ASSERT_EQ(a.negative(), p[0] < 0);
  }
}

TEST(ExactInteger, SmallWidthsFitOneLimb) {
  const CommonUnit unit = FindCommonUnit(std::array{0.75, -3.0, 0.0, 8.0});
  EXPECT_EQ(unit.exponent, -2);
  EXPECT_LE(unit.width, 60);
  EXPECT_EQ(ToRational(ToInteger<1>(-3.0, unit.exponent)), Q(-12));
  EXPECT_EQ(ToRational(ToInteger<1>(8.0, unit.exponent)), Q(32));
  EXPECT_EQ(ToRational(ToInteger<1>(-0.0, unit.exponent)), Q(0));
}

}  // namespace
}  // namespace dynmesh::geometry::exact_integer_test
