#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/geometry/constructions.h"
#include "core/geometry/segment_distance.h"
#include "core/plc/facet_rules.h"
#include "core/plc/message_parts.h"
#include "core/plc/messages.h"
#include "core/plc/text.h"
#include "dynmesh/error.h"

namespace dynmesh::plc {
namespace {

using geometry::Cross;
using geometry::Difference;
using geometry::Dot;
using geometry::Point;
using geometry::Vector3;

// The intersection of two segments: rounded, on the first. They are neither parallel nor apart.
Point<2> CrossingOf(const SegmentFeature<2>& s, const SegmentFeature<2>& t) {
  const double before = Cross(t.p, t.q, s.p), after = Cross(t.p, t.q, s.q);
  const double along = before / (before - after);
  return {{s.p[0] + along * (s.q[0] - s.p[0]), s.p[1] + along * (s.q[1] - s.p[1])}};
}

// The 3D segments intersect in one plane. The two normals of t with the ends of s both lie along
// that of the plane, in opposite directions.
Point<3> CrossingOf(const SegmentFeature<3>& s, const SegmentFeature<3>& t) {
  const Vector3 v = Difference(t.q.c, t.p.c);
  const Vector3 before = Cross(v, Difference(s.p.c, t.p.c));
  const Vector3 after = Cross(v, Difference(s.q.c, t.p.c));
  const Vector3 both = Difference(before, after);
  const double along = std::clamp(Dot(before, both) / Dot(both, both), 0.0, 1.0);
  Point<3> p;
  for (int i = 0; i < 3; ++i) p[i] = s.p[i] + along * (s.q[i] - s.p[i]);
  return p;
}

// The intersection of a segment with a facet's plane; none if it lies in the plane or does not
// reach it.
std::optional<Point<3>> PassageOf(const SegmentFeature<3>& s, const Facet& facet) {
  const double before = facet.plane().Height(s.p), after = facet.plane().Height(s.q);
  if (!(before * after < 0)) return std::nullopt;
  const double along = before / (before - after);
  Point<3> p;
  for (int i = 0; i < 3; ++i) p[i] = s.p[i] + along * (s.q[i] - s.p[i]);
  return p;
}

// The position of a conflict, if the features' own positions do not show it.
template <int D>
std::optional<Point<D>> PositionOf(Conflict conflict, const AnyFeature<D>& a,
                                   const AnyFeature<D>& b) {
  const auto* s = std::get_if<SegmentFeature<D>>(&a);
  const auto* t = std::get_if<SegmentFeature<D>>(&b);
  if (conflict == Conflict::kSegmentsCross) return CrossingOf(*s, *t);
  if constexpr (D == 3) {
    if (conflict == Conflict::kSegmentMeetsPolygon) {
      const Facet& facet = std::get<Facet>(s == nullptr ? a : b);
      return PassageOf(s == nullptr ? *t : *s, facet);
    }
  }
  return std::nullopt;
}

// The angle between two segments that share an end, for messages.
template <int D>
std::string AngleText(const SegmentFeature<D>& s, const SegmentFeature<D>& t) {
  const bool s_from_p = s.p_id == t.p_id || s.p_id == t.q_id;
  const FeatureId apex = s_from_p ? s.p_id : s.q_id;
  const Point<D>& at = s_from_p ? s.p : s.q;
  const Point<D>& a = s_from_p ? s.q : s.p;
  const Point<D>& b = t.p_id == apex ? t.q : t.p;
  double dot = 0, cross2 = 0;
  for (int i = 0; i < D; ++i) {
    dot += (a[i] - at[i]) * (b[i] - at[i]);
    for (int j = i + 1; j < D; ++j) {
      const double minor = (a[i] - at[i]) * (b[j] - at[j]) - (a[j] - at[j]) * (b[i] - at[i]);
      cross2 += minor * minor;
    }
  }
  const double angle = std::atan2(std::sqrt(cross2), dot);
  return absl::StrFormat("%.6g degrees at point %d %s", angle * 180 / std::numbers::pi, apex,
                         Text(at));
}

// The angle between two features, and the least allowed one.
template <int D>
std::string SmallAngleText(const AnyFeature<D>& a, const AnyFeature<D>& b) {
  const auto* s = std::get_if<SegmentFeature<D>>(&a);
  const auto* t = std::get_if<SegmentFeature<D>>(&b);
  if (s != nullptr && t != nullptr) {
    return absl::StrCat(AngleText<D>(*s, *t),
                        "; at least 0.001 are needed: move an end, or remove one of them");
  }
  SharpContact contact = {};
  if constexpr (D == 3) {
    const auto* f = std::get_if<Facet>(&a);
    const auto* g = std::get_if<Facet>(&b);
    contact = f != nullptr && g != nullptr ? LeastAngle(*f, *g)
              : f != nullptr               ? LeastAngle(*t, *f)
                                           : LeastAngle(*s, *g);
  }
  return absl::StrFormat(
      "%.6g degrees; at least %g are needed: move corners, or remove one of them", contact.angle,
      contact.allowed);
}

// A polygon's edge cannot be replaced, but the polygon can.
template <int D>
std::string CureOfPointOnSegment(const AnyFeature<D>& a, const AnyFeature<D>& b) {
  const bool is_first = std::holds_alternative<SegmentFeature<D>>(a);
  const auto& segment = std::get<SegmentFeature<D>>(is_first ? a : b);
  if (!segment.IsOfPolygon()) {
    return "segment; replace the segment by two that end at the point";
  }
  return absl::StrCat("edge; give polygon ", segment.id, " a ring with point ",
                      IdOf<D>(is_first ? b : a), " as a corner between points ", segment.p_id,
                      " and ", segment.q_id);
}

// The greatest number of three digits that is below x.
std::string Below(double x) {
  const double unit = std::pow(10.0, std::floor(std::log10(x)) - 2);
  return absl::StrFormat("%.3g", std::max(1.0, std::floor(x * 0.999 / unit)) * unit);
}

// What is in the way of an unsplit segment, and what would do.
template <int D>
std::string EncroachedText(const AnyFeature<D>& a, const AnyFeature<D>& b) {
  if constexpr (D == 2) {
    const auto* s = std::get_if<SegmentFeature<D>>(&a);
    const auto* t = std::get_if<SegmentFeature<D>>(&b);
    const bool is_a = s != nullptr && s->unsplit && !(t != nullptr && t->unsplit);
    const SegmentFeature<D>& whole = is_a ? *s : *t;
    const AnyFeature<D>& other = is_a ? b : a;
    const std::string must_not = absl::StrCat("; ", Text(whole), " is unsplit, and no vertex may ");
    if (const auto* p = std::get_if<PointFeature<D>>(&other)) {
      const double away = std::sqrt(geometry::SquaredDistance(p->p, whole.p, whole.q));
      return absl::StrCat(Text(*p), " lies in the circle over ", ShortText(whole), must_not,
                          "lie there: give it points at a spacing of at most ", Below(2 * away),
                          " near point ", p->id, ", or leave it unmarked");
    }
    const auto& f = std::get<SegmentFeature<D>>(other);
    const bool meet = f.p_id == whole.p_id || f.p_id == whole.q_id || f.q_id == whole.p_id ||
                      f.q_id == whole.q_id;
    if (meet) {
      return absl::StrCat(Text(f), " leaves ", ShortText(whole), " in an angle of ",
                          AngleText<D>(f, whole), must_not, "come nearer than 90 degrees: mark ",
                          ShortText(f),
                          " unsplit, too, with points at the same spacing, or turn it");
    }
    const double away = std::sqrt(geometry::SquaredDistance(f.p, f.q, whole.p, whole.q));
    return absl::StrCat(Text(f), " meets the circle over ", ShortText(whole), must_not,
                        "lie there: give it points at a spacing of at most ", Below(2 * away),
                        " near ", ShortText(f), ", or mark that unsplit, too");
  }
  return "";
}

struct Verdict {
  const char* reason;
  std::string message;
};

template <int D>
Verdict Explain(Conflict conflict, const AnyFeature<D>& a, const AnyFeature<D>& b, double limit) {
  const FeatureId b_id = IdOf<D>(b);
  const std::optional<Point<D>> position = PositionOf<D>(conflict, a, b);
  const std::string at = position.has_value() ? " at " + Text(*position) : "";
  const std::string pair = absl::StrCat(Text<D>(a), " and ", Text<D>(b));
  switch (conflict) {
    case Conflict::kDuplicatePoint:
      return {reason::kDuplicatePoint,
              absl::StrCat(pair, " have the same coordinates; use point ", b_id,
                           " instead, or remove it in the same batch")};
    case Conflict::kDuplicateSegment:
      return {reason::kDuplicateSegment,
              absl::StrCat(pair, " join the same points; leave one of them out")};
    case Conflict::kSegmentsOverlap:
      return {reason::kSegmentsOverlap,
              absl::StrCat(pair, " overlap; end them where they part and add what they share as a ",
                           "segment of its own, once")};
    case Conflict::kPointOnSegment:
      return {reason::kPointOnSegment,
              absl::StrCat(pair, " touch: the point lies in the inside of the ",
                           CureOfPointOnSegment<D>(a, b))};
    case Conflict::kSegmentsCross:
      return {reason::kSegmentsCross,
              absl::StrCat(pair, " cross", at, "; add a point there and split both, or remove ",
                           "feature ", b_id, " in the same batch")};
    case Conflict::kDuplicatePolygon:
      return {reason::kDuplicatePolygon,
              absl::StrCat(pair, " have the same edges; leave one of them out")};
    case Conflict::kPointOnPolygon:
      return {reason::kPointOnPolygon,
              absl::StrCat(pair, " touch: the point lies in the inside of the polygon; make it a ",
                           "corner: cut the polygon into some that meet there, or move it away")};
    case Conflict::kSegmentMeetsPolygon:
      return {reason::kSegmentMeetsPolygon,
              absl::StrCat(
                  pair, " meet in the inside of the polygon", at, "; cut the polygon so that the ",
                  "segment, or the point where it passes, is on its rings, or remove one")};
    case Conflict::kPolygonsMeet:
      return {
          reason::kPolygonsMeet,
          absl::StrCat(pair, " have more in common than corners and edges; cut them where they ",
                       "meet, with what they share as a polygon of its own, once")};
    case Conflict::kSmallAngle:
      return {reason::kSmallAngle,
              absl::StrCat(pair, " meet in an angle of ", SmallAngleText<D>(a, b))};
    case Conflict::kEncroached:
      return {reason::kEncroached, EncroachedText<D>(a, b)};
    default:
      return {reason::kTooClose,
              absl::StrCat(pair, " are nearer than ", Shortest(limit),
                           ", the least distance in this mesh; move them apart or make them one")};
  }
}

}  // namespace

template <int D>
absl::Status ConflictError(Conflict conflict, const AnyFeature<D>& offender,
                           const AnyFeature<D>& other, double limit, EditIndex edit) {
  Verdict verdict = Explain<D>(conflict, offender, other, limit);
  return Error(absl::StatusCode::kFailedPrecondition, verdict.reason,
               {IdOf<D>(offender), IdOf<D>(other)}, edit, std::move(verdict.message));
}

template absl::Status ConflictError<2>(Conflict, const AnyFeature<2>&, const AnyFeature<2>&, double,
                                       EditIndex);
template absl::Status ConflictError<3>(Conflict, const AnyFeature<3>&, const AnyFeature<3>&, double,
                                       EditIndex);

}  // namespace dynmesh::plc
