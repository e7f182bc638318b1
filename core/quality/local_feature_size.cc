#include "core/quality/local_feature_size.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <queue>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/base/feature_kinds.h"
#include "core/base/rings.h"
#include "core/geometry/segment_distance.h"
#include "dynmesh/quality.h"

namespace dynmesh::quality {
namespace {

using geometry::Point3;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kItemsOfLeaf = 4;

std::vector<FeatureId> Common(const std::vector<FeatureId>& a, const std::vector<FeatureId>& b) {
  std::vector<FeatureId> common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  return common;
}

}  // namespace

LocalFeatureSize::LocalFeatureSize(std::span<const Feature> features, int dimension) {
  absl::flat_hash_map<FeatureId, Point3> points;
  for (const Feature& f : features) {
    if (!IsPoint(f)) continue;
    const Point3 p{{f.position[0], f.position[1], dimension == 3 ? f.position[2] : 0}};
    points[f.id] = p;
    AddSegment(p, p, {f.id});
  }
  absl::flat_hash_set<std::pair<FeatureId, FeatureId>> edges;
  const auto add_segment = [&](FeatureId a, FeatureId b) {
    if (!points.contains(a) || !points.contains(b)) return;
    const auto [lesser, greater] = std::pair(std::min(a, b), std::max(a, b));
    if (!edges.emplace(lesser, greater).second) return;
    AddSegment(points.at(a), points.at(b), {lesser, greater});
  };
  for (const Feature& f : features) {
    if (Is<ASegment>(f, Not<APoint, APolygon, ASize>)) add_segment(f.ends[0], f.ends[1]);
    if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
    const bool is_known = std::ranges::all_of(f.rings, [&](const std::vector<FeatureId>& ring) {
      return !ring.empty() &&
             std::ranges::all_of(ring, [&](FeatureId id) { return points.contains(id); });
    });
    if (!is_known || f.rings.empty()) continue;
    std::vector<geometry::Ring3> rings;
    std::vector<FeatureId> corners;
    for (const std::vector<FeatureId>& ring : f.rings) {
      geometry::Ring3& positions = rings.emplace_back();
      for (const FeatureId id : ring) positions.push_back(points.at(id));
      corners.insert(corners.end(), ring.begin(), ring.end());
    }
    ForEachEdgeOf(f.rings, add_segment);
    if (dimension == 2) continue;
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    const geometry::FacetPlane plane = geometry::PlaneOf(rings);
    geometry::FacetInterior interior(rings, plane);
    const geometry::FacetBounds bounds = geometry::BoundsOf(rings, plane);
    items_.push_back({{bounds.lo, bounds.hi},
                      {},
                      {},
                      static_cast<std::uint32_t>(facets_.size()),
                      std::move(corners)});
    facets_.push_back({std::move(rings), plane, std::move(interior)});
  }
  nodes_.emplace_back();
  Build(0, 0, static_cast<std::uint32_t>(items_.size()));
}

void LocalFeatureSize::AddSegment(const Point3& p, const Point3& q, std::vector<FeatureId> ends) {
  Bounds box;
  for (int k = 0; k < 3; ++k) box.lo[k] = std::min(p[k], q[k]), box.hi[k] = std::max(p[k], q[k]);
  items_.push_back({box, p, q, kNone, std::move(ends)});
}

// Splits at the median of the middles, across the widest side.
void LocalFeatureSize::Build(std::uint32_t node, std::uint32_t first, std::uint32_t last) {
  Bounds box{{{kInfinite, kInfinite, kInfinite}}, {{-kInfinite, -kInfinite, -kInfinite}}};
  for (std::uint32_t i = first; i < last; ++i) {
    const Bounds& own = items_[i].box;
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = std::min(box.lo[k], own.lo[k]);
      box.hi[k] = std::max(box.hi[k], own.hi[k]);
    }
  }
  nodes_[node] = {box, kNone, first, last};
  if (last - first <= kItemsOfLeaf) return;
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (box.hi[k] - box.lo[k] > box.hi[axis] - box.lo[axis]) axis = k;
  }
  const std::uint32_t middle = first + (last - first) / 2;
  const auto at = [&](const Item& item) { return item.box.lo[axis] + item.box.hi[axis]; };
  std::nth_element(items_.begin() + first, items_.begin() + middle, items_.begin() + last,
                   [&](const Item& a, const Item& b) { return at(a) < at(b); });
  const auto left = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].left = left;
  nodes_.resize(nodes_.size() + 2);
  Build(left, first, middle);
  Build(left + 1, middle, last);
}

double LocalFeatureSize::DistanceTo(const Item& item, const Point3& x) const {
  if (item.facet == kNone) return std::sqrt(geometry::SquaredDistance(x, item.p, item.q));
  const Facet& facet = facets_[item.facet];
  if (facet.interior.Holds(facet.plane.Foot(x))) return std::fabs(facet.plane.Height(x));
  double least2 = kInfinite;
  ForEachEdgeOf(facet.rings, [&](const Point3& p, const Point3& q) {
    least2 = std::min(least2, geometry::SquaredDistance(x, p, q));
  });
  return std::sqrt(least2);
}

// Features come by distance. The first that is disjoint from an earlier one decides.
double LocalFeatureSize::At(const Point3& x) const {
  struct Entry {
    double distance;
    std::uint32_t index;
    bool is_item;
    bool operator>(const Entry& other) const { return distance > other.distance; }
  };
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto push_node = [&](std::uint32_t node) {
    const Bounds& box = nodes_[node].box;
    double d2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = std::max({0.0, box.lo[k] - x[k], x[k] - box.hi[k]});
      d2 += d * d;
    }
    queue.push({std::sqrt(d2), node, false});
  };
  push_node(0);
  std::vector<std::uint32_t> met;
  std::vector<FeatureId> common;  // of all of them
  while (!queue.empty()) {
    const Entry entry = queue.top();
    queue.pop();
    if (!entry.is_item) {
      const Node& node = nodes_[entry.index];
      if (node.left != kNone) {
        push_node(node.left);
        push_node(node.left + 1);
        continue;
      }
      for (std::uint32_t i = node.first; i < node.last; ++i) {
        queue.push({DistanceTo(items_[i], x), i, true});
      }
      continue;
    }
    const std::vector<FeatureId>& points = items_[entry.index].points;
    common = met.empty() ? points : Common(common, points);
    const auto is_disjoint = [&](std::uint32_t i) {
      return Common(items_[i].points, points).empty();
    };
    if (common.empty() && std::ranges::any_of(met, is_disjoint)) return entry.distance;
    met.push_back(entry.index);
  }
  return kInfinite;
}

}  // namespace dynmesh::quality

namespace dynmesh {

std::vector<double> LocalFeatureSizes(std::span<const Feature> features, int dimension,
                                      std::span<const double> points) {
  const quality::LocalFeatureSize size(features, dimension);
  const auto width = static_cast<std::size_t>(dimension);
  std::vector<double> sizes;
  sizes.reserve(points.size() / width);
  for (std::size_t i = 0; i + width <= points.size(); i += width) {
    sizes.push_back(size.At({{points[i], points[i + 1], dimension == 3 ? points[i + 2] : 0}}));
  }
  return sizes;
}

}  // namespace dynmesh
