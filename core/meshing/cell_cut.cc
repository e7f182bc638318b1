#include "core/meshing/cell_cut.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/geometry/circumball.h"

namespace dynmesh::meshing {
namespace {

using geometry::Dot;
using geometry::Point3;
using geometry::Vector3;

// The cell is enlarged by this much, relative to the lengths at hand. A cut within it only touches.
constexpr double kSlack = 1e-11;
// A smaller area, in units of the squared distance, counts as none.
constexpr double kNoArea = 1e-9;

}  // namespace

void CellCut::Begin(const SpaceStar& star) {
  star_ = &star;
  neighbours_.clear();
  star.ForEachNeighbour([&](const SpaceStar::Neighbour& u) { neighbours_.push_back(&u); });
  // The nearest ones first: they cut off most.
  std::sort(neighbours_.begin(), neighbours_.end(), [](const auto* a, const auto* b) {
    return a->d2 != b->d2 ? a->d2 < b->d2 : a->p < b->p;
  });
}

// Keeps the part with a x + b y <= c.
void CellCut::Clip(double a, double b, double c) {
  const auto over = [&](const Position& p) { return a * p[0] + b * p[1] - c; };
  const std::size_t n = polygon_.size();
  clipped_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const Position &p = polygon_[i], &q = polygon_[i + 1 == n ? 0 : i + 1];
    const double at_p = over(p), at_q = over(q);
    if (at_p <= 0) clipped_.push_back(p);
    if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0)) {
      const double t = at_p / (at_p - at_q);
      clipped_.push_back({p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])});
    }
  }
  std::swap(polygon_, clipped_);
}

CellCut::Position CellCut::NearestToOrigin() const {
  const std::size_t n = polygon_.size();
  bool inside = true;
  double best2 = INFINITY;
  Position best = {0, 0};
  for (std::size_t i = 0; i < n; ++i) {
    const Position &p = polygon_[i], &q = polygon_[i + 1 == n ? 0 : i + 1];
    const Position e = {q[0] - p[0], q[1] - p[1]};
    inside = inside && e[0] * -p[1] - e[1] * -p[0] >= 0;
    const double e2 = e[0] * e[0] + e[1] * e[1];
    const double t = e2 > 0 ? std::clamp(-(p[0] * e[0] + p[1] * e[1]) / e2, 0.0, 1.0) : 0;
    const Position y = {p[0] + t * e[0], p[1] + t * e[1]};
    const double y2 = y[0] * y[0] + y[1] * y[1];
    if (y2 < best2) best2 = y2, best = y;
  }
  return inside ? Position{0, 0} : best;
}

double CellCut::Area2() const {
  double sum = 0;
  const Position& o = polygon_[0];
  for (std::size_t i = 1; i + 1 < polygon_.size(); ++i) {
    const Position &p = polygon_[i], &q = polygon_[i + 1];
    sum += (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]);
  }
  return sum;
}

std::optional<CellCut::Cut> CellCut::Of(const Facet& facet) {
  const Point3& p = star_->position();
  const Vector3& normal = facet.plane().normal;
  const double height = facet.plane().Height(p);
  const auto [x, y] = geometry::AxesOf(facet.plane());
  const double side = 2 * star_->reach();
  polygon_ = {{-side, -side}, {side, -side}, {side, side}, {-side, side}};
  for (const SpaceStar::Neighbour* u : neighbours_) {
    Clip(Dot(x, u->d), Dot(y, u->d), 0.5 * u->d2 + height * Dot(normal, u->d) + kSlack * u->d2);
    if (polygon_.size() < 3) return std::nullopt;
  }
  const Position nearest = NearestToOrigin();
  Cut cut;
  for (int k = 0; k < 3; ++k) {
    cut.nearest[k] = p[k] - height * normal[k] + nearest[0] * x[k] + nearest[1] * y[k];
  }
  cut.nearest = facet.plane().Foot(cut.nearest);
  cut.distance2 = geometry::SquaredDistance(cut.nearest, p);
  if (!facet.IsInside(cut.nearest)) return std::nullopt;
  cut.touches = Area2() < kNoArea * cut.distance2;
  return cut;
}

bool CellCut::GoesThrough(const SpaceStar& star, int slot, const Facet& facet) {
  const Point3& p = star.position();
  const auto& u = star[slot];
  const double from = facet.plane().Height(p), to = facet.plane().Height(u.p);
  if (!(from * to < 0)) return false;
  const double t = from / (from - to);
  return facet.IsInside({{p[0] + t * u.d[0], p[1] + t * u.d[1], p[2] + t * u.d[2]}});
}

}  // namespace dynmesh::meshing
