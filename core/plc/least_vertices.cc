#include "core/plc/least_vertices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "core/geometry/angles.h"
#include "core/geometry/circumball.h"
#include "core/plc/size_rules.h"

namespace dynmesh::plc {
namespace {

using geometry::Cross;
using geometry::Difference;
using geometry::Dot;
using geometry::Point;
using geometry::Point2;
using geometry::Point3;
using geometry::Vector3;

// More than any mesh has, and far from overflow.
constexpr double kMost = 1e300;
// For rounding, of coordinates (QualitySlack) and in this file.
constexpr double kSlack = 1.02;

// --- Regions ----------------------------------------------------------------------------

// Vertices of a region of measure 1 at target length 1.
template <int D>
constexpr double kDensity = (D == 2 ? 4 / (3 * 1.7320508075688772)
                                    : 3 / (4 * std::numbers::pi) * 2.8284271247461903) /
                            kSlack;

// The number of vertices, not 1/h^D alone, which may overflow.
template <int D>
double Vertices(double measure, double target) {
  double n = kDensity<D>;
  const double side = std::pow(measure, 1.0 / D);
  for (int k = 0; k < D; ++k) n = std::min(n * (side / target), kMost);
  return n;
}

template <int D>
double VerticesByMeasure(const SizeFeature<D>& size, const Box& domain) {
  return Vertices<D>(RulesOf(size).LeastMeasure(size, domain), size.sizing.target);
}

// On a length of 1 at target length 1.
constexpr double kDensityOnLength = 0.70710678118654752 / kSlack;

template <int D>
double VerticesByLength(const SizeFeature<D>& size, const Box& domain) {
  const double length = RulesOf(size).LeastLength(size, domain);
  return std::min(kDensityOnLength * (length / size.sizing.target), kMost);
}

template <int D>
Extent<D> Nothing() {
  Extent<D> extent;
  for (int k = 0; k < D; ++k) extent.lo[k] = INFINITY, extent.hi[k] = -INFINITY;
  return extent;
}

// Cells over some regions; in each the greatest number of vertices that one region has there.
template <int D>
class DemandCells {
 public:
  explicit DemandCells(const Extent<D>& all) : all_(all) {
    std::size_t cells = 1;
    for (int k = 0; k < D; ++k) cells *= kCells;
    most_.resize(cells);
  }

  // Adds a region within `around` with `vertices`. If it lies in several cells, `in` returns how
  // many of these are certainly in a given cell.
  template <class In>
  void Add(const Extent<D>& around, double vertices, In in) {
    std::array<int, D> first, last, at;
    bool single = true;
    for (int k = 0; k < D; ++k) {
      first[k] = CellAt(around.lo[k], k);
      last[k] = CellAt(around.hi[k], k);
      single = single && first[k] == last[k];
    }
    at = first;
    while (visits_++ < kMostVisits) {
      std::size_t index = 0;
      Extent<D> cell;
      for (int k = 0; k < D; ++k) {
        index = index * kCells + at[k];
        cell.lo[k] = all_.lo[k] + at[k] * Side(k);
        cell.hi[k] = cell.lo[k] + Side(k);
      }
      most_[index] = std::max(most_[index], single ? vertices : in(cell));
      int k = 0;
      while (k < D && ++at[k] > last[k]) at[k] = first[k], ++k;
      if (k == D) return;
    }
  }

  double Sum() const {
    double sum = 0;
    for (const double most : most_) sum += most;
    return std::min(sum, kMost);
  }

 private:
  static constexpr int kCells = D == 2 ? 64 : 16;
  static constexpr int kMostVisits = 1 << 22;  // omitted visits make the sum smaller

  double Side(int axis) const { return (all_.hi[axis] - all_.lo[axis]) / kCells; }
  int CellAt(double x, int axis) const {
    const double side = Side(axis);
    if (!(side > 0)) return 0;
    return static_cast<int>(std::clamp((x - all_.lo[axis]) / side, 0.0, kCells - 1.0));
  }

  Extent<D> all_;
  std::vector<double> most_;
  int visits_ = 0;
};

// --- Facets -----------------------------------------------------------------------------

const std::vector<Point3>* OnlyRing(const Facet& f) {
  return f.feature().positions.size() == 1 ? &f.feature().positions.front() : nullptr;
}

// Does an angle of the ring make triangles near it exempt from the quality (shells.h)?
bool HasSharpCorner(const std::vector<Point3>& ring) {
  const std::size_t n = ring.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (geometry::IsSmallAngle(ring[i], ring[(i + 1) % n], ring[(i + n - 1) % n])) return true;
  }
  return false;
}

double NormOf(const Vector3& v) { return std::sqrt(Dot(v, v)); }

// The greatest distance of p's projection outside of the convex ring of g; infinite if the ring is
// not convex.
double Overhang(const std::vector<Point3>& ring, const Vector3& normal, const Point3& p) {
  // The ring's orientation; every corner must turn that way.
  double turning = 0;
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    turning +=
        Dot(normal, Cross(Difference(ring[i].c, ring[0].c), Difference(ring[i + 1].c, ring[0].c)));
  }
  double most = -INFINITY;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point3 &a = ring[i], &b = ring[(i + 1) % ring.size()], &c = ring[(i + 2) % ring.size()];
    const Vector3 edge = Difference(b.c, a.c), next = Difference(c.c, b.c);
    const double sign = turning > 0 ? 1 : -1;
    if (sign * Dot(normal, Cross(edge, next)) < -1e-9 * NormOf(edge) * NormOf(next)) {
      return INFINITY;
    }
    const double inward = sign * Dot(normal, Cross(edge, Difference(p.c, a.c))) / NormOf(edge);
    most = std::max(most, -inward);
  }
  return most;
}

}  // namespace

