#include "core/geometry/facet_interior.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace dynmesh::geometry {
namespace {

// Polygons with at most so many edges are searched edge by edge.
constexpr std::size_t kFewEdges = 48;

double Cross2(const Point2& u, const Point2& w) { return u[0] * w[1] - u[1] * w[0]; }
Point2 From(const Point2& a, const Point2& b) { return {{b[0] - a[0], b[1] - a[1]}}; }

}  // namespace

FacetInterior::FacetInterior(std::span<const Ring3> rings, const FacetPlane& plane)
    : axis_(plane.axis) {
  for (const Ring3& ring : rings) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      edges_.push_back({Shadow(std::min(ring[i], ring[j])), Shadow(std::max(ring[i], ring[j]))});
    }
  }
  if (edges_.size() > kFewEdges) MakeTree();
}

bool FacetInterior::Holds(const Point3& p) const {
  const Point2 at = Shadow(p);
  return IsOdd(at[1], false, [&](const Edge& e) { return IsLeftOf(at, e); });
}

// Takes a small step from the corner. It passes the corner's own edges at an angle; all other edges
// are far away. A step down is at heights just below the corner's.
bool FacetInterior::OpensTo(const Point3& corner, const Vector3& direction) const {
  const Point2 at = Shadow(corner), to = Shadow({direction});
  return IsOdd(at[1], to[1] < 0, [&](const Edge& e) {
    if (e.a != at && e.b != at) return IsLeftOf(at, e);
    const Point2 along = From(at, e.a == at ? e.b : e.a);
    return along[1] > 0 ? Cross2(along, to) > 0 : Cross2(along, to) < 0;
  });
}

// The x of edge e at `height`, from e.a on.
double FacetInterior::At(const Edge& e, double height) {
  return (e.b[0] - e.a[0]) * ((height - e.a[1]) / (e.b[1] - e.a[1]));
}

bool FacetInterior::IsLeftOf(const Point2& p, const Edge& e) { return p[0] - e.a[0] < At(e, p[1]); }

// Calls f(node) for the fewest nodes that together span the edge's heights.
template <class F>
void FacetInterior::ForEachNodeOf(const Edge& e, F f) const {
  const auto leaf_above = [this](double height) {
    const auto it = std::lower_bound(heights_.begin(), heights_.end(), height);
    return static_cast<std::uint32_t>(it - heights_.begin()) + leaves_;
  };
  const auto [low, high] = std::minmax({e.a[1], e.b[1]});
  for (std::uint32_t l = leaf_above(low), r = leaf_above(high); l < r; l /= 2, r /= 2) {
    if (l % 2 == 1) f(l++);
    if (r % 2 == 1) f(--r);
  }
}

void FacetInterior::MakeTree() {
  for (const Edge& e : edges_) heights_.push_back(e.a[1]), heights_.push_back(e.b[1]);
  std::sort(heights_.begin(), heights_.end());
  heights_.erase(std::unique(heights_.begin(), heights_.end()), heights_.end());
  heights_.shrink_to_fit();
  leaves_ = std::bit_ceil(static_cast<std::uint32_t>(heights_.size()));
  first_.assign(2 * leaves_ + 1, 0);
  for (const Edge& e : edges_) ForEachNodeOf(e, [&](std::uint32_t node) { ++first_[node + 1]; });
  for (std::uint32_t node = 0; node < 2 * leaves_; ++node) first_[node + 1] += first_[node];
  order_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t i = 0; i < edges_.size(); ++i) {
    ForEachNodeOf(edges_[i], [&](std::uint32_t node) { order_[next[node]++] = i; });
  }
  for (std::uint32_t node = 1; node < 2 * leaves_; ++node) SortNode(node);
}

// True if the edges, which span the same heights and have a common end, lie from left to right.
// Also true if they have no common end.
bool FacetInterior::IsOrderedAtEnd(const Edge& e, const Edge& f) {
  for (const bool at_a : {false, true}) {
    const Point2 &end = at_a ? e.a : e.b, &along = at_a ? e.b : e.a;
    if (f.a != end && f.b != end) continue;
    const Point2 u = From(end, along), w = From(end, f.a == end ? f.b : f.a);
    return u[1] > 0 ? Cross2(u, w) <= 0 : Cross2(u, w) >= 0;
  }
  return true;
}

// Sorts a node's edges half-way up its heights. There they are farther apart than rounding errors.
// Exceptions: edges that meet at the top or bottom of a very low node; these are adjacent then.
void FacetInterior::SortNode(std::uint32_t node) {
  const std::span<std::uint32_t> edges(order_.data() + first_[node],
                                       first_[node + 1] - first_[node]);
  if (edges.size() < 2) return;
  const int levels = std::bit_width(leaves_) - std::bit_width(node);
  const std::size_t low = (static_cast<std::size_t>(node) << levels) - leaves_;
  const std::size_t high = low + (std::size_t{1} << levels);
  const double middle = heights_[low] + (heights_[high] - heights_[low]) / 2;
  std::vector<std::pair<double, std::uint32_t>> by_place;
  for (const std::uint32_t i : edges) {
    by_place.emplace_back(edges_[i].a[0] + At(edges_[i], middle), i);
  }
  std::sort(by_place.begin(), by_place.end());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    std::size_t at = i;
    for (; at > 0; --at) {
      if (IsOrderedAtEnd(edges_[edges[at - 1]], edges_[by_place[i].second])) break;
      edges[at] = edges[at - 1];
    }
    edges[at] = by_place[i].second;
  }
}

// True if the number of edges to the right of a point at that height is odd. An edge includes the
// height of its lower end, not that of its upper end; if `below`, the other way round. is_left(e):
// the point is to the left of e, an edge at that height.
template <class IsLeft>
bool FacetInterior::IsOdd(double height, bool below, IsLeft is_left) const {
  bool odd = false;
  if (heights_.empty()) {
    const auto is_over = [&](const Point2& p) { return below ? p[1] >= height : p[1] > height; };
    for (const Edge& e : edges_) odd ^= is_over(e.a) != is_over(e.b) && is_left(e);
    return odd;
  }
  const auto over = below ? std::lower_bound(heights_.begin(), heights_.end(), height)
                          : std::upper_bound(heights_.begin(), heights_.end(), height);
  if (over == heights_.begin() || over == heights_.end()) return false;
  const auto leaf = static_cast<std::uint32_t>(over - heights_.begin()) - 1;
  for (std::uint32_t node = leaf + leaves_; node > 0; node /= 2) {
    const auto first = order_.begin() + first_[node], last = order_.begin() + first_[node + 1];
    const auto right =
        std::partition_point(first, last, [&](std::uint32_t i) { return !is_left(edges_[i]); });
    odd ^= (last - right) % 2 == 1;
  }
  return odd;
}

}  // namespace dynmesh::geometry
