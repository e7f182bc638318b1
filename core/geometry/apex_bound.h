// Tetrahedra over one triangle: at which apexes is a dihedral angle at the triangle's edges below a
// bound, for certain? For many apexes over the same triangle; a few times faster than
// DihedralBound::Look. Immutable, thread-safe.
#ifndef DYNMESH_CORE_GEOMETRY_APEX_BOUND_H_
#define DYNMESH_CORE_GEOMETRY_APEX_BOUND_H_

#include <array>
#include <cmath>
#include <cstddef>

#include "core/geometry/circumball.h"
#include "core/geometry/dihedral.h"
#include "core/geometry/point.h"

namespace dynmesh::geometry {

class ApexBound {
 public:
  ApexBound() = default;  // nothing is certain
  ApexBound(const DihedralBound& bound, const std::array<Point3, 3>& triangle) {
    // Nor for less than a degree: how much an angle is below it would not be seen in its cosine.
    if (!(bound.degrees() >= 1)) return;
    const double c = bound.cosine();
    const double tangent = kLess * std::sqrt(1 - c * c) / c;
    const Vector3 normal =
        Cross(Difference(triangle[1].c, triangle[0].c), Difference(triangle[2].c, triangle[0].c));
    area2_ = std::sqrt(Dot(normal, normal));
    if (!(area2_ > 0)) return;
    for (std::size_t k = 0; k < 3; ++k) normal_[k] = normal[k] / area2_;
    for (std::size_t i = 0; i < 3; ++i) {
      const Point3 &from = triangle[i], &to = triangle[(i + 1) % 3];
      const Vector3 edge = Difference(to.c, from.c), inwards = Cross(normal_, edge);
      const double length2 = Dot(edge, edge), length = std::sqrt(length2);
      if (!(length > 0)) return;
      extent2_ += length2;
      Edge& at = edges_[i];
      at.from = from;
      at.length = length;
      for (std::size_t k = 0; k < 3; ++k) at.inwards[k] = tangent * (inwards[k] / length);
    }
    tangent_ = tangent;
  }

  // True if the tetrahedron of the triangle and x surely has an angle below the bound at one of the
  // triangle's edges, whatever the order of its corners (DihedralBound::IsBelow). May be false
  // needlessly.
  bool IsSurelyBelow(const Point3& x) const {
    if (!(tangent_ > 0)) return false;
    const Vector3 d = Difference(x.c, edges_[0].from.c);
    const double height = std::fabs(Dot(normal_, d));
    // Normals are known to 12 digits. No less than the square of any edge.
    const double noise = kNoise * (2 * extent2_ + 3 * Dot(d, d));
    if (!(area2_ > noise)) return false;
    bool is_below = false;
    for (const Edge& edge : edges_) {
      // How far inwards from the edge its foot is, times the tangent.
      const double s = Dot(edge.inwards, Difference(x.c, edge.from.c));
      is_below |= height < s && edge.length * s > noise * tangent_;
    }
    return is_below;
  }

 private:
  static constexpr double kLess = 0.99, kNoise = 1e-4;
  struct Edge {
    Point3 from = {};
    Vector3 inwards = {0, 0, 0};
    double length = 0;
  };
  std::array<Edge, 3> edges_;
  Vector3 normal_ = {0, 0, 0};
  double area2_ = 0, extent2_ = 0;
  double tangent_ = 0;  // a little less than that of the bound; 0: nothing is certain
};

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_APEX_BOUND_H_
