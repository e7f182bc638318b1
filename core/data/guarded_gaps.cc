#include "core/data/guarded_gaps.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/constructions.h"

namespace dynmesh::data {
namespace {

// Of squared radii: points are rounded.
constexpr double kTolerance = 1 + 1e-6;

}  // namespace

void GuardedGaps::FindBalls() {
  for (std::size_t s = 0; s < mesh_.subsegments.size(); ++s) {
    const auto a = row_of_.find(mesh_.subsegments.ends[2 * s]);
    const auto b = row_of_.find(mesh_.subsegments.ends[2 * s + 1]);
    if (a == row_of_.end() || b == row_of_.end()) continue;
    const geometry::Point2 p = At(a->second), q = At(b->second);
    balls_.push_back({geometry::Midpoint(p, q), kTolerance * geometry::SquaredDistance(p, q) / 4});
  }
}

bool GuardedGaps::Has(const std::array<std::size_t, 3>& rows) {
  if (++questions_ > kMostQuestions) return false;
  if (questions_ == 1) FindBalls();
  const auto holds = [&](const geometry::Point2& x) {
    return std::ranges::any_of(balls_, [&](const Ball& ball) {
      return geometry::SquaredDistance(ball.centre, x) <= ball.radius2;
    });
  };
  // Any edge may have been the one with the gap, and its point the circumcenter or, nearer,
  // the off-center (Rules::OffCenter).
  const double rho2 = rho_ * rho_;
  const double height = std::sqrt(2 * rho2 + std::sqrt(4 * rho2 * rho2 - rho2) - 0.25);
  for (std::size_t i = 0; i < 3; ++i) {
    const geometry::Point2 p = At(rows[i]), q = At(rows[(i + 1) % 3]), c = At(rows[(i + 2) % 3]);
    if (i == 0 && holds(geometry::Circumcenter(p, q, c))) return true;
    const geometry::Point2 off_center = {{0.5 * (p[0] + q[0]) - height * (q[1] - p[1]),
                                          0.5 * (p[1] + q[1]) + height * (q[0] - p[0])}};
    const double most = geometry::SquaredDistance(geometry::Circumcenter(p, q, c), p);
    if (geometry::SquaredDistance(off_center, p) < most && holds(off_center)) return true;
  }
  return false;
}

}  // namespace dynmesh::data
