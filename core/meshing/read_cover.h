// The cover of the balls about a star's corners. A vertex outside of it does not change the star.
#ifndef DYNMESH_CORE_MESHING_READ_COVER_H_
#define DYNMESH_CORE_MESHING_READ_COVER_H_

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/rounding.h"
#include "core/geometry/point.h"
#include "core/meshing/spatial_tree.h"

namespace dynmesh::meshing {

// How far the balls extend from the star's vertex p, by axis and, in 3D, by orthant.
//
// All balls have p on their boundary. So a ball about p + c extends by 2 c.u in direction u. Within
// an orthant it extends by at most twice the length of the part of c that points into the orthant.
template <int D>
class ReadCover {
 public:
  using Point = geometry::Point<D>;
  static constexpr int kOrthants = 1 << D;

  explicit ReadCover(const Point& p) : p_(p) {}

  // Adds the ball about c. Each coordinate of c may err by `slack`.
  void AddBall(const Point& c, double radius, double slack) {
    box_.AddBall(c, radius + 2 * slack);
    radius2_ = std::max(radius2_, 4 * (radius + slack) * (radius + slack));
    if constexpr (D == 2) return;
    std::array<std::array<double, 2>, D> part;  // squared: of c, downwards and upwards
    for (int k = 0; k < D; ++k) {
      const double d = c[k] - p_[k], above = std::max(d, 0.0);
      const double down = above - d + slack, up = above + slack;
      part[k] = {down * down, up * up};
    }
    for (int o = 0; o < kOrthants; ++o) {
      double sum = 0;
      for (int k = 0; k < D; ++k) sum += part[k][o >> k & 1];
      half2_[o] = std::max(half2_[o], sum);
    }
  }
  // Adds a ball that need not have p on its boundary.
  void AddDistantBall(const Point& c, double radius) {
    box_.AddBall(c, radius);
    double distance2 = 0;
    for (int k = 0; k < D; ++k) distance2 += (c[k] - p_[k]) * (c[k] - p_[k]);
    const double reach = std::sqrt(distance2) * kRootWider + radius;
    radius2_ = std::max(radius2_, reach * reach);
    for (double& half2 : half2_) half2 = std::max(half2, 0.25 * reach * reach);
  }
  // Adds everything in view of p, for a ball of which nothing is known.
  void AddAll(double squared_distance) {
    box_.AddBall(p_, std::sqrt(squared_distance));
    radius2_ = squared_distance;
    half2_.fill(squared_distance);
  }

  const Point& centre() const { return p_; }
  const Extent<D>& box() const { return box_; }
  double radius2() const { return radius2_; }
  // 3D: how far it extends in an orthant. Bit k set: coordinate k is above that of p.
  double Reach(int orthant) const { return 2 * std::sqrt(half2_[orthant]); }

 private:
  Point p_;
  Extent<D> box_ = Extent<D>::Nothing();
  double radius2_ = 0;
  std::array<double, kOrthants> half2_ = {};  // squared half of the reach
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_READ_COVER_H_
