#include "core/quality/unsplit_gaps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/base/feature_kinds.h"
#include "core/base/rings.h"
#include "core/geometry/constructions.h"
#include "core/geometry/segment_distance.h"

namespace dynmesh::quality {
namespace {

// For squared radii: points are rounded.
constexpr double kRounded = 1 + 1e-6;

}  // namespace

UnsplitGaps::UnsplitGaps(const Mesh& mesh, std::span<const Feature> features, double rho)
    : mesh_(mesh), rho_(rho) {
  if (std::ranges::none_of(features, &Feature::unsplit)) return;
  absl::flat_hash_map<FeatureId, geometry::Point2> points;
  for (const Feature& f : features) {
    if (IsPoint(f)) points[f.id] = {{f.position[0], f.position[1]}};
  }
  std::vector<boxes::Box<2>> around;
  const auto add = [&](FeatureId a, FeatureId b) {
    const auto p = points.find(a), q = points.find(b);
    if (p == points.end() || q == points.end()) return;
    const geometry::Point2 centre = geometry::Midpoint(p->second, q->second);
    const double radius2 = kRounded * geometry::SquaredDistance(p->second, q->second) / 4;
    const double r = std::sqrt(radius2) * kRounded;
    circles_.push_back({centre, radius2});
    around.push_back({{centre[0] - r, centre[1] - r}, {centre[0] + r, centre[1] + r}});
  };
  for (const Feature& f : features) {
    if (!f.unsplit) continue;
    Visit(
        f, [&](const ASegment& s) { add(s.ends[0], s.ends[1]); },
        [&](const APolygon& p) { ForEachEdgeOf(p.rings, add); }, Ignore<APoint, ASize>);
  }
  tree_ = boxes::BoxTree<2>(std::move(around));
}

bool UnsplitGaps::MeetsCircle(const geometry::Point2& x, const geometry::Point2& y) const {
  const auto box = boxes::Box<2>::Of(std::array{x.c, y.c});
  bool meets = false;
  tree_.ForEachMeeting(box, [&](std::uint32_t i) {
    const Circle& circle = circles_[i];
    meets = meets || geometry::SquaredDistance(circle.centre, x, y) <= circle.radius2;
  });
  return meets;
}

// The point that would fix an edge is the off-center or, if it is nearer, the circumcenter. The gap
// was first tried with a triangle at least as large: with a point between the two.
bool UnsplitGaps::Has(const std::array<std::size_t, 3>& rows) const {
  if (circles_.empty()) return false;
  const double height = geometry::OffCenterHeight(rho_);
  const geometry::Point2 centre = geometry::Circumcenter(At(rows[0]), At(rows[1]), At(rows[2]));
  const double r2 = geometry::SquaredDistance(centre, At(rows[0]));
  for (std::size_t i = 0; i < 3; ++i) {
    const geometry::Point2 p = At(rows[i]), q = At(rows[(i + 1) % 3]), c = At(rows[(i + 2) % 3]);
    if (r2 <= rho_ * rho_ * geometry::SquaredDistance(p, q)) continue;
    const double dot = (p[0] - c[0]) * (q[0] - c[0]) + (p[1] - c[1]) * (q[1] - c[1]);
    if (!(dot > 0)) continue;  // the centre lies beyond pq
    const geometry::Point2 off_center = geometry::OffCenter(p, q, height);
    const bool is_nearer = r2 < geometry::SquaredDistance(off_center, p);
    if (MeetsCircle(is_nearer ? centre : off_center, off_center)) return true;
  }
  return false;
}

}  // namespace dynmesh::quality
