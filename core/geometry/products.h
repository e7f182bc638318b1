// Products of doubles that lose nothing to cancellation. Pure functions, thread-safe.
#ifndef DYNMESH_CORE_GEOMETRY_PRODUCTS_H_
#define DYNMESH_CORE_GEOMETRY_PRODUCTS_H_

#include <array>
#include <cmath>

namespace dynmesh::geometry {

// a b - c d with two roundings in place of three and no cancellation (Kahan): the error of
// the second product is added back.
inline double DifferenceOfProducts(double a, double b, double c, double d) {
  const double p = c * d;
  const double error = std::fma(-c, d, p);
  return std::fma(a, b, -p) + error;
}

inline std::array<double, 3> AccurateCross(const std::array<double, 3>& a,
                                           const std::array<double, 3>& b) {
  return {DifferenceOfProducts(a[1], b[2], a[2], b[1]),
          DifferenceOfProducts(a[2], b[0], a[0], b[2]),
          DifferenceOfProducts(a[0], b[1], a[1], b[0])};
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_PRODUCTS_H_
