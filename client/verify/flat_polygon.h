// A polygon of the input as a piece of a plane. Immutable, thread-safe.
#ifndef DYNMESH_CLIENT_VERIFY_FLAT_POLYGON_H_
#define DYNMESH_CLIENT_VERIFY_FLAT_POLYGON_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "client/verify/vectors.h"

namespace dynmesh::cli {

// A polygon's plane, by its largest ring, and its rings projected along the axis with the largest
// component of the normal.
class FlatPolygon {
 public:
  using Flat = std::array<Real, 2>;

  static Vector ToVector(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

  explicit FlatPolygon(std::vector<std::vector<Vector>> rings) : rings_(std::move(rings)) {
    for (const auto& ring : rings_) {
      Vector normal = {0, 0, 0};  // twice the area as length
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vector c =
            Cross(Minus(ring[i], ring[0]), Minus(ring[(i + 1) % ring.size()], ring[0]));
        for (std::size_t k = 0; k < 3; ++k) normal[k] += c[k];
      }
      if (Dot(normal, normal) > Dot(normal_, normal_)) normal_ = normal, origin_ = ring[0];
    }
    const Real length = Norm(normal_);
    for (Real& c : normal_) c /= length;
    for (std::size_t k = 1; k < 3; ++k) {
      if (std::abs(normal_[k]) > std::abs(normal_[axis_])) axis_ = k;
    }
    for (const auto& ring : rings_) {
      for (const Vector& p : ring) bend_ = std::max(bend_, Distance(p));
    }
  }

  bool HasPlane() const { return std::isfinite(normal_[axis_]); }
  // Distance from the plane.
  Real Distance(const Vector& p) const { return std::abs(Dot(Minus(p, origin_), normal_)); }
  // Largest distance of its own corners from the plane.
  Real bend() const { return bend_; }

  Flat Project(const Vector& p) const {
    return {p[(axis_ + 1) % 3] - origin_[(axis_ + 1) % 3],
            p[(axis_ + 2) % 3] - origin_[(axis_ + 2) % 3]};
  }

  // Is the point's projection in an odd number of rings? O(corners).
  bool Covers(const Vector& p) const {
    const Flat at = Project(p);
    bool inside = false;
    for (const auto& ring : rings_) inside ^= IsInside(at, ring);
    return inside;
  }

  // Projected area of the points in an odd number of rings. Edges of rings meet in corners only. So
  // along each edge the number of other rings around both sides is constant, and its midpoint
  // decides it.
  Real Area() const {
    Real sum = 0;
    const Flat origin = Project(rings_[0][0]);
    for (const auto& ring : rings_) {
      Real twice = 0, inside = 0;
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Flat p = Project(ring[i]), q = Project(ring[(i + 1) % ring.size()]);
        const Flat middle = {(p[0] + q[0]) / 2, (p[1] + q[1]) / 2};
        bool is_border_of_hole = false;
        for (const auto& other : rings_) {
          if (&other != &ring && IsInside(middle, other)) is_border_of_hole = !is_border_of_hole;
        }
        const Real part = Twice(origin, p, q);
        twice += part;
        inside += is_border_of_hole ? -part : part;
      }
      sum += (twice > 0 ? inside : -inside) / 2;
    }
    return sum;
  }

  Real Perimeter() const {
    Real sum = 0;
    for (const auto& ring : rings_) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        sum += Norm(Minus(ring[(i + 1) % ring.size()], ring[i]));
      }
    }
    return sum;
  }

  // Twice the signed area.
  static Real Twice(const Flat& a, const Flat& b, const Flat& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  }

 private:
  bool IsInside(const Flat& at, const std::vector<Vector>& ring) const {
    bool inside = false;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      Flat p = Project(ring[i]), q = Project(ring[(i + 1) % ring.size()]);
      if (p[1] > q[1]) std::swap(p, q);
      if (at[1] < p[1] || at[1] >= q[1]) continue;
      if (Twice(p, q, at) > 0) inside = !inside;
    }
    return inside;
  }

  std::vector<std::vector<Vector>> rings_;
  Vector origin_ = {0, 0, 0};
  Vector normal_ = {0, 0, 0};
  std::size_t axis_ = 0;
  Real bend_ = 0;
};

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_FLAT_POLYGON_H_
