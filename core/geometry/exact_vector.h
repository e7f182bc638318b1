// Differences of points as exact integers, and the sign of a polynomial of them: the exact
// rung of the predicates. Pure, thread-safe.
#ifndef DYNMESH_CORE_GEOMETRY_EXACT_VECTOR_H_
#define DYNMESH_CORE_GEOMETRY_EXACT_VECTOR_H_

#include <array>
#include <cassert>
#include <initializer_list>
#include <span>
#include <type_traits>

#include "core/geometry/exact_integer.h"
#include "core/geometry/point.h"

namespace dynmesh::geometry::internal {

// Sizes. With coordinates of `width` bits in their common unit, differences stay below 2^(width+1).
// For N limbs we require width + 1 <= 64N - 2, so differences d < 2^(64N-2).
//   d*d < 2^(128N-4), sums of up to four of these < 2^(128N-2): 2N limbs with sign.
//   In-circle polynomial: squares and cross products are sums of two, below 2^(128N-3); their
//   products below 2^(256N-6), three of them below 2^(256N-4): 4N limbs.
//   3D triple product: a sum of six, below 2^(192N-3): 3N limbs.
//   In-sphere polynomial: a triple product times a sum of three squares, below 2^(128N-2); four of
//   those products are below 2^(320N-3): 5N limbs.
constexpr int MaxWidth(int limbs) { return 64 * limbs - 3; }

// The whole domain: below 2^251 in units of 2^-302, width 553 <= MaxWidth(9) = 573.
inline constexpr int kMaxLimbs = 9;
static_assert(MaxWidth(kMaxLimbs) >= 251 + 302);

// Below this width signs of the predicates' polynomials are those of native integers (WideInt<0>):
// differences are below 2^24, so the in-sphere polynomial is below 4 x 18 x 2^120 < 2^127.
constexpr int kNativeWidth = 23;

template <int D>
CommonUnit UnitOf(std::initializer_list<const Point<D>*> points) {
  std::array<double, 5 * D> coordinates;
  assert(points.size() <= 5);
  std::size_t count = 0;
  for (const Point<D>* p : points) {
    for (const double x : p->c) coordinates[count++] = x;
  }
  return FindCommonUnit(std::span<const double>(coordinates.data(), count));
}

template <class Polynomial>
auto EvaluateIn(const CommonUnit& unit, Polynomial polynomial) {
  if (unit.width <= MaxWidth(1)) {
    return polynomial(std::integral_constant<int, 1>{}, unit.exponent);
  }
  if (unit.width <= MaxWidth(2)) {
    return polynomial(std::integral_constant<int, 2>{}, unit.exponent);
  }
  assert(unit.width <= MaxWidth(kMaxLimbs));
  return polynomial(std::integral_constant<int, kMaxLimbs>{}, unit.exponent);
}

// Calls polynomial(integral<N>, exponent) with the least N of 1, 2, kMaxLimbs that suffices for the
// coordinates. Returns its result.
template <int D, class Polynomial>
auto Evaluate(std::initializer_list<const Point<D>*> points, Polynomial polynomial) {
  return EvaluateIn(UnitOf<D>(points), polynomial);
}

// The same for the sign of a predicate's polynomial, of degree 5 or less; also with N = 0.
template <int D, class Polynomial>
int SignOf(std::initializer_list<const Point<D>*> points, Polynomial polynomial) {
  const CommonUnit unit = UnitOf<D>(points);
  if (unit.width <= kNativeWidth) {
    return polynomial(std::integral_constant<int, 0>{}, unit.exponent);
  }
  return EvaluateIn(unit, polynomial);
}

template <int N, int D>
struct Vector {
  std::array<WideInt<N>, D> c;

  // to - from, in units of 2^exponent.
  Vector(const Point<D>& from, const Point<D>& to, int exponent) {
    for (int i = 0; i < D; ++i) {
      c[i] = ToInteger<N>(to[i], exponent) - ToInteger<N>(from[i], exponent);
    }
  }
};

template <int N>
WideInt<2 * N> CrossProduct(const Vector<N, 2>& a, const Vector<N, 2>& b) {
  return a.c[0] * b.c[1] - a.c[1] * b.c[0];
}

template <int N, int D>
WideInt<2 * N> DotProduct(const Vector<N, D>& a, const Vector<N, D>& b) {
  WideInt<2 * N> sum = a.c[0] * b.c[0];
  for (int i = 1; i < D; ++i) sum = sum + a.c[i] * b.c[i];
  return sum;
}

template <int N>
std::array<WideInt<2 * N>, 3> CrossProduct(const Vector<N, 3>& a, const Vector<N, 3>& b) {
  const auto minor = [&](int i, int j) { return a.c[i] * b.c[j] - a.c[j] * b.c[i]; };
  return {minor(1, 2), minor(2, 0), minor(0, 1)};
}

// a . (b x c): the determinant of the three.
template <int N>
WideInt<3 * N> TripleProduct(const Vector<N, 3>& a, const Vector<N, 3>& b, const Vector<N, 3>& c) {
  const auto bc = CrossProduct(b, c);
  return a.c[0] * bc[0] + a.c[1] * bc[1] + a.c[2] * bc[2];
}

// The centre of the ball through four 3D points, seen from the first: n / (2 det). With u, v, w
// from it to the others,
//   n = u^2 v x w + v^2 w x u + w^2 u x v,  det = u . v x w.
// A square is below 2^(128N-2), an entry of a cross product below 2^(128N-3), so those of n are
// below 2^(256N-3): 4N limbs.
template <int N>
struct ExactCentre {
  Vector<N, 3> u, v, w;
  WideInt<2 * N> u2, v2, w2;
  WideInt<3 * N> det;
  std::array<WideInt<4 * N>, 3> n;

  ExactCentre(const Point<3>& p, const Point<3>& a, const Point<3>& b, const Point<3>& c,
              int exponent)
      : u(p, a, exponent), v(p, b, exponent), w(p, c, exponent) {
    u2 = DotProduct(u, u), v2 = DotProduct(v, v), w2 = DotProduct(w, w);
    det = TripleProduct(u, v, w);
    const auto vw = CrossProduct(v, w), wu = CrossProduct(w, u), uv = CrossProduct(u, v);
    for (std::size_t k = 0; k < 3; ++k) n[k] = u2 * vw[k] + v2 * wu[k] + w2 * uv[k];
  }
};

}  // namespace dynmesh::geometry::internal

#endif  // DYNMESH_CORE_GEOMETRY_EXACT_VECTOR_H_
