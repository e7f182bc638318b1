#include "core/plc/size_rules.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/rings.h"
#include "core/geometry/segment_distance.h"
#include "core/plc/text.h"
#include "dynmesh/error.h"

namespace dynmesh::plc {
namespace {

using geometry::Point;
using geometry::Point2;

template <int D>
Extent<D> ExtentOf(const Box& box) {
  Extent<D> extent;
  for (int k = 0; k < D; ++k) extent.lo[k] = box.lo[k], extent.hi[k] = box.hi[k];
  return extent;
}

template <int D>
Extent<D> Around(const Point<D>& centre, double r) {
  Extent<D> extent;
  for (int k = 0; k < D; ++k) extent.lo[k] = centre[k] - r, extent.hi[k] = centre[k] + r;
  return extent;
}

template <int D>
double WidestSide(const Extent<D>& extent) {
  double widest = 0;
  for (int k = 0; k < D; ++k) widest = std::max(widest, extent.hi[k] - extent.lo[k]);
  return widest;
}

template <int D>
Extent<D> Empty(const Extent<D>& around) {
  return {around.hi, around.lo};
}

template <int D>
double MeasureOfBall(double r) {
  return std::numbers::pi * r * r * (D == 2 ? 1 : 4 * r / 3);
}

template <int D>
std::optional<SizeFault> FaultOfPosition(const Point<D>& p, const Box& box) {
  for (int k = 0; k < D; ++k) {
    if (!(p[k] < box.lo[k] || p[k] > box.hi[k])) continue;
    return SizeFault{reason::kOutsideBox,
                     absl::StrCat("is outside the mesh's box from ", Text(CornerOf<D>(box.lo)),
                                  " to ", Text(CornerOf<D>(box.hi)), "; move it inside")};
  }
  return std::nullopt;
}

std::optional<SizeFault> FaultOfRadius(double radius) {
  if (!(radius < 0)) return std::nullopt;
  return SizeFault{reason::kBadSize, "has a negative radius; give 0 or more"};
}

template <int D>
class PointRules final : public SizeRules<D> {
 public:
  std::optional<SizeFault> FaultOf(const SizeFeature<D>& size, const Box& box) const override {
    return FaultOfPosition(size.at, box);
  }
  double Measure(const SizeFeature<D>& /*size*/) const override { return 0; }
  double LeastMeasure(const SizeFeature<D>& /*size*/, const Box& /*domain*/) const override {
    return 0;
  }
  double LeastLength(const SizeFeature<D>& /*size*/, const Box& /*domain*/) const override {
    return 0;
  }
  SizeBounds<D> Bounds(const SizeFeature<D>& size, const Box& /*domain*/) const override {
    const Extent<D> at{size.at, size.at};
    return {at, at};
  }
};

template <int D>
class DiscRules final : public SizeRules<D> {
 public:
  std::optional<SizeFault> FaultOf(const SizeFeature<D>& size, const Box& box) const override {
    if (auto fault = FaultOfPosition(size.at, box); fault.has_value()) return fault;
    return FaultOfRadius(size.sizing.radius);
  }
  double Measure(const SizeFeature<D>& size) const override {
    return MeasureOfBall<D>(size.sizing.radius);
  }
  double LeastMeasure(const SizeFeature<D>& size, const Box& domain) const override {
    return MeasureOfBall<D>(RadiusIn(size, domain));
  }
  double LeastLength(const SizeFeature<D>& size, const Box& domain) const override {
    return 2 * RadiusIn(size, domain);
  }
  SizeBounds<D> Bounds(const SizeFeature<D>& size, const Box& domain) const override {
    const double r = RadiusIn(size, domain);
    return {Around(size.at, r), Around(size.at, r / std::sqrt(D)), size.at, size.at, r};
  }

