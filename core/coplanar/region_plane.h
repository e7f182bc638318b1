// The plane of a growing region of coplanar faces (coplanar_regions.h): which corners are in it,
// and what leans over it. Immutable, thread-safe. O(1).
#ifndef DYNMESH_CORE_COPLANAR_REGION_PLANE_H_
#define DYNMESH_CORE_COPLANAR_REGION_PLANE_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/coplanar/coplanar_regions.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/plane_fit.h"
#include "core/geometry/circumball.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::coplanar {

inline double NormOf(const std::array<double, 3>& v) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

// Of a ring, with the tolerance as thickness on either side; or of rounded corners.
class RegionPlane {
 public:
  RegionPlane(const PointRing& ring, AxisView view, double tolerance)
      : three_(LeastCorner(ring, view)),
        normal_(AreaVector(ring)),
        reach_(tolerance * NormOf(normal_)) {}

  // Of rounded corners: within `share` roundings, and `share_of_plane` for each of the plane's
  // errors.
  RegionPlane(const PlaneFit& fit, const std::vector<geometry::Vector3>& roundings, double share,
              double share_of_plane)
      : normal_(fit.normal()),
        fit_(fit),
        roundings_(&roundings),
        share_(share),
        share_of_plane_(share_of_plane) {}

  bool Contains(Corner c, const geometry::Point3& p) const {
    if (fit_) {
      const double near = share_ * RoundingAlong(normal_, (*roundings_)[c]);
      const double height = std::abs(fit_->Height(p));
      return height <= near ||
             (share_of_plane_ > 0 && height <= near + share_of_plane_ * fit_->ErrorAt(p));
    }
    if (geometry::Orientation(three_[0], three_[1], three_[2], p) == 0) return true;
    if (!(reach_ > 0)) return false;
    const geometry::Point3& o = three_[1];
    return std::abs(normal_[0] * (p[0] - o[0]) + normal_[1] * (p[1] - o[1]) +
                    normal_[2] * (p[2] - o[2])) <= reach_;
  }

  // Is the angle between o-p and o-q, which is in the plane, too small for meshes over a polygon's
  // inside, but not over its edges?
  bool IsSharpOver(const geometry::Point3& o, const geometry::Point3& q,
                   const geometry::Point3& p) const {
    const geometry::Vector3 d = geometry::Difference(p.c, o.c);
    const geometry::Vector3 e = geometry::Difference(q.c, o.c);
    const double length = NormOf(normal_) * NormOf(d);
    return std::abs(geometry::Dot(normal_, d)) < kSineOver * length && geometry::Dot(d, e) > 0 &&
           std::abs(geometry::Dot(normal_, geometry::Cross(e, d))) <=
               kJustOver * NormOf(e) * length;
  }

 private:
  // sin 70 degrees, plus a millionth.
  static constexpr double kSineOver = 0.9396926207859084 * (1 + 1e-6);
  static constexpr double kJustOver = 1e-6;

  std::array<geometry::Point3, 3> three_ = {};
  std::array<double, 3> normal_;
  double reach_ = 0;
  std::optional<PlaneFit> fit_;
  const std::vector<geometry::Vector3>* roundings_ = nullptr;
  double share_ = 0, share_of_plane_ = 0;
};

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_REGION_PLANE_H_
