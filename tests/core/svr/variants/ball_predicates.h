// Exact orientation and in-ball tests in any fixed dimension, by cofactors: O(D!) products. In 2D
// and 3D predicates.h and space_predicates.h are faster; the answers are the same. Pure,
// thread-safe.
//
// Coordinates are 0 or of magnitude 2^-250 to 2^250.
#ifndef DYNMESH_TESTS_CORE_SVR_VARIANTS_BALL_PREDICATES_H_
#define DYNMESH_TESTS_CORE_SVR_VARIANTS_BALL_PREDICATES_H_

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <span>

#include "core/geometry/exact_integer.h"
#include "core/geometry/exact_vector.h"
#include "core/geometry/point.h"
#include "core/geometry/predicates.h"

namespace dynmesh::geometry {
namespace internal {

template <int N, int D>
using ExactRows = std::array<std::array<WideInt<N>, D>, D>;

// The determinant of the rows from `row` on, with the K columns that `columns` lists. Of K factors
// below 2^(64N-2) there are K! products: K N limbs suffice for K <= 4.
template <int K, int N, int D>
WideInt<K * N> ExactDeterminant(const ExactRows<N, D>& m, int row,
                                const std::array<int, K>& columns) {
  if constexpr (K == 1) {
    return m[row][columns[0]];
  } else {
    WideInt<K * N> sum{};
    for (int i = 0; i < K; ++i) {
      std::array<int, K - 1> others;
      std::copy(columns.begin(), columns.begin() + i, others.begin());
      std::copy(columns.begin() + i + 1, columns.end(), others.begin() + i);
      const auto term = m[row][columns[i]] * ExactDeterminant<K - 1, N, D>(m, row + 1, others);
      sum = i % 2 == 0 ? sum + term : sum - term;
    }
    return sum;
  }
}

// The same in doubles, with the sum of its products' magnitudes.
struct RoundedDeterminant {
  double value, sum;
};
template <int K, int D>
RoundedDeterminant Determinant(const std::array<std::array<double, D>, D>& m, int row,
                               const std::array<int, K>& columns) {
  if constexpr (K == 1) {
    return {m[row][columns[0]], std::fabs(m[row][columns[0]])};
  } else {
    RoundedDeterminant all{0, 0};
    for (int i = 0; i < K; ++i) {
      std::array<int, K - 1> others;
      std::copy(columns.begin(), columns.begin() + i, others.begin());
      std::copy(columns.begin() + i + 1, columns.end(), others.begin() + i);
      const RoundedDeterminant minor = Determinant<K - 1, D>(m, row + 1, others);
      const double x = m[row][columns[i]];
      all.value += i % 2 == 0 ? x * minor.value : -x * minor.value;
      all.sum += std::fabs(x) * minor.sum;
    }
    return all;
  }
}

template <int D>
constexpr std::array<int, D> AllColumns() {
  std::array<int, D> columns;
  for (int i = 0; i < D; ++i) columns[i] = i;
  return columns;
}

// Calls polynomial(limbs as a constant, exponent) with the fewest limbs that suffice.
template <int D, std::size_t P, class Polynomial>
int ExactSign(const std::array<const Point<D>*, P>& points, Polynomial polynomial) {
  std::array<double, P * D> coordinates;
  std::size_t count = 0;
  for (const Point<D>* p : points) {
    for (const double x : p->c) coordinates[count++] = x;
  }
  const CommonUnit unit = FindCommonUnit(coordinates);
  if (unit.width <= MaxWidth(1)) return polynomial(std::integral_constant<int, 1>(), unit.exponent);
  if (unit.width <= MaxWidth(2)) return polynomial(std::integral_constant<int, 2>(), unit.exponent);
  assert(unit.width <= MaxWidth(kMaxLimbs));
  return polynomial(std::integral_constant<int, kMaxLimbs>(), unit.exponent);
}

template <int N, int D>
ExactRows<N, D> RowsFrom(const Point<D>& origin, const std::array<const Point<D>*, D>& to,
                         int exponent) {
  ExactRows<N, D> rows;
  for (int i = 0; i < D; ++i) rows[i] = Vector<N, D>(origin, *to[i], exponent).c;
  return rows;
}

}  // namespace internal

// The sign of the determinant of p1 - p0, ..., pD - p0. In 2D and 3D that of Orientation. Exact.
template <int D>
int OrientationOf(const std::array<const Point<D>*, D + 1>& p) {
  static_assert(D <= 4);
  std::array<std::array<double, D>, D> rows;
  std::array<const Point<D>*, D> to;
  for (int i = 0; i < D; ++i) {
    to[i] = p[i + 1];
    for (int k = 0; k < D; ++k) rows[i][k] = (*p[i + 1])[k] - (*p[0])[k];
  }
  const auto rounded = internal::Determinant<D, D>(rows, 0, internal::AllColumns<D>());
  // A product passes D differences, D - 1 products and at most D (D - 1) / 2 sums: 13 in 4D.
  const int sign = internal::FilteredSign(rounded.value, 16 * internal::kRoundoff * rounded.sum);
  if (sign != internal::kUnsure) return sign;
  return internal::ExactSign<D>(p, [&](auto n, int exponent) {
    return internal::ExactDeterminant<D, n(), D>(internal::RowsFrom<n(), D>(*p[0], to, exponent), 0,
                                                 internal::AllColumns<D>())
        .Sign();
  });
}

// Is e inside the circumscribed ball of p, which is positively oriented? Ties are broken by the
// perturbation of predicates.h: positions rise by infinitesimals, in lexicographic order. Never
// "on". REQUIRES: e is none of them. Exact.
//
// The sign of sum_i (-1)^i |p_i - e|^2 det(p_j - e, j != i). Such a determinant is (-1)^i times the
// orientation with e in place of p_i: for e inside the simplex all terms are positive.
template <int D>
bool InBall(const std::array<const Point<D>*, D + 1>& p, const Point<D>& e) {
  std::array<const Point<D>*, D + 2> all;
  std::copy(p.begin(), p.end(), all.begin());
  all[D + 1] = &e;
  double value = 0, sum = 0;
  for (int i = 0; i <= D; ++i) {
    std::array<std::array<double, D>, D> rows;
    double square = 0;
    for (int j = 0, row = 0; j <= D; ++j) {
      for (int k = 0; k < D; ++k) {
        const double x = (*p[j])[k] - e[k];
        if (j == i) {
          square += x * x;
        } else {
          rows[row][k] = x;
        }
      }
      if (j != i) ++row;
    }
    const auto minor = internal::Determinant<D, D>(rows, 0, internal::AllColumns<D>());
    value += i % 2 == 0 ? square * minor.value : -square * minor.value;
    sum += square * minor.sum;
  }
  // Beside the determinant's 13 a product passes a square's 7, a product and 5 sums: 26 in 4D.
  const int sign = internal::FilteredSign(value, 32 * internal::kRoundoff * sum + 0x1p-1000);
  if (sign != internal::kUnsure) return sign > 0;
  const int exact = internal::ExactSign<D>(all, [&](auto n, int exponent) {
    constexpr int N = n();
    WideInt<(D + 2) * N> total{};
    for (int i = 0; i <= D; ++i) {
      std::array<const Point<D>*, D> others;
      std::copy(p.begin(), p.begin() + i, others.begin());
      std::copy(p.begin() + i + 1, p.end(), others.begin() + i);
      const internal::Vector<N, D> own(e, *p[i], exponent);
      const auto term =
          internal::DotProduct(own, own) *
          internal::ExactDeterminant<D, N, D>(internal::RowsFrom<N, D>(e, others, exponent), 0,
                                              internal::AllColumns<D>());
      total = i % 2 == 0 ? total + term : total - term;
    }
    return total.Sign();
  });
  if (exact != 0) return exact > 0;
  std::array<int, D + 2> by_place;
  for (int i = 0; i < D + 2; ++i) by_place[i] = i;
  std::sort(by_place.begin(), by_place.end(), [&](int a, int b) { return *all[b] < *all[a]; });
  for (const int i : by_place) {
    if (i == D + 1) return false;
    auto replaced = p;
    replaced[i] = &e;
    const int coefficient = OrientationOf<D>(replaced);
    if (coefficient != 0) return coefficient > 0;
  }
  return false;
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_TESTS_CORE_SVR_VARIANTS_BALL_PREDICATES_H_