 private:
  // The part that is certainly in the domain.
  static double RadiusIn(const SizeFeature<D>& size, const Box& domain) {
    double r = size.sizing.radius;
    for (int k = 0; k < D; ++k) {
      r = std::min({r, size.at[k] - domain.lo[k], domain.hi[k] - size.at[k]});
    }
    return std::max(r, 0.0);
  }
};

template <int D>
class BoxRules final : public SizeRules<D> {
 public:
  std::optional<SizeFault> FaultOf(const SizeFeature<D>& size, const Box& box) const override {
    bool swapped = false, beside = false;
    for (int k = 0; k < D; ++k) {
      const double lo = size.at[k], hi = size.sizing.hi[k];
      swapped |= hi < lo;
      beside |= hi < box.lo[k] || lo > box.hi[k];
    }
    if (swapped) {
      return SizeFault{reason::kBadSize, "has its upper corner below the lower; swap them"};
    }
    if (!beside) return std::nullopt;
    return SizeFault{reason::kOutsideBox, "does not meet the mesh's box; move it there"};
  }
  double Measure(const SizeFeature<D>& size) const override { return Whole(size).Measure(); }
  double LeastMeasure(const SizeFeature<D>& size, const Box& domain) const override {
    return Common(Whole(size), ExtentOf<D>(domain)).Measure();
  }
  double LeastLength(const SizeFeature<D>& size, const Box& domain) const override {
    return WidestSide(Common(Whole(size), ExtentOf<D>(domain)));
  }
  SizeBounds<D> Bounds(const SizeFeature<D>& size, const Box& domain) const override {
    const Extent<D> box = Common(Whole(size), ExtentOf<D>(domain));
    return {box, box};
  }

 private:
  static Extent<D> Whole(const SizeFeature<D>& size) {
    Extent<D> box{size.at, {}};
    for (int k = 0; k < D; ++k) box.hi[k] = size.sizing.hi[k];
    return box;
  }
};

template <int D>
class CapsuleRules final : public SizeRules<D> {
 public:
  std::optional<SizeFault> FaultOf(const SizeFeature<D>& size, const Box& box) const override {
    const Sizing& s = size.sizing;
    if (s.path.size() < 2) {
      return SizeFault{reason::kBadSize,
                       absl::StrCat("is a capsule with ", s.path.size(),
                                    " vertices; give at least 2, or a disc instead")};
    }
    if (s.path.size() > kMostPathVertices) {
      return SizeFault{reason::kBadSize,
                       absl::StrCat("is a capsule with ", s.path.size(), " vertices; give at most ",
                                    kMostPathVertices, ", or several capsules")};
    }
    for (std::size_t i = 0; i < s.path.size(); ++i) {
      const Point<D> p = CornerOf<D>(s.path[i]);
      if (i > 0 && p == CornerOf<D>(s.path[i - 1])) {
        return SizeFault{reason::kBadSize, absl::StrCat("has its vertex ", i + 1, " ", Text(p),
                                                        " where the one before is; leave it out")};
      }
      if (auto fault = FaultOfPosition(p, box); fault.has_value()) {
        fault->what =
            absl::StrCat("has a vertex, number ", i + 1, " ", Text(p), ", that ", fault->what);
        return fault;
      }
    }
    return FaultOfRadius(s.radius);
  }

  // The sum over the edges: where they overlap, the measure is less.
  double Measure(const SizeFeature<D>& size) const override {
    const double r = size.sizing.radius;
    double length = 0;
    ForEachEdge(size, [&](const Point<D>& p, const Point<D>& q) {
      length += std::sqrt(geometry::SquaredDistance(p, q));
    });
    return MeasureOfBall<D>(r) + length * CrossSection(r);
  }

  // The longest edge has its tube and two half balls. And each plane across an axis between two
  // vertices cuts off at least a ball's middle.
  double LeastMeasure(const SizeFeature<D>& size, const Box& domain) const override {
    const double r = RadiusIn(size, ExtentOfPath(size), domain);
    return MeasureOfBall<D>(r) + LeastLength(size, domain) * CrossSection(r);
  }
  double LeastLength(const SizeFeature<D>& size, const Box& /*domain*/) const override {
    const auto [p, q] = LongestEdge(size);
    return std::max(std::sqrt(geometry::SquaredDistance(p, q)), WidestSide(ExtentOfPath(size)));
  }

