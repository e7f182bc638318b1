// Exact signed integers of a fixed number of 64-bit limbs, and the conversion from doubles. Any
// handful of doubles are integers in a common power-of-two unit. So a polynomial predicate is an
// integer polynomial, with an obvious sign.
//
// Why integers and not floating-point expansions: the domain of the predicates (magnitudes 2^-250
// .. 2^250, hence units down to 2^-302) makes products of four differences multiples of 2^-1208,
// below the least double. Expansions would lose them. Integers have no underflow, the number of
// limbs follows from the inputs (one for an ordinary mesh), and each bound is one line.
//
// Pure values, thread-safe. Multiplication is O(N M).
#ifndef DYNMESH_CORE_GEOMETRY_EXACT_INTEGER_H_
#define DYNMESH_CORE_GEOMETRY_EXACT_INTEGER_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

namespace dynmesh::geometry {

__extension__ using Uint128 = unsigned __int128;
__extension__ using Int128 = __int128;

// Two's complement, least limb first: values in [-2^(64N-1), 2^(64N-1)). Sums and differences wrap;
// the caller's bounds exclude that.
template <int N>
struct WideInt {
  std::array<std::uint64_t, N> limb;

  bool negative() const { return (limb[N - 1] >> 63) != 0; }
  int Sign() const {
    if (negative()) return -1;
    for (std::uint64_t l : limb) {
      if (l != 0) return 1;
    }
    return 0;
  }

  friend WideInt operator+(const WideInt& a, const WideInt& b) {
    WideInt r;
    Uint128 carry = 0;
    for (int i = 0; i < N; ++i) {
      carry += static_cast<Uint128>(a.limb[i]) + b.limb[i];
      r.limb[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    return r;
  }

  friend WideInt operator-(const WideInt& a, const WideInt& b) {
    WideInt r;
    std::uint64_t borrow = 0;
    for (int i = 0; i < N; ++i) {
      const Uint128 d = static_cast<Uint128>(a.limb[i]) - b.limb[i] - borrow;
      r.limb[i] = static_cast<std::uint64_t>(d);
      borrow = static_cast<std::uint64_t>(d >> 64) & 1;
    }
    return r;
  }
};

// The whole product; never wraps.
template <int N, int M>
inline WideInt<N + M> operator*(const WideInt<N>& a, const WideInt<M>& b) {
  WideInt<N + M> r{};
  for (int i = 0; i < N; ++i) {
    std::uint64_t carry = 0;
    for (int j = 0; j < M; ++j) {
      const Uint128 t = static_cast<Uint128>(a.limb[i]) * b.limb[j] + r.limb[i + j] + carry;
      r.limb[i + j] = static_cast<std::uint64_t>(t);
      carry = static_cast<std::uint64_t>(t >> 64);
    }
    r.limb[i + M] = carry;
  }
  // So far the patterns were multiplied as unsigned. The pattern of a negative value is too great
  // by 2^(64N), so the product is too great by 2^(64N) b (and alike for b).
  const auto subtract_at = [&r](int at, const auto& x) {
    std::uint64_t borrow = 0;
    for (std::uint64_t l : x.limb) {
      const Uint128 d = static_cast<Uint128>(r.limb[at]) - l - borrow;
      r.limb[at++] = static_cast<std::uint64_t>(d);
      borrow = static_cast<std::uint64_t>(d >> 64) & 1;
    }
  };
  if (a.negative()) subtract_at(N, b);
  if (b.negative()) subtract_at(M, a);
  return r;
}

// No limbs: a native integer, for values that are known to fit. Sums and products keep the type.
template <>
struct WideInt<0> {
  Int128 value;

  bool negative() const { return value < 0; }
  int Sign() const { return value > 0 ? 1 : value < 0 ? -1 : 0; }
  friend WideInt operator+(const WideInt& a, const WideInt& b) { return {a.value + b.value}; }
  friend WideInt operator-(const WideInt& a, const WideInt& b) { return {a.value - b.value}; }
  friend WideInt operator*(const WideInt& a, const WideInt& b) { return {a.value * b.value}; }
};

// x = (-1)^negative mantissa 2^exponent, the mantissa with its hidden bit: below 2^53.
struct PartsOfDouble {
  std::uint64_t mantissa;
  int exponent;
  bool negative;
};
inline PartsOfDouble PartsOf(double x) {
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  const int biased = static_cast<int>(bits >> 52) & 2047;
  const std::uint64_t fraction = bits & ((std::uint64_t{1} << 52) - 1);
  // Subnormals have no hidden bit and share the exponent of biased = 1.
  return {biased != 0 ? fraction | (std::uint64_t{1} << 52) : fraction,
          (biased != 0 ? biased : 1) - 1075, (bits >> 63) != 0};
}

// A unit 2^exponent in which some finite doubles are integers of less than `width`
// bits: |x| < 2^(exponent + width).
struct CommonUnit {
  int exponent;
  int width;
};

inline CommonUnit FindCommonUnit(std::span<const double> values) {
  int low = 1 << 20;
  int high = -(1 << 20);
  for (double x : values) {
    const PartsOfDouble parts = PartsOf(x);
    if (parts.mantissa == 0) continue;
    low = std::min(low, parts.exponent + std::countr_zero(parts.mantissa));
    high = std::max(high, parts.exponent + 53);
  }
  if (low > high) return {0, 0};  // all zero
  return {low, high - low};
}

// x in the unit 2^exponent. REQUIRES: x is a multiple of the unit, |x| < 2^(exponent + 64N - 1).
template <int N>
inline WideInt<N> ToInteger(double x, int exponent) {
  WideInt<N> r{};
  const auto [mantissa, own_exponent, negative] = PartsOf(x);
  if (mantissa == 0) return r;
  const int shift = own_exponent - exponent;
  if (shift <= 0) {
    r.limb[0] = mantissa >> -shift;  // the bits that fall out are zeros
  } else {
    const int at = shift / 64;
    r.limb[at] = mantissa << (shift % 64);
    if (shift % 64 != 0 && at + 1 < N) r.limb[at + 1] = mantissa >> (64 - shift % 64);
  }
  return negative ? WideInt<N>{} - r : r;
}

template <>
inline WideInt<0> ToInteger<0>(double x, int exponent) {
  const auto [mantissa, own_exponent, negative] = PartsOf(x);
  if (mantissa == 0) return {0};
  const int shift = own_exponent - exponent;
  const Int128 magnitude = shift <= 0 ? Int128{mantissa >> -shift} : Int128{mantissa} << shift;
  return {negative ? -magnitude : magnitude};
}

// mantissa * 2^exponent, 0 or 1 <= |mantissa| < 2.
struct ScaledDouble {
  double mantissa;
  int exponent;
};

// x with a relative error of at most 2^-52.
template <int N>
inline ScaledDouble ToScaledDouble(const WideInt<N>& x) {
  if (x.Sign() == 0) return {0, 0};
  const WideInt<N> magnitude = x.negative() ? WideInt<N>{} - x : x;
  int top = N - 1;
  while (magnitude.limb[top] == 0) --top;
  const int zeros = std::countl_zero(magnitude.limb[top]);
  std::uint64_t bits = magnitude.limb[top] << zeros;
  if (zeros > 0 && top > 0) bits |= magnitude.limb[top - 1] >> (64 - zeros);
  const double mantissa = static_cast<double>(bits >> 11) * 0x1p-52;
  return {x.negative() ? -mantissa : mantissa, 64 * top + 63 - zeros};
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_EXACT_INTEGER_H_
