// The plane of corners that are near one: least squares. A function of the corners in their order.
// Pure, thread-safe. O(corners).
#ifndef DYNMESH_CORE_COPLANAR_PLANE_FIT_H_
#define DYNMESH_CORE_COPLANAR_PLANE_FIT_H_

#include <array>
#include <vector>

#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

class PlaneFit {
 public:
  // `normal` is near that of the plane; its length does not matter. REQUIRES: at least one corner,
  // `normal` is not 0.
  PlaneFit(const std::vector<geometry::Point3>& corners, const geometry::Vector3& normal);

  const geometry::Vector3& normal() const { return normal_; }
  double Height(const geometry::Point3& p) const {
    return geometry::Dot(normal_, geometry::Difference(p.c, centre_.c));
  }
  // Along two axes in the plane, from the centre.
  std::array<double, 2> PlaceOf(const geometry::Point3& p) const {
    const geometry::Vector3 d = geometry::Difference(p.c, centre_.c);
    return {geometry::Dot(u_, d), geometry::Dot(w_, d)};
  }
  // How many times a corner's error in height the plane is off at p, in the mean: at most 1 at the
  // corners, and more far from them.
  double ErrorAt(const geometry::Point3& p) const;

 private:
  struct Line {  // sums of products of places in the plane
    double uu = 0, uw = 0, ww = 0;
  };
  void SetAxes();
  bool Tilt(const std::vector<geometry::Point3>& corners);

  geometry::Point3 centre_{};
  geometry::Vector3 normal_{}, u_{}, w_{};
  Line sums_;
  double count_ = 0;
};

// The rounding of a height over a plane with this normal.
double RoundingAlong(const geometry::Vector3& normal, const geometry::Vector3& rounding);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_PLANE_FIT_H_
