// The plane of corners that are near one: least squares, in units of the corners' errors. A
// function of the corners in their order. Pure, thread-safe. O(corners).
#ifndef DYNMESH_CORE_COPLANAR_PLANE_FIT_H_
#define DYNMESH_CORE_COPLANAR_PLANE_FIT_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

class PlaneFit {
 public:
  // `normal` is near that of the plane; its length does not matter. REQUIRES: at least one corner,
  // `normal` is not 0.
  // `errors`: of heights, of each corner; empty: they are alike.
  PlaneFit(const std::vector<geometry::Point3>& corners, const geometry::Vector3& normal,
           const std::vector<double>& errors = {});

  const geometry::Vector3& normal() const { return normal_; }
  double Height(const geometry::Point3& p) const {
    return geometry::Dot(normal_, geometry::Difference(p.c, centre_.c));
  }
  // Along two axes in the plane, from the centre.
  std::array<double, 2> PlaceOf(const geometry::Point3& p) const {
    const geometry::Vector3 d = geometry::Difference(p.c, centre_.c);
    return {geometry::Dot(u_, d), geometry::Dot(w_, d)};
  }
  // How far the plane is off at p, in the mean: less than the errors between the corners, and more
  // far from them; kMostErrors of the largest one at most.
  double ErrorAt(const geometry::Point3& p) const;

 private:
  struct Line {  // sums of products of places in the plane
    double uu = 0, uw = 0, ww = 0;
  };
  static constexpr double kMostErrors = 4;

  void SetAxes();
  bool Tilt(const std::vector<geometry::Point3>& corners);

  geometry::Point3 centre_{};
  geometry::Vector3 normal_{}, u_{}, w_{};
  Line sums_;
  std::vector<double> weights_;
  double weight_ = 0, largest_error_ = 1;
};

// The rounding of a height over a plane with this normal.
double RoundingAlong(const geometry::Vector3& normal, const geometry::Vector3& rounding);
// The same of several corners, by their numbers; the normal has any length.
std::vector<double> RoundingsAlong(geometry::Vector3 normal,
                                   const std::vector<std::uint32_t>& corners,
                                   const std::vector<geometry::Vector3>& roundings);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_PLANE_FIT_H_
