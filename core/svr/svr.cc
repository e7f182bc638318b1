#include "core/svr/svr.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/border_grid.h"
#include "core/geometry/hilbert_curve.h"

namespace dynmesh::svr {
namespace {

using geometry::Point;
using geometry::Point2;
using geometry::Point3;

// In the order of a Hilbert curve, so that neighbours in the list are near each other.
template <int D>
std::vector<Point<D>> Sorted(std::vector<Point<D>> points, const Point<D>& lo, const Point<D>& hi) {
  constexpr int kLevels = 32 / D;
  const double scale = std::ldexp(1.0, kLevels) / (hi[0] - lo[0]);
  std::vector<std::pair<std::uint32_t, Point<D>>> keyed;
  keyed.reserve(points.size());
  for (const Point<D>& p : points) {
    std::array<std::uint32_t, D> cell;
    for (int k = 0; k < D; ++k) {
      const double x = std::clamp((p[k] - lo[k]) * scale, 0.0, std::ldexp(1.0, kLevels) - 1);
      cell[k] = static_cast<std::uint32_t>(x);
    }
    keyed.emplace_back(geometry::HilbertCurve<D>::Key(cell, kLevels), p);
  }
  std::sort(keyed.begin(), keyed.end());
  for (std::size_t i = 0; i < keyed.size(); ++i) points[i] = keyed[i].second;
  return points;
}

// The corners first, in the order of the triangulation.
std::vector<Point2> BorderOf(const Options<2>& options) {
  const int cells = options.border_cells;
  std::vector<Point2> border = geometry::SquareBorder(options.lo, options.hi, cells,
                                                      (options.hi[0] - options.lo[0]) / cells);
  for (int i = 0; i < 4; ++i) std::swap(border[i], border[i * cells]);
  return border;
}
// In any dimension: the corners by their bits, then all others.
template <int D>
std::vector<Point<D>> BorderOf(const Options<D>& options) {
  const int cells = options.border_cells;
  std::vector<Point<D>> border, others;
  std::array<int, D> at = {};
  // Counts from (0, ..., 0) to (cells, ..., cells), the first axis fastest: corners by their bits.
  for (int k = 0; k < D;) {
    int sides = 0;
    Point<D> p;
    for (int axis = 0; axis < D; ++axis) {
      sides += at[axis] % cells == 0 ? 1 : 0;
      p[axis] = at[axis] == cells
                    ? options.hi[axis]
                    : options.lo[axis] + at[axis] * ((options.hi[axis] - options.lo[axis]) / cells);
    }
    if (sides == D) border.push_back(p);
    if (sides > 0 && sides < D) others.push_back(p);
    for (k = 0; k < D && ++at[k] > cells; ++k) at[k] = 0;
  }
  border.insert(border.end(), others.begin(), others.end());
  return border;
}
std::vector<Point3> BorderOf(const Options<3>& options) {
  return geometry::CubeBorder(options.lo, options.hi, options.border_cells,
                              (options.hi[0] - options.lo[0]) / options.border_cells);
}

}  // namespace

template <int D, class Location>
Svr<D, Location>::Svr(const Options<D>& options, std::vector<Point> points)
    : options_(options),
      points_(Sorted<D>(std::move(points), options.lo, options.hi)),
      location_(mesh_, points_) {
  AddBorder();
  for (PointIndex p = 0; p < points_.size(); ++p) {
    // Of few vertices.
    VertexIndex nearest = 0;
    for (VertexIndex v = 1; v < input_.size(); ++v) {
      if (geometry::SquaredDistance(points_[p], mesh_.position(v)) <
          geometry::SquaredDistance(points_[p], mesh_.position(nearest))) {
        nearest = v;
      }
    }
    location_.Assign(p, nearest);
  }
  for (VertexIndex v = 0; v < input_.size(); ++v) EnterCrowded(v);
  mesh_.ForEachSimplex([&](SimplexIndex s) { Enter(s); });
}

template <int D, class Location>
void Svr<D, Location>::AddBorder() {
  const std::vector<Point> border = BorderOf(options_);
  std::array<VertexIndex, std::size_t{1} << D> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<VertexIndex>(i);
  mesh_.Reset(options_.lo, options_.hi, corners);
  for (std::size_t i = corners.size(); i < border.size(); ++i) {
    mesh_.Insert(static_cast<VertexIndex>(i), border[i], static_cast<VertexIndex>(i - 1));
  }
  border_count_ = border.size();
  input_.assign(border.size(), kNone);
  is_entered_.assign(border.size(), false);
}

template <int D, class Location>
std::vector<VertexIndex> Svr<D, Location>::BorderAround() const requires(D == 2) {
  std::vector<VertexIndex> around(border_count_);
  for (VertexIndex v = 0; v < around.size(); ++v) around[v] = v;
  // As in BorderOf.
  const auto cells = static_cast<std::size_t>(options_.border_cells);
  for (std::size_t i = 4; i-- > 0;) std::swap(around[i], around[i * cells]);
  return around;
}

template <int D, class Location>
bool Svr<D, Location>::IsInDomain(const Point& p) const {
  for (int k = 0; k < D; ++k) {
    if (!(p[k] > options_.lo[k] && p[k] < options_.hi[k])) return false;
  }
  return true;
}

template <int D, class Location>
void Svr<D, Location>::Enter(SimplexIndex s) {
  const double r2 = BallOf(mesh_, s).r2, e2 = SquaredShortestEdge<D>(mesh_, s);
  const double most2 = options_.quality * options_.quality * e2;
  if (r2 <= most2) return;
  mesh_.set_tag(s, ++serial_);
  const Kind kind = r2 > kKept * kKept * most2 ? kSkinny : kModerate;
  work_[kind].push_back({kind, s, serial_});
}
template <int D, class Location>
void Svr<D, Location>::EnterCrowded(VertexIndex v) {
  if (!location_.IsCrowded(v) || is_entered_[v]) return;
  is_entered_[v] = true;
  work_[kCrowded].push_back({kCrowded, v, 0});
}

template <int D, class Location>
bool Svr<D, Location>::Next(Item* item) {
  for (const Kind kind : {kSkinny, kCrowded, kModerate}) {
    std::vector<Item>& work = work_[kind];
    while (!work.empty()) {
      *item = work.back();
      work.pop_back();
      const bool stands = kind == kCrowded
                              ? location_.IsCrowded(item->of)
                              : !mesh_.IsInfinite(item->of) && mesh_.tag(item->of) == item->serial;
      if (stands) return true;
      if (kind == kCrowded) is_entered_[item->of] = false;
    }
  }
  return false;
}

template <int D, class Location>
void Svr<D, Location>::Do(const Item& item) {
  ++(item.kind == kSkinny    ? counts_.skinny
     : item.kind == kCrowded ? counts_.crowded
                             : counts_.moderate);
  if (item.kind != kCrowded) {
    Split(item.of);
    return;
  }
  is_entered_[item.of] = false;
  DoCrowded(item.of);
  EnterCrowded(item.of);
}

template <int D, class Location>
void Svr<D, Location>::DoCrowded(VertexIndex v) {
  const PointIndex p = location_.AnyOf(v);
  SimplexIndex largest = kNone;
  double most = 0;
  mesh_.ForEachSimplexAround(v, [&](SimplexIndex s) {
    if (mesh_.IsInfinite(s) || !mesh_.Conflicts(s, points_[p])) return;
    const double r2 = BallOf(mesh_, s).r2;
    if (r2 > most) most = r2, largest = s;
  });
  // Points are far from a Steiner point, or it would have become one of them.
  if (input_[v] == kNone || !Split(largest)) Insert(points_[p], p, largest);
}

template <int D, class Location>
bool Svr<D, Location>::Split(SimplexIndex s) {
  const Ball<D> ball = BallOf(mesh_, s);
  const PointIndex p = location_.FindIn(s, ball, options_.k * std::sqrt(ball.r2));
  if (p != kNone) {
    ++counts_.warped;
    Insert(points_[p], p, s);
    return true;
  }
  if (!std::isfinite(ball.r2) || !IsInDomain(ball.centre)) {
    ++counts_.outside;
    return false;
  }
  Insert(ball.centre, kNone, s);
  return true;
}

template <int D, class Location>
void Svr<D, Location>::Insert(const Point& p, PointIndex input, SimplexIndex conflicting) {
  const auto v = static_cast<VertexIndex>(input_.size());
  input_.push_back(input);
  is_entered_.push_back(false);
  mesh_.InsertAt(v, p, conflicting);
  location_.Inserted(v, input);
  EnterCrowded(v);
  for (const SimplexIndex s : mesh_.created()) {
    if (!mesh_.IsInfinite(s)) Enter(s);
  }
}

template <int D, class Location>
double Svr<D, Location>::WorstSquaredRatio() const {
  double worst = 0;
  mesh_.ForEachSimplex([&](SimplexIndex s) {
    const Ball<D> ball = BallOf(mesh_, s);
    if (!IsInDomain(ball.centre)) return;
    worst = std::max(worst, ball.r2 / SquaredShortestEdge<D>(mesh_, s));
  });
  return worst;
}

template class Svr<2, VoronoiLocation<2, true>>;
template class Svr<2, VoronoiLocation<2, false>>;
template class Svr<3, VoronoiLocation<3, true>>;
template class Svr<3, VoronoiLocation<3, false>>;
template class Svr<4, VoronoiLocation<4, true>>;

}  // namespace dynmesh::svr
