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
// MayMeet enlarges the cell by more than all roundings of a cut: by these parts of the facet's
// distance and of the cell's reach. Rings of more corners count as the box around them.
constexpr double kWiderByFacet = 1e-9, kWiderByReach = 1e-12;
constexpr std::size_t kFewCorners = 8;

}  // namespace

void CellCut::Begin(const SpaceStar& star) {
  p_ = star.position();
  reach_ = star.reach();
  neighbours_.clear();
  star.ForEachNeighbour([&](const Neighbour& u) { neighbours_.push_back(&u); });
  BeginSorted();
}

void CellCut::Begin(const Point3& position, double reach, std::span<const Neighbour> neighbours) {
  p_ = position;
  reach_ = reach;
  neighbours_.clear();
  for (const Neighbour& u : neighbours) neighbours_.push_back(&u);
  BeginSorted();
}

void CellCut::BeginSorted() {
  // The nearest ones first: they cut off most.
  std::sort(neighbours_.begin(), neighbours_.end(), [](const auto* a, const auto* b) {
    return a->d2 != b->d2 ? a->d2 < b->d2 : a->p < b->p;
  });
  lengths_.clear();
  for (const Neighbour* u : neighbours_) lengths_.push_back(std::sqrt(u->d2));
}

// Keeps the part with a x + b y <= c.
void CellCut::Clip(double a, double b, double c) {
  const std::size_t n = polygon_.size();
  over_.clear();
  bool is_cut = false;
  for (const Position& p : polygon_) {
    over_.push_back(a * p[0] + b * p[1] - c);
    is_cut |= !(over_.back() <= 0);
  }
  if (!is_cut) return;
  clipped_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = i + 1 == n ? 0 : i + 1;
    const double at_p = over_[i], at_q = over_[j];
    const Position &p = polygon_[i], &q = polygon_[j];
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

Point3 CellCut::At(const Position& position, const Facet& facet) const {
  const Vector3& normal = facet.plane().normal;
  const double height = facet.plane().Height(p_);
  const auto [x, y] = geometry::AxesOf(facet.plane());
  Point3 at;
  for (int k = 0; k < 3; ++k) {
    at[k] = p_[k] - height * normal[k] + position[0] * x[k] + position[1] * y[k];
  }
  return facet.plane().Foot(at);
}

// Clips the facet by the enlarged cell, in place of the cell's plane by the cell. A ring that is
// not convex is clipped to more than is left of it. So is one with holes, and the box of a large
// one.
bool CellCut::MayMeet(const Facet& facet) {
  const Vector3& normal = facet.plane().normal;
  const double height = facet.plane().Height(p_);
  const auto [x, y] = geometry::AxesOf(facet.plane());
  polygon_.clear();
  double far = 0;
  if (facet.rings().size() == 1 && facet.rings().front().size() <= kFewCorners) {
    for (const Point3& corner : facet.rings().front()) {
      const Vector3 d = geometry::Difference(corner.c, p_.c);
      polygon_.push_back({Dot(x, d), Dot(y, d)});
      far = std::max({far, std::fabs(polygon_.back()[0]), std::fabs(polygon_.back()[1])});
    }
  } else {
    const Extent<3>& box = facet.where().box;
    Vector3 middle;
    Position half = {0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      middle[k] = 0.5 * (box.lo[k] + box.hi[k]) - p_[static_cast<int>(k)];
      half[0] += 0.5 * (box.hi[k] - box.lo[k]) * std::fabs(x[k]);
      half[1] += 0.5 * (box.hi[k] - box.lo[k]) * std::fabs(y[k]);
    }
    const double at_x = Dot(x, middle), at_y = Dot(y, middle);
    polygon_ = {{at_x - half[0], at_y - half[1]},
                {at_x + half[0], at_y - half[1]},
                {at_x + half[0], at_y + half[1]},
                {at_x - half[0], at_y + half[1]}};
    far = std::max(std::fabs(at_x) + half[0], std::fabs(at_y) + half[1]);
  }
  double largest = 0;  // coordinate: their differences round
  for (int k = 0; k < 3; ++k) largest = std::max(largest, std::fabs(p_[k]));
  const double wider = kWiderByFacet * (far + std::fabs(height)) + kWiderByReach * reach_ +
                       2 * facet.where().margin + 0x1p-46 * largest;
  for (std::size_t i = 0; i < neighbours_.size(); ++i) {
    const Neighbour& u = *neighbours_[i];
    Clip(Dot(x, u.d), Dot(y, u.d),
         0.5 * u.d2 + height * Dot(normal, u.d) + kSlack * u.d2 + wider * lengths_[i]);
    if (polygon_.empty()) return false;
  }
  return true;
}

std::optional<CellCut::Cut> CellCut::Of(const Facet& facet) {
  if (!MayMeet(facet)) return std::nullopt;
  return NaiveOf(facet);
}

std::optional<CellCut::Cut> CellCut::NaiveOf(const Facet& facet) {
  const Vector3& normal = facet.plane().normal;
  const double height = facet.plane().Height(p_);
  const auto [x, y] = geometry::AxesOf(facet.plane());
  const double side = 2 * reach_;
  polygon_ = {{-side, -side}, {side, -side}, {side, side}, {-side, side}};
  for (const Neighbour* u : neighbours_) {
    Clip(Dot(x, u->d), Dot(y, u->d), 0.5 * u->d2 + height * Dot(normal, u->d) + kSlack * u->d2);
    if (polygon_.size() < 3) return std::nullopt;
  }
  Cut cut;
  cut.nearest = At(NearestToOrigin(), facet);
  cut.distance2 = geometry::SquaredDistance(cut.nearest, p_);
  if (!facet.IsInside(cut.nearest)) return std::nullopt;
  cut.touches = Area2() < kNoArea * cut.distance2;
  return cut;
}

std::optional<Point3> CellCut::Farthest(const Facet& facet) const {
  std::optional<Point3> farthest;
  double most2 = 0;
  for (const Position& position : polygon_) {
    const Point3 at = At(position, facet);
    const double d2 = geometry::SquaredDistance(at, p_);
    if (d2 < most2 || (d2 == most2 && farthest && *farthest < at) || !facet.IsInside(at)) continue;
    most2 = d2;
    farthest = at;
  }
  return farthest;
}

bool CellCut::GoesThrough(const Point3& position, const Neighbour& neighbour, const Facet& facet) {
  const double from = facet.plane().Height(position), to = facet.plane().Height(neighbour.p);
  if (!(from * to < 0)) return false;
  const double t = from / (from - to);
  return facet.IsInside({{position[0] + t * neighbour.d[0], position[1] + t * neighbour.d[1],
                          position[2] + t * neighbour.d[2]}});
}

}  // namespace dynmesh::meshing
