// Vectors of `verify`, in long double: its checks do not use the library's own geometry.
#ifndef DYNMESH_CLIENT_VERIFY_VECTORS_H_
#define DYNMESH_CLIENT_VERIFY_VECTORS_H_

#include <array>
#include <cmath>

namespace dynmesh::cli {

using Real = long double;
using Vector = std::array<Real, 3>;  // z is 0 in 2D

inline Vector Minus(const Vector& u, const Vector& v) {
  return {u[0] - v[0], u[1] - v[1], u[2] - v[2]};
}
inline Real Dot(const Vector& u, const Vector& v) {
  return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}
inline Vector Cross(const Vector& u, const Vector& v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
inline Real Norm(const Vector& u) { return std::sqrt(Dot(u, u)); }

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_VECTORS_H_
