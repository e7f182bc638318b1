// The input's points and segments by position. The query: which feature is nearest to the middle of
// a subsegment, of those too near to the subsegment (presplit.h).
//
// A quadtree or octree of cells; a cell lists the features that meet it. A cell is cut if it lists
// more than kCapacity features, unless all of these have a common vertex: cutting would not
// separate segments that meet at a point. So a segment is listed in O(m) cells, m the number of
// vertices on it: cells are about as large as the local feature size.
//
// Answers are a function of the features present. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_INPUT_FEATURES_H_
#define DYNMESH_CORE_MESHING_INPUT_FEATURES_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/rounding.h"
#include "core/geometry/point.h"
#include "core/geometry/segment_distance.h"

namespace dynmesh::meshing {

// A point (b = a) or a segment of the input, by its vertices, the lesser point first.
template <int D>
struct InputFeature {
  std::uint32_t a = 0, b = 0;
  geometry::Point<D> p = {}, q = {};
  bool unsplit = false;  // a segment that stays whole

  bool Has(std::uint32_t v) const { return a == v || b == v; }
  bool IsDisjoint(std::uint32_t v, std::uint32_t w) const { return !Has(v) && !Has(w); }
  friend bool operator==(const InputFeature& x, const InputFeature& y) {
    return x.a == y.a && x.b == y.b && x.unsplit == y.unsplit;
  }
};

template <int D>
class InputFeatures {
 public:
  using Point = geometry::Point<D>;
  using Feature = InputFeature<D>;

  // Covers the box, in which all features lie.
  InputFeatures(const Point& lo, const Point& hi) {
    for (int k = 0; k < D; ++k) {
      root_.centre[k] = 0.5 * (lo[k] + hi[k]);
      root_.half = std::max(root_.half, 0.5 * (hi[k] - lo[k]));
    }
    nodes_.emplace_back();
  }

  // O(cells that it meets), plus the cells cut because of it.
  void Add(const Feature& feature) { Add(root_, 0, feature); }
  // REQUIRES: it is there.
  void Remove(const Feature& feature) { Remove(root_, feature); }

  // Two vertices, or kNone.
  using Vertices = std::array<std::uint32_t, 2>;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  // Calls visit(feature) for the features nearer to `centre` than sqrt(radius2), near cells first;
  // some are visited more than once. `radius2` may shrink meanwhile. Skips
  //   cells for which may_matter(centre of the cell, half of its side) is false, and
  //   cells in which all features have one of the `ends`. So of thousands of segments that meet at
  //   a point, none is visited for a subsegment of one of them.
  template <class MayMatter, class Visit>
  void VisitNear(const Point& centre, const double& radius2, const Vertices& ends,
                 MayMatter may_matter, Visit visit) const {
    VisitNear(SmallestAround(centre, std::sqrt(radius2)), centre, radius2, ends, may_matter, visit);
  }

  std::size_t bytes() const {
    std::size_t bytes = nodes_.capacity() * sizeof(Node);
    for (const Node& node : nodes_) bytes += node.features.capacity() * sizeof(Feature);
    return bytes;
  }

 private:
  static constexpr std::size_t kCapacity = 8;
  static constexpr int kMostDepth = 48;
  static constexpr int kChildren = 1 << D;

  struct Node {
    std::uint32_t child = kNone;  // the first of kChildren
    // Vertices that all features of the cell have; kNone if there are fewer than two. Conservative:
    // after removals there may be more.
    Vertices common = {kNone, kNone};
    std::vector<Feature> features;  // empty if the cell is cut
  };
  struct Cell {
    std::uint32_t node = 0;
    Point centre = {};
    double half = 0;
  };

  Cell Child(const Cell& cell, int i) const {
    Cell child{nodes_[cell.node].child + static_cast<std::uint32_t>(i), cell.centre, cell.half / 2};
    for (int k = 0; k < D; ++k) child.centre[k] += (i >> k & 1) != 0 ? child.half : -child.half;
    return child;
  }
  // The child on x's side of each plane.
  static int ChildTowards(const Cell& cell, const Point& x) {
    int child = 0;
    for (int k = 0; k < D; ++k) child |= (x[k] >= cell.centre[k] ? 1 : 0) << k;
    return child;
  }
  // The sides of a cell's middle planes on which a feature is, and the planes that it crosses: a
  // bit for each axis.
  struct Sides {
    int upper = 0, crossed = 0;
  };
  static Sides SidesOf(const Cell& cell, const Feature& feature) {
    const double slack = 1e-9 * cell.half;
    Sides sides;
    for (int k = 0; k < D; ++k) {
      const bool below = std::min(feature.p[k], feature.q[k]) <= cell.centre[k] + slack,
                 above = std::max(feature.p[k], feature.q[k]) >= cell.centre[k] - slack;
      sides.upper |= (below ? 0 : 1) << k;
      sides.crossed |= (below && above ? 1 : 0) << k;
    }
    return sides;
  }
  // Calls f(child) for each child of the cell that the feature meets. REQUIRES: the feature meets
  // the cell, and the cell is cut.
  template <class F>
  void ForChildrenMet(const Cell& cell, const Feature& feature, F f) const {
    const Sides sides = SidesOf(cell, feature);
    if (sides.crossed == 0) return f(Child(cell, sides.upper));
    for (int i = 0; i < kChildren; ++i) {
      if (((i ^ sides.upper) & ~sides.crossed) != 0) continue;
      const Cell child = Child(cell, i);
      if (Meets(child, feature)) f(child);
    }
  }
  // The smallest cell that contains the ball; the root if none does.
  Cell SmallestAround(const Point& centre, double radius) const {
    Cell cell = root_;
    while (nodes_[cell.node].child != kNone) {
      for (int k = 0; k < D; ++k) {
        if (!(std::fabs(centre[k] - cell.centre[k]) > radius)) return cell;
      }
      cell = Child(cell, ChildTowards(cell, centre));
    }
    return cell;
  }
  // Conservative: may return true needlessly.
  static bool Meets(const Cell& cell, const Feature& f) {
    return geometry::MayMeetCube(cell.centre, cell.half * kBarelyWider, f.p, f.q);
  }
  static double Distance2(const Cell& cell, const Point& p) {
    double d2 = 0;
    for (int k = 0; k < D; ++k) {
      const double d = std::max(0.0, std::fabs(p[k] - cell.centre[k]) - cell.half * kBarelyWider);
      d2 += d * d;
    }
    return d2 * (1 - 1e-12);
  }