template <int D>
double LeastVerticesIn(const SizeFeature<D>& size, const Box& domain) {
  return std::max(VerticesByMeasure(size, domain), VerticesByLength(size, domain));
}

template <int D>
double LeastVerticesIn(std::span<const SizeFeature<D>> sizes, const Box& domain) {
  std::vector<SizeBounds<D>> bounds;
  Extent<D> all = Nothing<D>();
  for (const SizeFeature<D>& size : sizes) {
    const Extent<D>& around = bounds.emplace_back(RulesOf(size).Bounds(size, domain)).around;
    for (int k = 0; k < D; ++k) {
      all.lo[k] = std::min(all.lo[k], around.lo[k]);
      all.hi[k] = std::max(all.hi[k], around.hi[k]);
    }
  }
  DemandCells<D> cells(all);
  double longest = 0;  // lengths side by side can have the same vertices, so they have no sum
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const SizeBounds<D>& region = bounds[i];
    longest = std::max(longest, VerticesByLength(sizes[i], domain));
    cells.Add(region.around, VerticesByMeasure(sizes[i], domain), [&](const Extent<D>& cell) {
      const double measure =
          region.Holds(cell) ? cell.Measure() : Common(region.box, cell).Measure();
      return Vertices<D>(measure, sizes[i].sizing.target);
    });
  }
  return std::max(cells.Sum(), longest);
}

template <int D>
double TargetFor(const SizeFeature<D>& size, const Box& domain, double most) {
  const SizeRules<D>& rules = RulesOf(size);
  return std::max(std::pow(rules.LeastMeasure(size, domain) * kDensity<D> / most, 1.0 / D),
                  rules.LeastLength(size, domain) * kDensityOnLength / most);
}

template <int D>
SizeFeature<D> SizeOfMaxEdge(const MeshOptions& options) {
  SizeFeature<D> size;
  size.sizing = {SizeShape::kBox, options.max_edge, 0, options.box.hi};
  std::copy_n(options.box.lo.begin(), D, size.at.c.begin());
  return size;
}

double LeastVerticesOn(const Facet& f, const Facet& g, double quality, double limit) {
  const std::vector<Point3>*const below = OnlyRing(f), *const above = OnlyRing(g);
  if (below == nullptr || above == nullptr) return 0;
  if (HasSharpCorner(*below) || HasSharpCorner(*above)) return 0;
  const double cosine = std::abs(Dot(f.plane().normal, g.plane().normal));
  if (!(cosine > 0.5)) return 0;
  double least = INFINITY, most = -INFINITY;
  for (const Point3& p : *below) {
    const double h = g.plane().Height(p);
    least = std::min(least, h);
    most = std::max(most, h);
  }
  if (least * most <= 0) return 0;  // it passes through, or touches
  const double height =
      std::max(std::max(-least, most) / cosine + f.deviation() + g.deviation(), limit / 2);
  for (const Point3& p : *below) {
    if (!(Overhang(*above, g.plane().normal, p) <= 1e-3 * height)) return 0;
  }
  const double rho = quality * kSlack, radius = 4 * rho * rho * height;
  return std::min(f.area() / (std::numbers::pi * radius * radius), kMost);
}

double DistanceFor(const Facet& f, double vertices, double quality) {
  const double rho = quality * kSlack;
  return std::sqrt(f.area() / (std::numbers::pi * vertices)) / (4 * rho * rho);
}

template double LeastVerticesIn(const SizeFeature<2>&, const Box&);
template double LeastVerticesIn(const SizeFeature<3>&, const Box&);
template double LeastVerticesIn(std::span<const SizeFeature<2>>, const Box&);
template double LeastVerticesIn(std::span<const SizeFeature<3>>, const Box&);
template double TargetFor(const SizeFeature<2>&, const Box&, double);
template double TargetFor(const SizeFeature<3>&, const Box&, double);
template SizeFeature<2> SizeOfMaxEdge<2>(const MeshOptions&);
template SizeFeature<3> SizeOfMaxEdge<3>(const MeshOptions&);
}  // namespace dynmesh::plc
