#include "core/geometry/tetrahedron_shape.h"

#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "core/geometry/exact_vector.h"

namespace dynmesh::geometry {
namespace {

// With u, v, w from a to the others the centre less a is n / (2 det),
//   n = u^2 v x w + v^2 w x u + w^2 u x v,  det = u . v x w,
// so that (circumradius / shortest edge)^2 = n^2 / (4 det^2 e^2), all of them integers.
//
// Sizes, see exact_vector.h: a square is below 2^(128N-2), an entry of a cross product below
// 2^(128N-3), so n's entries are below 2^(256N-3) and n^2 below 2^(512N-4), with sign 8N limbs.
// det^2 is below 2^(384N-6), times e^2 below 2^(512N-8).
template <int N>
struct ExactShape {
  WideInt<3 * N> det;
  WideInt<8 * N> n2;
  WideInt<2 * N> e2;  // the shortest edge's square

  ExactShape(const Point3& a, const Point3& b, const Point3& c, const Point3& d, int exponent) {
    using V = internal::Vector<N, 3>;
    const V u(a, b, exponent), v(a, c, exponent), w(a, d, exponent);
    const WideInt<2 *N> u2 = DotProduct(u, u), v2 = DotProduct(v, v), w2 = DotProduct(w, w);
    det = TripleProduct(u, v, w);
    const auto vw = CrossProduct(v, w), wu = CrossProduct(w, u), uv = CrossProduct(u, v);
    n2 = {};
    for (std::size_t k = 0; k < 3; ++k) {
      const WideInt<4 * N> n = u2 * vw[k] + v2 * wu[k] + w2 * uv[k];
      n2 = n2 + n * n;
    }
    e2 = u2;
    const V bc(b, c, exponent), bd(b, d, exponent), cd(c, d, exponent);
    for (const auto& other : {v2, w2, DotProduct(bc, bc), DotProduct(bd, bd), DotProduct(cd, cd)}) {
      if ((other - e2).negative()) e2 = other;
    }
  }

  double RadiusEdge() const {
    if (det.Sign() == 0) return INFINITY;
    const ScaledDouble top = ToScaledDouble(n2), of_det = ToScaledDouble(det),
                       edge = ToScaledDouble(e2);
    double square = top.mantissa / (4 * of_det.mantissa * of_det.mantissa * edge.mantissa);
    int power = top.exponent - 2 * of_det.exponent - edge.exponent;
    if (power % 2 != 0) square *= 2, --power;
    return std::scalbn(std::sqrt(square), power / 2);
  }
};

// 2^power, 0 <= power < 127.
WideInt<2> PowerOfTwo(int power) {
  WideInt<2> result{};
  result.limb[static_cast<std::size_t>(power / 64)] = std::uint64_t{1} << (power % 64);
  return result;
}

}  // namespace

TetrahedronShape ShapeOf(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  return internal::Evaluate<3>({&a, &b, &c, &d}, [&](auto n, int exponent) -> TetrahedronShape {
    const ExactShape<n()> shape(a, b, c, d, exponent);
    const ScaledDouble det = ToScaledDouble(shape.det);
    return {std::scalbn(det.mantissa, det.exponent + 3 * exponent), shape.RadiusEdge()};
  });
}

int CompareRadiusEdge(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                      double bound) {
  if (!(bound > 0.5)) return 1;  // the regular one has sqrt(3/8), none less
  return internal::SignOf<3>({&a, &b, &c, &d}, [&](auto n, int exponent) {
    const ExactShape<n()> shape(a, b, c, d, exponent);
    if (shape.det.Sign() == 0) return 1;
    if (bound > 0x1p52) return shape.RadiusEdge() > bound ? 1 : -1;
    // bound = m 2^-k, m below 2^54, 1 <= k <= 54: n^2 2^(2k-2) against det^2 e^2 m^2, both
    // below 2^(512N+102).
    const int k = 53 - std::ilogb(bound);
    const auto m = static_cast<std::uint64_t>(std::scalbn(bound, k));
    const Uint128 m2 = static_cast<Uint128>(m) * m;
    const WideInt<2> square = {
        {static_cast<std::uint64_t>(m2), static_cast<std::uint64_t>(m2 >> 64)}};
    const auto left = shape.n2 * PowerOfTwo(2 * k - 2);
    const auto right = shape.det * shape.det * shape.e2 * square;
    return (left - right).Sign();
  });
}

}  // namespace dynmesh::geometry