  void Add(Cell cell, int depth, const Feature& feature);
  void Remove(const Cell& cell, const Feature& feature);
  void Cut(const Cell& cell, int depth);
  void Join(std::uint32_t node);
  template <class MayMatter, class Visit>
  void VisitNear(const Cell& cell, const Point& centre, const double& radius2, const Vertices& ends,
                 MayMatter& may_matter, Visit& visit) const;

  Cell root_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> free_;  // first of kChildren each
};

template <int D>
void InputFeatures<D>::Add(Cell cell, int depth, const Feature& feature) {
  // Most features are small beside most cells, and descend into one child.
  for (; nodes_[cell.node].child != kNone; ++depth) {
    const Sides sides = SidesOf(cell, feature);
    if (sides.crossed != 0) {
      return ForChildrenMet(cell, feature,
                            [&](const Cell& child) { Add(child, depth + 1, feature); });
    }
    cell = Child(cell, sides.upper);
  }
  Node& node = nodes_[cell.node];
  if (node.features.empty()) {
    node.common = {feature.a, feature.b};
  } else {
    for (std::uint32_t& v : node.common) {
      if (!feature.Has(v)) v = kNone;
    }
  }
  if (node.features.empty()) node.features.reserve(kCapacity / 2);
  node.features.push_back(feature);
  const bool has_common = node.common[0] != kNone || node.common[1] != kNone;
  if (node.features.size() > kCapacity && !has_common && depth < kMostDepth) Cut(cell, depth);
}

template <int D>
void InputFeatures<D>::Cut(const Cell& cell, int depth) {
  std::uint32_t first = static_cast<std::uint32_t>(nodes_.size());
  if (free_.empty()) {
    nodes_.resize(nodes_.size() + kChildren);
  } else {
    first = free_.back();
    free_.pop_back();
  }
  const std::vector<Feature> features = std::exchange(nodes_[cell.node].features, {});
  nodes_[cell.node].child = first;
  for (const Feature& f : features) Add(cell, depth, f);
}

template <int D>
void InputFeatures<D>::Remove(const Cell& cell, const Feature& feature) {
  if (nodes_[cell.node].child == kNone) {
    auto& features = nodes_[cell.node].features;
    const auto at = std::find(features.begin(), features.end(), feature);
    *at = features.back();
    features.pop_back();
    return;
  }
  ForChildrenMet(cell, feature, [&](const Cell& child) { Remove(child, feature); });
  Join(cell.node);
}

// Merges children that together list few features.
template <int D>
void InputFeatures<D>::Join(std::uint32_t n) {
  const std::uint32_t first = nodes_[n].child;
  std::size_t count = 0;
  for (int i = 0; i < kChildren; ++i) {
    if (nodes_[first + i].child != kNone) return;
    count += nodes_[first + i].features.size();
  }
  if (count > kCapacity / 2) return;
  Node joined;
  for (int i = 0; i < kChildren; ++i) {
    for (const Feature& f : nodes_[first + i].features) {
      if (std::find(joined.features.begin(), joined.features.end(), f) == joined.features.end()) {
        joined.features.push_back(f);
      }
    }
    nodes_[first + i] = {};
  }
  if (!joined.features.empty()) {
    joined.common = {joined.features[0].a, joined.features[0].b};
    for (const Feature& f : joined.features) {
      for (std::uint32_t& v : joined.common) {
        if (!f.Has(v)) v = kNone;
      }
    }
  }
  nodes_[n] = std::move(joined);
  free_.push_back(first);
}

template <int D>
template <class MayMatter, class Visit>
void InputFeatures<D>::VisitNear(const Cell& cell, const Point& centre, const double& radius2,
                                 const Vertices& ends, MayMatter& may_matter, Visit& visit) const {
  const Node& node = nodes_[cell.node];
  if (node.child == kNone) {
    for (const std::uint32_t v : node.common) {
      if (v != kNone && (v == ends[0] || v == ends[1])) return;
    }
    for (const Feature& f : node.features) visit(f);
    return;
  }
  // The nearest child first, then those across one plane, two planes, three planes.
  const int nearest = ChildTowards(cell, centre);
  constexpr std::array<int, 8> kByPlanes = {0, 1, 2, 4, 3, 5, 6, 7};
  for (const int differs : kByPlanes) {
    if (differs >= kChildren) continue;
    const Cell child = Child(cell, nearest ^ differs);
    if (!(Distance2(child, centre) < radius2) || !may_matter(child.centre, child.half)) continue;
    VisitNear(child, centre, radius2, ends, may_matter, visit);
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_INPUT_FEATURES_H_
