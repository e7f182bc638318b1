#include "core/plc/facet_rules.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "core/base/rounding.h"
#include "core/geometry/angles.h"
#include "core/geometry/circumball.h"
#include "core/geometry/constructions.h"
#include "core/plc/validation_terms.h"

namespace dynmesh::plc {
namespace {

using geometry::Difference;
using geometry::Dot;
using geometry::Midpoint;
using geometry::Point3;
using geometry::Vector3;

constexpr double kPlanarity = 1e-9;
constexpr double kOnShare = 1.0 / 64;
// cos(1 degree), plus a millionth.
constexpr double kMostCosine = 0.99984769515639124 * kWider;
// Facets at an angle below 1e-6 overlap.
constexpr double kSameSide = 1 - 5e-13;

double Degrees(double cosine) {
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

// The cosine of the angle between `d`, from the corner `point` of f over its inside, and f; 0 if it
// leads elsewhere.
double CosineOver(const Facet& f, FeatureId point, const Vector3& d) {
  if (!f.OpensTo(point, d)) return 0;
  const double up = Dot(d, f.plane().normal), length2 = Dot(d, d);
  return std::sqrt(std::max(0.0, 1 - up * up / length2));
}

// The common parts of two facets.
struct CommonCorners {
  std::size_t edges = 0;
  double cosine = -1;              // the greatest cosine of the angles at common edges
  std::vector<FeatureId> corners;  // ascending, no duplicates
  std::vector<std::pair<FeatureId, Vector3>> ways;  // along common edges, from each end; by id
};

// REQUIRES: f has no more corners than g.
CommonCorners FindCommon(const Facet& f, const Facet& g) {
  CommonCorners common;
  for (const Facet::Corner& c : f.corners()) {
    if (!g.HasCorner(c.id)) continue;
    if (common.corners.empty() || common.corners.back() != c.id) common.corners.push_back(c.id);
    const FeatureId next = f.Beside(c, true).id;
    for (const Facet::Corner& d : g.At(c.id)) {
      const Facet::Corner before = g.Beside(d, false);
      if (g.Beside(d, true).id != next && before.id != next) continue;
      ++common.edges;
      const Vector3 way = Difference(f.PositionOf(f.Beside(c, true)).c, f.PositionOf(c).c);
      common.ways.emplace_back(c.id, way);
      common.ways.emplace_back(next, Vector3{-way[0], -way[1], -way[2]});
      const Facet::Corner& edge = g.Beside(d, true).id == next ? d : before;
      if (!Counts(ValidationTerm::kAngleOfFacetsAtEdges)) continue;
      common.cosine = std::max(common.cosine, Dot(f.InwardOf(c), g.InwardOf(edge)));
    }
  }
  std::sort(common.ways.begin(), common.ways.end());
  return common;
}

// The greatest cosine of edges of g over f at common corners. Beside common edges, the angle at
// these is decisive. So only edges that lead away from all common edges count, over another part of
// f.
double CosineAtCorners(const Facet& f, const Facet& g, const CommonCorners& common) {
  if (!Counts(ValidationTerm::kAngleOfFacetsAtCorners)) return -1;
  double cosine = 0;
  for (const FeatureId point : common.corners) {
    const auto [begin, end] =
        std::equal_range(common.ways.begin(), common.ways.end(), std::pair(point, Vector3{}),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const Facet::Corner& c : g.At(point)) {
      for (const bool next : {false, true}) {
        const Vector3 d = Difference(g.PositionOf(g.Beside(c, next)).c, g.PositionOf(c).c);
        const bool leads_away =
            std::all_of(begin, end, [&](const auto& way) { return Dot(way.second, d) < 0; });
        if (leads_away) cosine = std::max(cosine, CosineOver(f, point, d));
      }
    }
  }
  return cosine;
}

// Do the insides meet along a line between two common corners? If the planes differ, all common
// corners are on their line of intersection.
bool MeetBetween(const Facet& f, const Facet& g, const std::vector<FeatureId>& corners) {
  std::vector<std::pair<Point3, FeatureId>> at;
  for (const FeatureId id : corners) at.emplace_back(f.PositionOf(f.At(id).front()), id);
  std::sort(at.begin(), at.end());
  for (std::size_t i = 0; i + 1 < at.size(); ++i) {
    const FeatureId p = at[i].second, q = at[i + 1].second;
    if (f.HasEdge(p, q) || g.HasEdge(p, q)) continue;
    const Point3 middle = Midpoint(at[i].first, at[i + 1].first);
    if (f.Holds(middle) && g.Holds(middle)) return true;
  }
  return false;
}

}  // namespace

double PlanarityTolerance(double extent, double limit) {
  return std::max(kPlanarity * extent, limit / 128);
}

Conflict Between(const PointFeature<3>& p, const Facet& f, double limit) {
  if (!Counts(ValidationTerm::kPointFarFromFacet)) return Conflict::kNone;
  const double deviation = f.deviation();
  const double distance = std::fabs(f.plane().Height(p.p));
  if (!(distance < deviation + limit) || f.HasCorner(p.id) || !f.Holds(p.p)) return Conflict::kNone;
  return distance <= deviation + limit * kOnShare ? Conflict::kPointOnPolygon : Conflict::kTooClose;
}

Conflict Between(const SegmentFeature<3>& s, const Facet& f, double limit) {
  const bool from_p = f.HasCorner(s.p_id), from_q = f.HasCorner(s.q_id);
  if (from_p && from_q) {
    if (f.HasEdge(s.p_id, s.q_id) || !f.Holds(Midpoint(s.p, s.q))) return Conflict::kNone;
    if (!Counts(ValidationTerm::kSegmentNotInFacet)) return Conflict::kNone;
    return Conflict::kSegmentMeetsPolygon;
  }
  const double at_p = f.plane().Height(s.p), at_q = f.plane().Height(s.q);
  if (from_p || from_q) {
    if (s.IsOfPolygon()) return Conflict::kNone;  // its facets are checked instead
    if (!Counts(ValidationTerm::kAngleOfSegmentAndFacet)) return Conflict::kNone;
    const Vector3 d = from_p ? Difference(s.q.c, s.p.c) : Difference(s.p.c, s.q.c);
    if (CosineOver(f, from_p ? s.p_id : s.q_id, d) <= kMostCosine) return Conflict::kNone;
    const bool in_plane = std::fabs(from_p ? at_q : at_p) < f.deviation() + limit;
    return in_plane ? Conflict::kSegmentMeetsPolygon : Conflict::kSmallAngle;
  }
  if ((at_p > 0) == (at_q > 0)) return Conflict::kNone;
  if (!Counts(ValidationTerm::kSegmentNotThroughFacet)) return Conflict::kNone;
  const double t = at_p / (at_p - at_q);
  Point3 x;
  for (int i = 0; i < 3; ++i) x[i] = s.p[i] + t * (s.q[i] - s.p[i]);
  return f.Holds(x) ? Conflict::kSegmentMeetsPolygon : Conflict::kNone;
}

Conflict Between(const Facet& f, const Facet& g, double limit) {
  if (f.corners().size() > g.corners().size()) return Between(g, f, limit);
  const CommonCorners common = FindCommon(f, g);
  if (common.corners.empty()) return Conflict::kNone;
  if (Counts(ValidationTerm::kFacetsDiffer) && common.edges == f.corners().size() &&
      common.edges == g.corners().size()) {
    return Conflict::kDuplicatePolygon;
  }
  if ((Counts(ValidationTerm::kFacetsDoNotOverlap) && common.cosine > kSameSide) ||
      (Counts(ValidationTerm::kFacetsDoNotMeet) && MeetBetween(f, g, common.corners))) {
    return Conflict::kPolygonsMeet;
  }
  const double lack =
      std::max({common.cosine, CosineAtCorners(f, g, common), CosineAtCorners(g, f, common)});
  if (lack > kMostCosine) return Conflict::kSmallAngle;
  return Conflict::kNone;
}

double LeastAngle(const SegmentFeature<3>& s, const Facet& f) {
  const bool from_p = f.HasCorner(s.p_id);
  const Vector3 d = from_p ? Difference(s.q.c, s.p.c) : Difference(s.p.c, s.q.c);
  return Degrees(CosineOver(f, from_p ? s.p_id : s.q_id, d));
}

double LeastAngle(const Facet& f, const Facet& g) {
  if (f.corners().size() > g.corners().size()) return LeastAngle(g, f);
  const CommonCorners common = FindCommon(f, g);
  const double at_corners = std::max(CosineAtCorners(f, g, common), CosineAtCorners(g, f, common));
  return std::min(Degrees(common.cosine), Degrees(at_corners));
}

}  // namespace dynmesh::plc
