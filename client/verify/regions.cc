// Checks every triangle's set of polygons, by exact point location of one point strictly inside it,
// by counting crossings. This point represents the whole triangle if no edge of a polygon runs
// through it. That follows if CheckInput finds these edges to be chains of mesh edges, and the
// other checks find that triangles do not overlap.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "absl/container/flat_hash_map.h"
#include "client/verify/verify_internal.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using ExactKernel = CGAL::Simple_cartesian<CGAL::Exact_rational>;

// An edge of a polygon, from its lower end to its upper one.
struct RisingEdge {
  double x0, y0, x1, y1;
  std::uint32_t polygon;  // row in `ids`
};

// The location of a point.
struct Location {
  std::vector<FeatureId> inside;   // polygons, ascending
  FeatureId on_edge = kNoFeature;  // a polygon with the point on its edge
};

class PolygonIndex {
 public:
  PolygonIndex(const std::vector<Feature>& features, Findings& findings) {
    absl::flat_hash_map<FeatureId, const Feature*> points;
    std::vector<const Feature*> polygons;
    for (const Feature& f : features) {
      if (IsPoint(f)) points.emplace(f.id, &f);
      if (Is<APolygon>(f, Not<APoint, ASegment, ASize>)) polygons.push_back(&f);
    }
    std::sort(polygons.begin(), polygons.end(),
              [](const Feature* f, const Feature* g) { return f->id < g->id; });
    for (const Feature* polygon : polygons) {
      for (const auto& ring : polygon->rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
          const auto p = points.find(ring[i]);
          const auto q = points.find(ring[(i + 1) % ring.size()]);
          if (p == points.end() || q == points.end()) {
            findings.Add(
                Concat("input polygon ", polygon->id, " has a corner that is no input point"));
          } else {
            AddEdge(*p->second, *q->second);
          }
        }
      }
      ids_.push_back(polygon->id);
    }
    MakeBands();
  }

  Location Locate(const Kernel::Point_2& at) const {
    std::vector<std::uint32_t> crossed;
    Location location;
    for (const std::uint32_t e : bands_[BandOf(at.y())]) {
      Cross<Kernel>(edges_[e], at, crossed, location);
    }
    return Finish(std::move(crossed), std::move(location));
  }

  // For any rational point; O(edges).
  Location Locate(const ExactKernel::Point_2& at) const {
    std::vector<std::uint32_t> crossed;
    Location location;
    for (const RisingEdge& e : edges_) Cross<ExactKernel>(e, at, crossed, location);
    return Finish(std::move(crossed), std::move(location));
  }

 private:
  void AddEdge(const Feature& p, const Feature& q) {
    const auto& a = p.position[1] <= q.position[1] ? p.position : q.position;
    const auto& b = p.position[1] <= q.position[1] ? q.position : p.position;
    edges_.push_back({a[0], a[1], b[0], b[1], static_cast<std::uint32_t>(ids_.size())});
  }

  // Chooses the number of bands so that their lists are a few times as long as the edge list.
  void MakeBands() {
    double lo = 0, hi = 0, rise = 0;
    for (const RisingEdge& e : edges_) {
      if (&e == &edges_.front()) lo = e.y0, hi = e.y1;
      lo = std::min(lo, e.y0), hi = std::max(hi, e.y1);
      rise += e.y1 - e.y0;
    }
    const double bands = 4 * static_cast<double>(edges_.size()) * ((hi - lo) / rise);
    const double most = 4 * static_cast<double>(edges_.size());
    bands_.resize(bands >= 1 && bands <= most ? static_cast<std::size_t>(bands) : 1);
    lowest_ = lo;
    scale_ = hi > lo ? static_cast<double>(bands_.size()) / (hi - lo) : 0;
    if (!std::isfinite(scale_)) scale_ = 0;
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      const std::size_t last = BandOf(edges_[e].y1);
      for (std::size_t b = BandOf(edges_[e].y0); b <= last; ++b) bands_[b].push_back(e);
    }
  }

  // Monotone in y even after rounding, so an edge is in the bands of all its points.
  std::size_t BandOf(double y) const {
    const double band = (y - lowest_) * scale_;
    if (!(band > 0)) return 0;
    return std::min(static_cast<std::size_t>(std::min(band, 1e15)), bands_.size() - 1);
  }

  // True if a ray from the point to the right crosses the edge. An edge includes its lower end
  // only.
  template <class K>
  void Cross(const RisingEdge& e, const typename K::Point_2& at,
             std::vector<std::uint32_t>& crossed, Location& location) const {
    if (at.y() < e.y0 || at.y() >= e.y1) return;
    if (at.x() > e.x0 && at.x() > e.x1) return;
    if (!(at.x() < e.x0 && at.x() < e.x1)) {
      const typename K::Point_2 p(e.x0, e.y0), q(e.x1, e.y1);
      const CGAL::Orientation side = CGAL::orientation(p, q, at);
      if (side == CGAL::COLLINEAR) location.on_edge = ids_[e.polygon];
      if (side != CGAL::LEFT_TURN) return;
    }
    crossed.push_back(e.polygon);
  }

  Location Finish(std::vector<std::uint32_t> crossed, Location location) const {
    std::sort(crossed.begin(), crossed.end());
    for (std::size_t i = 0; i < crossed.size();) {
      const std::size_t begin = i;
      while (i < crossed.size() && crossed[i] == crossed[begin]) ++i;
      if ((i - begin) % 2 == 1) location.inside.push_back(ids_[crossed[begin]]);
    }
    return location;
  }

  std::vector<FeatureId> ids_;  // ascending
  std::vector<RisingEdge> edges_;
  std::vector<std::vector<std::uint32_t>> bands_;
  double lowest_ = 0;
  double scale_ = 0;
};

