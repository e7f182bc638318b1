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
// Compares angles by the sine of their difference to 90 degrees: sin(20 degrees), plus a millionth.
constexpr double kMostLack = 0.3420201433256687 * kWider;
// tan(60 degrees): between segments at 60 degrees or more there are no shells.
constexpr double kMostTangent = std::numbers::sqrt3;
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
struct Common {
  std::size_t edges = 0;
  double cosine = -1;              // the greatest cosine of the angles at common edges
  std::vector<FeatureId> corners;  // ascending, no duplicates
  std::vector<std::pair<FeatureId, Vector3>> ways;  // along common edges, from each end; by id
};

// REQUIRES: f has no more corners than g.
Common FindCommon(const Facet& f, const Facet& g) {
  Common common;
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
double CosineAtCorners(const Facet& f, const Facet& g, const Common& common) {
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

Vector3 UnitTo(const Facet& f, const Facet::Corner& from, const Facet::Corner& to) {
  Vector3 d = Difference(f.PositionOf(to).c, f.PositionOf(from).c);
  const double length = std::sqrt(Dot(d, d));
  for (double& x : d) x /= length;
  return d;
}

// Let b be the angle of f at corner `at` from its edge along the unit vector `along`, which is the
// one to the corner `beside`, over its inside, towards the unit vector `inward`. The tangent of
// b / 2, or of 60 degrees if that is less. Roots and fractions only: a verdict is the same on any
// machine, which trigonometric functions of a library do not promise.
double TangentOfHalf(const Facet& f, const Facet::Corner& at, FeatureId beside,
                     const Vector3& along, const Vector3& inward) {
  double tangent = kMostTangent;
  for (const Facet::Corner& visit : f.At(at.id)) {
    for (const bool next : {false, true}) {
      const Facet::Corner other = f.Beside(visit, next);
      if (other.id == beside) continue;
      const Vector3 d = UnitTo(f, visit, other);
      const double sine = Dot(d, inward), cosine = Dot(d, along);
      // Else the angle is 180 degrees or more.
      if (sine > 0 && 1 + cosine > 0) tangent = std::min(tangent, sine / (1 + cosine));
    }
  }
  return tangent;
}

// The greatest cosine of the angles between f and edges of g that lean over it; -1 if there are
// none.
double CosineOfLean(const Facet& f, const Facet& g) {
  double cosine = -1;
  if (!Counts(ValidationTerm::kEdgesDoNotLean)) return cosine;
  for (const Facet::Corner& at : f.corners()) {
    for (const bool forward : {false, true}) {
      const Facet::Corner beside = f.Beside(at, forward);
      if (!g.HasEdge(at.id, beside.id)) continue;
      const Vector3 along = UnitTo(f, at, beside), inward = f.InwardOf(forward ? at : beside);
      const double tangent = TangentOfHalf(f, at, beside.id, along, inward);
      for (const Facet::Corner& visit : g.At(at.id)) {
        for (const bool next : {false, true}) {
          const Facet::Corner other = g.Beside(visit, next);
          if (f.HasEdge(at.id, other.id)) continue;
          if (!geometry::IsSmallAngle(f.PositionOf(at), f.PositionOf(beside), g.PositionOf(other)))
            continue;
          const Vector3 edge = UnitTo(g, visit, other), off = Difference(edge, along);
          // 1 - cos(a) is half of the squared length of `off`.
          if (!(Dot(edge, inward) * tangent > 0.5 * Dot(off, off) / kWider)) continue;
          const double up = Dot(edge, f.plane().normal);
          cosine = std::max(cosine, std::sqrt(std::max(0.0, 1 - up * up)));
        }
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
    if (CosineOver(f, from_p ? s.p_id : s.q_id, d) <= kMostLack) return Conflict::kNone;
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
  const Common common = FindCommon(f, g);
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
  if (lack > kMostLack) return Conflict::kSmallAngle;
  const bool leans = common.edges > 0 && std::max(CosineOfLean(f, g), CosineOfLean(g, f)) > -1;
  return leans ? Conflict::kSmallAngle : Conflict::kNone;
}

double LeastAngle(const SegmentFeature<3>& s, const Facet& f) {
  const bool from_p = f.HasCorner(s.p_id);
  const Vector3 d = from_p ? Difference(s.q.c, s.p.c) : Difference(s.p.c, s.q.c);
  return Degrees(CosineOver(f, from_p ? s.p_id : s.q_id, d));
}

double LeastAngle(const Facet& f, const Facet& g) {
  if (f.corners().size() > g.corners().size()) return LeastAngle(g, f);
  const Common common = FindCommon(f, g);
  const double at_corners = std::max(CosineAtCorners(f, g, common), CosineAtCorners(g, f, common));
  return std::min(Degrees(common.cosine), Degrees(at_corners));
}

double LeastLean(const Facet& f, const Facet& g) {
  return Degrees(std::max(CosineOfLean(f, g), CosineOfLean(g, f)));
}

}  // namespace dynmesh::plc
