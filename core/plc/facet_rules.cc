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
// Angles are compared by sin^2, which tells small ones apart where cosines are 1 up to rounding; 1
// stands for 90 degrees and more. At corners the least is that of segments.
constexpr double kLeastSine2AtEdges = 7.615433561505986e-07 * kNarrower;  // of 0.05 degrees
// Facets at an angle below 1e-6 overlap.
constexpr double kSameSide2 = 1e-12;

double Degrees(double sine2) {
  return sine2 < 1 ? std::asin(std::sqrt(sine2)) * 180 / std::numbers::pi : 180;
}

// Of the angle between `d`, from the corner `point` of f over its inside, and f; 1 if it leads
// elsewhere.
double Sine2Over(const Facet& f, FeatureId point, const Vector3& d) {
  if (!f.OpensTo(point, d)) return 1;
  const double up = Dot(d, f.plane().normal);
  return std::min(up * up / Dot(d, d), 1.0);
}

// Of the angle between unit vectors.
double Sine2Between(const Vector3& u, const Vector3& w) {
  if (Dot(u, w) <= 0) return 1;
  const Vector3 chord = Difference(u, w);  // 2 sin(angle / 2)
  const double chord2 = Dot(chord, chord);
  return chord2 * (1 - chord2 / 4);
}

// The common parts of two facets.
struct CommonCorners {
  std::size_t edges = 0;
  double sine2 = 1;                                 // of the least angle at common edges
  std::vector<FeatureId> corners;                   // ascending, no duplicates
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
      if (!IsOn(ValidationTerm::kAngleOfFacetsAtEdges)) continue;
      common.sine2 = std::min(common.sine2, Sine2Between(f.InwardOf(c), g.InwardOf(edge)));
    }
  }
  std::sort(common.ways.begin(), common.ways.end());
  return common;
}

// sin^2 of the least angle of edges of g over f at common corners. Beside common edges, the angle
// at these is decisive. So only edges that lead away from all common edges count, over another part
// of f.
double Sine2AtCorners(const Facet& f, const Facet& g, const CommonCorners& common) {
  double sine2 = 1;
  if (!IsOn(ValidationTerm::kAngleOfFacetsAtCorners)) return sine2;
  for (const FeatureId point : common.corners) {
    const auto [begin, end] =
        std::equal_range(common.ways.begin(), common.ways.end(), std::pair(point, Vector3{}),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const Facet::Corner& c : g.At(point)) {
      for (const bool next : {false, true}) {
        const Vector3 d = Difference(g.PositionOf(g.Beside(c, next)).c, g.PositionOf(c).c);
        const bool leads_away =
            std::all_of(begin, end, [&](const auto& way) { return Dot(way.second, d) < 0; });
        if (leads_away) sine2 = std::min(sine2, Sine2Over(f, point, d));
      }
    }
  }
  return sine2;
}

double LeastSine2AtCorners(const Facet& f, const Facet& g, const CommonCorners& common) {
  return std::min(Sine2AtCorners(f, g, common), Sine2AtCorners(g, f, common));
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
  if (!IsOn(ValidationTerm::kPointFarFromFacet)) return Conflict::kNone;
  const double deviation = f.deviation();
  const double distance = std::fabs(f.plane().Height(p.p));
  if (!(distance < deviation + limit) || f.HasCorner(p.id) || !f.Holds(p.p)) return Conflict::kNone;
  return distance <= deviation + limit * kOnShare ? Conflict::kPointOnPolygon : Conflict::kTooClose;
}

Conflict Between(const SegmentFeature<3>& s, const Facet& f, double limit) {
  const bool from_p = f.HasCorner(s.p_id), from_q = f.HasCorner(s.q_id);
  if (from_p && from_q) {
    if (f.HasEdge(s.p_id, s.q_id) || !f.Holds(Midpoint(s.p, s.q))) return Conflict::kNone;
    if (!IsOn(ValidationTerm::kSegmentNotInFacet)) return Conflict::kNone;
    return Conflict::kSegmentMeetsPolygon;
  }
  const double at_p = f.plane().Height(s.p), at_q = f.plane().Height(s.q);
  if (from_p || from_q) {
    if (s.IsOfPolygon()) return Conflict::kNone;  // its facets are checked instead
    if (!IsOn(ValidationTerm::kAngleOfSegmentAndFacet)) return Conflict::kNone;
    const Vector3 d = from_p ? Difference(s.q.c, s.p.c) : Difference(s.p.c, s.q.c);
    const double sine2 = Sine2Over(f, from_p ? s.p_id : s.q_id, d);
    if (sine2 >= kLeastSine2) return Conflict::kNone;
    const bool in_plane = std::fabs(from_p ? at_q : at_p) < f.deviation() + limit;
    return in_plane ? Conflict::kSegmentMeetsPolygon : Conflict::kSmallAngle;
  }
  if ((at_p > 0) == (at_q > 0)) return Conflict::kNone;
  if (!IsOn(ValidationTerm::kSegmentNotThroughFacet)) return Conflict::kNone;
  const double t = at_p / (at_p - at_q);
  Point3 x;
  for (int i = 0; i < 3; ++i) x[i] = s.p[i] + t * (s.q[i] - s.p[i]);
  return f.Holds(x) ? Conflict::kSegmentMeetsPolygon : Conflict::kNone;
}

Conflict Between(const Facet& f, const Facet& g, double limit) {
  if (f.corners().size() > g.corners().size()) return Between(g, f, limit);
  const CommonCorners common = FindCommon(f, g);
  if (common.corners.empty()) return Conflict::kNone;
  if (IsOn(ValidationTerm::kFacetsDiffer) && common.edges == f.corners().size() &&
      common.edges == g.corners().size()) {
    return Conflict::kDuplicatePolygon;
  }
  if ((IsOn(ValidationTerm::kFacetsDoNotOverlap) && common.sine2 < kSameSide2) ||
      (IsOn(ValidationTerm::kFacetsDoNotMeet) && MeetBetween(f, g, common.corners))) {
    return Conflict::kPolygonsMeet;
  }
  if (common.sine2 < kLeastSine2AtEdges || LeastSine2AtCorners(f, g, common) < kLeastSine2)
    return Conflict::kSmallAngle;
  return Conflict::kNone;
}

SharpContact LeastAngle(const SegmentFeature<3>& s, const Facet& f) {
  const bool from_p = f.HasCorner(s.p_id);
  const Vector3 d = from_p ? Difference(s.q.c, s.p.c) : Difference(s.p.c, s.q.c);
  return {Degrees(Sine2Over(f, from_p ? s.p_id : s.q_id, d)), kLeastAngleAtCorners};
}

SharpContact LeastAngle(const Facet& f, const Facet& g) {
  if (f.corners().size() > g.corners().size()) return LeastAngle(g, f);
  const CommonCorners common = FindCommon(f, g);
  if (common.sine2 < kLeastSine2AtEdges) return {Degrees(common.sine2), kLeastAngleAtEdges};
  return {Degrees(LeastSine2AtCorners(f, g, common)), kLeastAngleAtCorners};
}

}  // namespace dynmesh::plc