// The rounded centroid, if it is still strictly inside. It is, except in triangles of the size of
// an ulp.
std::optional<Kernel::Point_2> RoundedCentroid(const Kernel::Point_2 (&corner)[3]) {
  const Kernel::Point_2 at((corner[0].x() + corner[1].x() + corner[2].x()) / 3,
                           (corner[0].y() + corner[1].y() + corner[2].y()) / 3);
  const CGAL::Orientation way = CGAL::orientation(corner[0], corner[1], corner[2]);
  for (std::size_t k = 0; k < 3; ++k) {
    if (CGAL::orientation(corner[k], corner[(k + 1) % 3], at) != way) return std::nullopt;
  }
  return at;
}

ExactKernel::Point_2 Centroid(const Kernel::Point_2 (&corner)[3]) {
  CGAL::Exact_rational x = 0, y = 0;
  for (const auto& c : corner) x += c.x(), y += c.y();
  return {x / 3, y / 3};
}

std::string NameOfRegion(const std::vector<FeatureId>& polygons) {
  if (polygons.empty()) return "no polygon";
  return Concat(polygons.size() == 1 ? "polygon " : "polygons ", io::FormatPolygons(polygons));
}

}  // namespace

VerifyCheck CheckRegions(const io::IndexedMesh& mesh, const std::vector<Feature>& features) {
  Findings findings("regions");
  const PolygonIndex polygons(features, findings);
  const std::vector<FeatureId> none;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Kernel::Point_2 corner[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& v = mesh.vertices[mesh.triangles[t][k]];
      corner[k] = {v.x, v.y};
    }
    // It has no inside, and is reported elsewhere.
    if (CGAL::collinear(corner[0], corner[1], corner[2])) continue;
    const std::optional<Kernel::Point_2> at = RoundedCentroid(corner);
    const Location found = at ? polygons.Locate(*at) : polygons.Locate(Centroid(corner));
    if (found.on_edge != kNoFeature) {
      findings.Add(Concat(TriangleName(t), " is cut by an edge of polygon ", found.on_edge));
      continue;
    }
    const std::uint32_t number = mesh.regions.Of(t);
    const std::vector<FeatureId>& said = number == 0 ? none : mesh.regions.polygons[number - 1];
    if (said == found.inside) continue;
    findings.Add(Concat(TriangleName(t), " is in ", NameOfRegion(found.inside), "; the mesh says ",
                        NameOfRegion(said)));
  }
  return findings.Take();
}

}  // namespace dynmesh::cli
