#include "core/geometry/tetrahedron_shape.h"

#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "core/geometry/exact_vector.h"

namespace dynmesh::geometry {
namespace {

// (circumradius / shortest edge)^2 = n^2 / (4 det^2 e^2), with n and det of the centre. All are
// integers. Sizes, see exact_vector.h: n^2 is below 2^(512N-4), with sign 8N limbs; det^2 is below
// 2^(384N-6), times e^2 below 2^(512N-8).
template <int N>
struct ExactShape {
  WideInt<3 * N> det;
  WideInt<8 * N> n2{};
  WideInt<2 * N> e2;  // the shortest edge's square

  ExactShape(const Point3& a, const Point3& b, const Point3& c, const Point3& d, int exponent) {
    const internal::ExactCentre<N> centre(a, b, c, d, exponent);
    det = centre.det;
    for (const auto& n : centre.n) n2 = n2 + n * n;
    e2 = centre.u2;
    const auto square = [exponent](const Point3& p, const Point3& q) {
      const internal::Vector<N, 3> edge(p, q, exponent);
      return DotProduct(edge, edge);
    };
    for (const auto& other : {centre.v2, centre.w2, square(b, c), square(b, d), square(c, d)}) {
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
  if (!(bound > 0.5)) return 1;  // the regular one has sqrt(3/8), the least
  return internal::Evaluate<3>({&a, &b, &c, &d}, [&](auto n, int exponent) {
    const ExactShape<n()> shape(a, b, c, d, exponent);
    if (shape.det.Sign() == 0) return 1;
    if (bound > 0x1p52) return shape.RadiusEdge() > bound ? 1 : -1;
    // bound = m 2^-k, m below 2^54, 1 <= k <= 54. Compares n^2 2^(2k-2) to det^2 e^2 m^2, both
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