  SizeBounds<D> Bounds(const SizeFeature<D>& size, const Box& domain) const override {
    Extent<D> around = ExtentOfPath(size);
    const double r = RadiusIn(size, around, domain);
    for (int k = 0; k < D; ++k) around.lo[k] -= r, around.hi[k] += r;
    const auto [from, to] = LongestEdge(size);
    return {around, Empty(around), from, to, r};
  }

 private:
  static double CrossSection(double r) { return D == 2 ? 2 * r : std::numbers::pi * r * r; }
  template <class F>
  static void ForEachEdge(const SizeFeature<D>& size, F f) {
    const Path& path = size.sizing.path;
    for (std::size_t i = 1; i < path.size(); ++i) f(CornerOf<D>(path[i - 1]), CornerOf<D>(path[i]));
  }
  static std::pair<Point<D>, Point<D>> LongestEdge(const SizeFeature<D>& size) {
    std::pair<Point<D>, Point<D>> edge;
    double longest2 = -1;
    ForEachEdge(size, [&](const Point<D>& p, const Point<D>& q) {
      const double length2 = geometry::SquaredDistance(p, q);
      if (length2 > longest2) longest2 = length2, edge = {p, q};
    });
    return edge;
  }
  // The part that is certainly in the domain. `path`: its extent.
  static double RadiusIn(const SizeFeature<D>& size, const Extent<D>& path, const Box& domain) {
    double r = size.sizing.radius;
    for (int k = 0; k < D; ++k) {
      r = std::min({r, path.lo[k] - domain.lo[k], domain.hi[k] - path.hi[k]});
    }
    return std::max(r, 0.0);
  }
  static Extent<D> ExtentOfPath(const SizeFeature<D>& size) {
    const Point<D> first = CornerOf<D>(size.sizing.path.front());
    Extent<D> extent{first, first};
    for (const auto& vertex : size.sizing.path) {
      for (int k = 0; k < D; ++k) {
        extent.lo[k] = std::min(extent.lo[k], vertex[k]);
        extent.hi[k] = std::max(extent.hi[k], vertex[k]);
      }
    }
    return extent;
  }
};

// CheckRings judges the rings before.
class PolygonRules final : public SizeRules<2> {
 public:
  std::optional<SizeFault> FaultOf(const SizeFeature<2>& /*size*/,
                                   const Box& /*box*/) const override {
    return std::nullopt;
  }
  double Measure(const SizeFeature<2>& size) const override {
    double measure = 0;
    const Point2& o = size.positions.front().front();  // near all others: little rounding
    ForEachEdgeOf(size.positions, [&](const Point2& p, const Point2& q) {
      measure += 0.5 * ((p[0] - o[0]) * (q[1] - o[1]) - (q[0] - o[0]) * (p[1] - o[1]));
    });
    return std::abs(measure);
  }
  double LeastMeasure(const SizeFeature<2>& size, const Box& domain) const override;
  // Of a ring: rings belong to the region's border.
  double LeastLength(const SizeFeature<2>& size, const Box& /*domain*/) const override {
    double length = 0;
    for (const auto& ring : size.positions) {
      length = std::max(length, WidestSide(ExtentOfRings(std::span(&ring, 1))));
    }
    return length;
  }
  SizeBounds<2> Bounds(const SizeFeature<2>& size, const Box& /*domain*/) const override {
    const Extent<2> around = ExtentOfRings(size.positions);
    return {around, Empty(around)};
  }

