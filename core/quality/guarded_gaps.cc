#include "core/quality/guarded_gaps.h"

#include <algorithm>

#include "core/geometry/constructions.h"

namespace dynmesh::quality {
namespace {

// For squared radii: points are rounded.
constexpr double kTolerance = 1 + 1e-6;
// Splits that the guard stopped leave edges about as long as the subsegment kept whole: it is at
// most so many times as long (observed: 1.4 to 1.8). The guard itself (CommonRules::IsGuarded)
// compares with the bucket, which a finished mesh does not tell.
constexpr double kMostTimesEdge = 4;

}  // namespace

void GuardedGaps::FindBalls() {
  for (std::size_t s = 0; s < mesh_.subsegments.size(); ++s) {
    const auto a = row_of_.Find(mesh_.subsegments.ends[2 * s]);
    const auto b = row_of_.Find(mesh_.subsegments.ends[2 * s + 1]);
    if (a == IdTable::kNone || b == IdTable::kNone) continue;
    const geometry::Point2 p = At(a), q = At(b);
    balls_.push_back({geometry::Midpoint(p, q), kTolerance * geometry::SquaredDistance(p, q) / 4});
  }
}

bool GuardedGaps::Has(const std::array<std::size_t, 3>& rows) {
  if (++questions_ > kMostQuestions) return false;
  if (questions_ == 1) FindBalls();
  // Is x, a point that would fix an edge of that squared length, in the circle of a kept
  // subsegment?
  const auto is_kept_out = [&](const geometry::Point2& x, double e2) {
    return std::ranges::any_of(balls_, [&](const Ball& ball) {
      return ball.radius2 <= kMostTimesEdge * kMostTimesEdge / 4 * e2 &&
             geometry::SquaredDistance(ball.centre, x) <= ball.radius2;
    });
  };
  // The edge with the gap may be any that is too far from the circumcenter. The point that would
  // fix it is the circumcenter or, nearer, the off-center (geometry::OffCenter).
  const double rho2 = rho_ * rho_, height = geometry::OffCenterHeight(rho_);
  const geometry::Point2 centre = geometry::Circumcenter(At(rows[0]), At(rows[1]), At(rows[2]));
  const double r2 = geometry::SquaredDistance(centre, At(rows[0]));
  for (std::size_t i = 0; i < 3; ++i) {
    const geometry::Point2 p = At(rows[i]), q = At(rows[(i + 1) % 3]);
    const double e2 = geometry::SquaredDistance(p, q);
    if (r2 <= rho2 * e2) continue;
    if (is_kept_out(centre, e2)) return true;
    const geometry::Point2 off_center = geometry::OffCenter(p, q, height);
    if (geometry::SquaredDistance(off_center, p) < r2 && is_kept_out(off_center, e2)) return true;
  }
  return false;
}

}  // namespace dynmesh::quality