 private:
  static Extent<2> ExtentOfRings(std::span<const std::vector<Point2>> rings) {
    Extent<2> extent{rings.front().front(), rings.front().front()};
    for (const auto& ring : rings) {
      for (const Point2& p : ring) {
        for (int k = 0; k < 2; ++k) {
          extent.lo[k] = std::min(extent.lo[k], p[k]);
          extent.hi[k] = std::max(extent.hi[k], p[k]);
        }
      }
    }
    return extent;
  }
};

// The area enclosed by an odd number of rings, of cells that no edge meets: rings may cross.
double PolygonRules::LeastMeasure(const SizeFeature<2>& size, const Box& /*domain*/) const {
  constexpr int kCells = 64;
  const auto& rings = size.positions;
  const Extent<2> extent = ExtentOfRings(rings);
  const double width = (extent.hi[0] - extent.lo[0]) / kCells,
               height = (extent.hi[1] - extent.lo[1]) / kCells;
  if (!(width > 0 && height > 0)) return 0;
  std::vector<std::uint8_t> met(kCells * kCells), turned(kCells * kCells);
  const auto cell = [](double x) { return std::clamp(static_cast<int>(x), 0, kCells - 1); };
  ForEachEdgeOf(rings, [&](const Point2& p, const Point2& q) {
    // In cells, the lower end first.
    double x0 = (p[0] - extent.lo[0]) / width, y0 = (p[1] - extent.lo[1]) / height;
    double x1 = (q[0] - extent.lo[0]) / width, y1 = (q[1] - extent.lo[1]) / height;
    if (y1 < y0) std::swap(x0, x1), std::swap(y0, y1);
    const auto at = [&](double y) {
      return y1 > y0 ? x0 + (x1 - x0) * std::clamp((y - y0) / (y1 - y0), 0.0, 1.0) : x0;
    };
    constexpr double kHair = 1e-6;
    for (int row = cell(y0 - kHair); row <= cell(y1 + kHair); ++row) {
      const auto [left, right] =
          y1 > y0 ? std::minmax({at(row - kHair), at(row + 1 + kHair)}) : std::minmax({x0, x1});
      for (int i = cell(left - kHair); i <= cell(right + kHair); ++i) met[row * kCells + i] = 1;
      const double middle = row + 0.5;
      if (!(y0 <= middle && middle < y1)) continue;
      // Cells with middles to the right.
      const double first = std::ceil(at(middle) - 0.5);
      if (first < kCells) turned[row * kCells + std::max(0, static_cast<int>(first))] ^= 1;
    }
  });
  int inside = 0;
  for (int row = 0; row < kCells; ++row) {
    int parity = 0;
    for (int i = row * kCells; i < (row + 1) * kCells; ++i) {
      parity ^= turned[i];
      inside += parity != 0 && met[i] == 0;
    }
  }
  return inside * width * height;
}

}  // namespace

template <int D>
bool SizeBounds<D>::Holds(const Extent<D>& cell) const {
  // What is within a distance of a segment is convex.
  for (int corner = 0; corner < 1 << D; ++corner) {
    Point<D> p;
    for (int k = 0; k < D; ++k) p[k] = (corner >> k & 1) != 0 ? cell.hi[k] : cell.lo[k];
    if (!(geometry::SquaredDistance(p, from, to) < radius * radius)) return false;
  }
  return true;
}

template <int D>
const SizeRules<D>* FindSizeRules(SizeShape shape) {
  static const PointRules<D> point;
  static const DiscRules<D> disc;
  static const BoxRules<D> box;
  static const CapsuleRules<D> capsule;
  switch (shape) {
    case SizeShape::kPoint:
      return &point;
    case SizeShape::kDisc:
      return &disc;
    case SizeShape::kBox:
      return &box;
    case SizeShape::kCapsule:
      return &capsule;
    case SizeShape::kPolygon:
      if constexpr (D == 2) {
        static const PolygonRules polygon;
        return &polygon;
      }
      return nullptr;
  }
  return nullptr;
}

template struct SizeBounds<2>;
template struct SizeBounds<3>;
template const SizeRules<2>* FindSizeRules(SizeShape);
template const SizeRules<3>* FindSizeRules(SizeShape);

}  // namespace dynmesh::plc
