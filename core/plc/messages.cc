#include "core/plc/messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/base/rings.h"
#include "core/base/size_shapes.h"
#include "core/geometry/constructions.h"
#include "core/plc/facet_rules.h"
#include "core/plc/least_vertices.h"
#include "core/plc/size_rules.h"
#include "core/plc/text.h"
#include "core/plc/validation_terms.h"
#include "dynmesh/error.h"

namespace dynmesh::plc {
namespace {

using geometry::Cross;
using geometry::Difference;
using geometry::Dot;
using geometry::Point;
using geometry::Vector3;
using plc::Text;

// The most features that an error names; enough for a client to act on.
constexpr std::size_t kMostNamed = 16;
// Targets of sizing features, in units of the least distance between features.
constexpr double kLeastTargetLimits = 64;

template <int D>
std::string Text(const PointFeature<D>& f) {
  return absl::StrCat("point ", f.id, " ", Text(f.p));
}

template <int D>
std::string Text(const SegmentFeature<D>& f) {
  return absl::StrCat(f.IsOfPolygon() ? "the edge of polygon " : "segment ", f.id, " from point ",
                      f.p_id, " ", Text(f.p), " to point ", f.q_id, " ", Text(f.q));
}

std::string Text(const Facet& f) { return absl::StrCat("polygon ", f.id()); }

template <int D>
std::string Text(const AnyFeature<D>& f) {
  return std::visit([](const auto& x) { return Text(x); }, f);
}

template <int D>
FeatureId IdOf(const AnyFeature<D>& f) {
  if (const Facet* facet = std::get_if<Facet>(&f)) return facet->id();
  if (const auto* point = std::get_if<PointFeature<D>>(&f)) return point->id;
  return std::get<SegmentFeature<D>>(f).id;
}

absl::Status Error(absl::StatusCode code, const char* reason, std::vector<FeatureId> features,
                   EditIndex edit, std::string message) {
  ErrorDetail detail{reason, std::move(features), std::nullopt};
  if (edit != kUntouched) detail.edit = static_cast<std::size_t>(edit);
  return MakeError(code, std::move(message), std::move(detail));
}

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
  double angle = 0;
  if constexpr (D == 3) {
    const auto* f = std::get_if<Facet>(&a);
    const auto* g = std::get_if<Facet>(&b);
    if (f != nullptr && g != nullptr) {
      const double lean = LeastLean(*f, *g);
      if (lean < 180 && !(LeastAngle(*f, *g) < kLeastFacetAngle)) {
        return absl::StrFormat(
            "%.6g degrees, between an edge of one and the inside of the other, beside a common "
            "edge; where polygons meet at less than 90 degrees, no edge may be nearer to the other "
            "polygon's inside than that one's edges are: move corners, or remove one of them",
            lean);
      }
    }
    angle = f != nullptr && g != nullptr ? LeastAngle(*f, *g)
            : f != nullptr               ? LeastAngle(*t, *f)
                                         : LeastAngle(*s, *g);
  }
  return absl::StrFormat(
      "%.6g degrees; at least %g are needed: move corners, or remove one of them", angle,
      kLeastFacetAngle);
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
      return {
          reason::kPointOnSegment,
          absl::StrCat(pair, " touch: the point lies in the inside of the segment; replace the ",
                       "segment by two that end at the point")};
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

absl::Status CheckRings(FeatureId id, const Rings& rings, EditIndex edit) {
  const auto refuse = [&](std::vector<FeatureId> features, const std::string& what) {
    features.insert(features.begin(), id);
    return Error(absl::StatusCode::kInvalidArgument, reason::kBadPolygon, std::move(features), edit,
                 absl::StrCat("polygon ", id, " ", what));
  };
  if (!Counts(ValidationTerm::kRingsAreSimple)) return absl::OkStatus();
  if (rings.empty()) return refuse({}, "has no ring; give it at least one");
  std::vector<EdgeKey> edges;
  for (const std::vector<FeatureId>& ring : rings) {
    if (ring.size() < 3) {
      return refuse({}, absl::StrCat("has a ring of ", ring.size(),
                                     " points; a ring has at least 3, the first not repeated"));
    }
    std::vector<FeatureId> points = ring;
    std::sort(points.begin(), points.end());
    const auto twice = std::adjacent_find(points.begin(), points.end());
    if (twice != points.end()) {
      return refuse({*twice}, absl::StrCat("has a ring that visits point ", *twice,
                                           " twice; make it two rings that touch there"));
    }
  }
  ForEachEdgeOf(rings, [&](FeatureId p, FeatureId q) { edges.push_back(KeyOf(p, q)); });
  std::sort(edges.begin(), edges.end());
  const auto twice = std::adjacent_find(edges.begin(), edges.end());
  if (twice == edges.end()) return absl::OkStatus();
  return refuse({twice->first, twice->second},
                absl::StrCat("has the edge between points ", twice->first, " and ", twice->second,
                             " twice; leave both out"));
}

absl::Status CheckQuality(FeatureId id, const MeshOptions& options, EditIndex edit) {
  if (options.dimension == 2 || options.quality >= kMinPolygonQuality3D) return absl::OkStatus();
  if (!Counts(ValidationTerm::kQualityAllowsPolygons)) return absl::OkStatus();
  return Error(
      absl::StatusCode::kFailedPrecondition, reason::kQualityTooLow, {id}, edit,
      absl::StrCat("polygon ", id, " is in a 3D mesh of quality (rho) ", Shortest(options.quality),
                   ", which has none below ", Shortest(kMinPolygonQuality3D),
                   ": refinement beside them might not ", "end; make the mesh with ",
                   Shortest(kMinPolygonQuality3D), " or more, or leave polygons out"));
}

absl::Status CheckFacet(const Facet& facet, double limit, EditIndex edit) {
  if (Counts(ValidationTerm::kHasArea) && !(facet.area() > limit * facet.Extent())) {
    return Error(absl::StatusCode::kInvalidArgument, reason::kBadPolygon, {facet.id()}, edit,
                 absl::StrCat("polygon ", facet.id(), " has no area; move its corners apart"));
  }
  const double tolerance = PlanarityTolerance(facet.Extent(), limit);
  if (facet.deviation() <= tolerance) return absl::OkStatus();
  if (!Counts(ValidationTerm::kIsPlanar)) return absl::OkStatus();
  // The plane goes through a corner that may be the one to blame. The median of the distances shows
  // where most corners are.
  std::vector<double> distances;
  for (const Facet::Corner& c : facet.corners()) {
    distances.push_back(facet.plane().Height(facet.PositionOf(c)));
  }
  std::vector<double> sorted = distances;
  std::sort(sorted.begin(), sorted.end());
  const double middle = sorted[sorted.size() / 2];
  std::size_t at = 0;
  for (std::size_t i = 1; i < distances.size(); ++i) {
    if (std::abs(distances[i] - middle) > std::abs(distances[at] - middle)) at = i;
  }
  const Facet::Corner& worst = facet.corners()[at];
  return Error(absl::StatusCode::kFailedPrecondition, reason::kNonPlanar, {facet.id(), worst.id},
               edit,
               absl::StrCat("polygon ", facet.id(), " is not flat: point ", worst.id, " ",
                            Text(facet.PositionOf(worst)), " is ",
                            Shortest(std::abs(distances[at] - middle)),
                            " off the plane of the others, where ", Shortest(tolerance),
                            " are allowed; move it there, or cut the polygon into triangles"));
}

absl::Status SizeOfQuadtreeError(FeatureId id, EditIndex edit) {
  return Error(absl::StatusCode::kInvalidArgument, reason::kBadSize, {id}, edit,
               absl::StrCat("feature ", id,
                            " is a sizing feature, which only a mesh of kind "
                            "delaunay has; leave it out, or add points where the quadtree must be "
                            "finer"));
}

template <int D>
absl::Status CheckSize(const SizeFeature<D>& size, const Box& box, double limit, EditIndex edit) {
  const Sizing& s = size.sizing;
  const auto refuse = [&](const char* reason, const std::string& what) {
    return Error(
        absl::StatusCode::kInvalidArgument, reason, {size.id}, edit,
        absl::StrCat("sizing feature ", size.id, " at ",
                     Text(s.path.empty() ? size.at : CornerOf<D>(s.path.front())), " ", what));
  };
  const SizeRules<D>* const rules = FindSizeRules<D>(s.shape);
  if (const SizeShapeUse* const use = FindUse(s.shape); use != nullptr && use->rings) {
    if (rules == nullptr) {
      return refuse(reason::kBadSize,
                    absl::StrCat("is a sizing polygon, which has no inside in 3D; give ",
                                 NamesOfSizeShapes("a ", D)));
    }
    if (absl::Status status = CheckRings(size.id, size.rings, edit); !status.ok()) return status;
  }
  bool finite = std::isfinite(s.target) && std::isfinite(s.radius);
  for (int i = 0; i < D; ++i) {
    finite = finite && std::isfinite(size.at[i]) && std::isfinite(s.hi[i]);
    for (const auto& vertex : s.path) finite = finite && std::isfinite(vertex[i]);
  }
  if (!finite) return refuse(reason::kNotFinite, "is not finite; give finite numbers");
  if (rules == nullptr) {
    return refuse(reason::kBadSize, absl::StrCat("is of unknown shape ", static_cast<int>(s.shape),
                                                 "; give ", NamesOfSizeShapes("a ", D)));
  }
  if (const auto fault = rules->FaultOf(size, box);
      fault.has_value() && Counts(ValidationTerm::kSizesAreSound)) {
    return refuse(fault->reason, fault->what);
  }
  const double least = kLeastTargetLimits * limit;
  if (Counts(ValidationTerm::kTargetsAreKept) && !(s.target >= least)) {
    return refuse(reason::kBadSize,
                  absl::StrCat("has target length ", Shortest(s.target), "; at least ",
                               Shortest(least), " can be kept in this mesh"));
  }
  return absl::OkStatus();
}

template <int D>
absl::Status CheckPosition(const PointFeature<D>& point, const Box& box, EditIndex edit) {
  const auto refuse = [&](const char* reason, const std::string& what) {
    return Error(absl::StatusCode::kInvalidArgument, reason, {point.id}, edit,
                 absl::StrCat(Text(point), " ", what));
  };
  for (int i = 0; i < D; ++i) {
    if (Counts(ValidationTerm::kIsFinite) && !std::isfinite(point.p[i])) {
      return refuse(reason::kNotFinite, "is not finite; give finite coordinates");
    }
  }
  for (int i = 0; i < D; ++i) {
    const double x = point.p[i];
    if (Counts(ValidationTerm::kIsInBox) && (x < box.lo[i] || x > box.hi[i])) {
      return refuse(reason::kOutsideBox,
                    absl::StrCat("is outside the mesh's box from ", Text(CornerOf<D>(box.lo)),
                                 " to ", Text(CornerOf<D>(box.hi)),
                                 "; move it inside, or create a mesh with a larger box"));
    }
  }
  for (int i = 0; i < D; ++i) {
    const double x = point.p[i];
    if (x != 0 && std::abs(x) < kMinCoordinate) {
      return refuse(reason::kTooClose,
                    "has a coordinate nearer to 0 than 2^-200, too small to compute with; make "
                    "it 0");
    }
  }
  return absl::OkStatus();
}

absl::Status DegenerateSegmentError(FeatureId segment, FeatureId end, EditIndex edit) {
  return Error(
      absl::StatusCode::kInvalidArgument, reason::kDegenerateSegment, {segment, end}, edit,
      absl::StrCat("segment ", segment, " has point ", end, " at both ends; give it two points"));
}

absl::Status UnknownEndError(FeatureId feature, std::span<const FeatureId> missing,
                             EditIndex edit) {
  missing = missing.first(std::min(missing.size(), kMostNamed));
  std::vector<FeatureId> features = {feature};
  features.insert(features.end(), missing.begin(), missing.end());
  return Error(absl::StatusCode::kFailedPrecondition, reason::kUnknownEnd, std::move(features),
               edit,
               absl::StrCat("feature ", feature, " needs point ", absl::StrJoin(missing, " and "),
                            ", but there is no such point; add it in the same batch"));
}

absl::Status PointInUseError(FeatureId id, std::span<const FeatureId> users, EditIndex edit) {
  const std::span<const FeatureId> named = users.first(std::min(users.size(), kMostNamed));
  std::vector<FeatureId> features = {id};
  features.insert(features.end(), named.begin(), named.end());
  return Error(absl::StatusCode::kFailedPrecondition, reason::kPointInUse, std::move(features),
               edit,
               absl::StrCat("point ", id, " is used by ", users.size(), " feature(s): remove ",
                            absl::StrJoin(named, ", "), named.size() < users.size() ? ", ..." : "",
                            " first or in the same batch"));
}

namespace {

// "takes at least 2e+10 vertices, and this mesh ..."
std::string DemandText(double vertices, double all, const MeshOptions& options) {
  const std::string others =
      all > vertices ? absl::StrFormat(", with others of this batch %.2g", all) : "";
  return absl::StrFormat("takes at least %.2g vertices%s, and this mesh may have max_vertices = %d",
                         vertices, others, options.limits.max_vertices);
}

// Meshes have more vertices than these lower bounds: about twice as many in 2D, five times in 3D.
template <int D>
std::string BetterTarget(const SizeFeature<D>& size, double vertices, double all,
                         const MeshOptions& options) {
  const double share =
      (D == 2 ? 0.4 : 0.2) * static_cast<double>(options.limits.max_vertices) * vertices / all;
  return absl::StrFormat("%.2g", 1.05 * TargetFor(size, DomainBox(options), share));
}

}  // namespace

template <int D>
absl::Status SizeDemandError(const SizeFeature<D>& size, double vertices, double all,
                             const MeshOptions& options, EditIndex edit) {
  return Error(
      absl::StatusCode::kResourceExhausted, reason::kVertexLimit, {size.id}, edit,
      absl::StrCat("sizing feature ", size.id, " with target length ", Shortest(size.sizing.target),
                   " ", DemandText(vertices, all, options), "; give it a target of about ",
                   BetterTarget(size, vertices, all, options),
                   " or more, or a smaller region, or create the mesh with a higher limit"));
}

template <int D>
absl::Status GapDemandError(const AnyFeature<D>& offender, const AnyFeature<D>& other,
                            double distance, double vertices, double all,
                            const MeshOptions& options, EditIndex edit) {
  return Error(absl::StatusCode::kResourceExhausted, reason::kVertexLimit,
               {IdOf<D>(offender), IdOf<D>(other)}, edit,
               absl::StrCat(Text<D>(offender), " and ", Text<D>(other), " are ",
                            absl::StrFormat("%.2g", distance), " apart: what is between them ",
                            DemandText(vertices, all, options),
                            "; move them apart or make them one, or create the mesh with a higher "
                            "limit"));
}

absl::Status CheckMaxEdge(const MeshOptions& options) {
  if (!(options.max_edge > 0)) return absl::OkStatus();
  const auto check = [&](const auto& region) {
    const double vertices = LeastVerticesIn(region, DomainBox(options));
    if (vertices <= static_cast<double>(options.limits.max_vertices)) return absl::OkStatus();
    return Error(absl::StatusCode::kResourceExhausted, reason::kVertexLimit, {}, kUntouched,
                 absl::StrCat("max_edge = ", Shortest(options.max_edge), " ",
                              DemandText(vertices, vertices, options), "; make it about ",
                              BetterTarget(region, vertices, vertices, options),
                              " or more, or the limit higher"));
  };
  return options.dimension == 2 ? check(SizeOfMaxEdge<2>(options))
                                : check(SizeOfMaxEdge<3>(options));
}

absl::Status InterruptedError() {
  return MakeError(absl::StatusCode::kCancelled,
                   "the batch was cancelled; the mesh is as it was before",
                   {reason::kCancelled, {}, {}});
}

template absl::Status ConflictError<2>(Conflict, const AnyFeature<2>&, const AnyFeature<2>&, double,
                                       EditIndex);
template absl::Status ConflictError<3>(Conflict, const AnyFeature<3>&, const AnyFeature<3>&, double,
                                       EditIndex);
template absl::Status SizeDemandError(const SizeFeature<2>&, double, double, const MeshOptions&,
                                      EditIndex);
template absl::Status SizeDemandError(const SizeFeature<3>&, double, double, const MeshOptions&,
                                      EditIndex);
template absl::Status GapDemandError<2>(const AnyFeature<2>&, const AnyFeature<2>&, double, double,
                                        double, const MeshOptions&, EditIndex);
template absl::Status GapDemandError<3>(const AnyFeature<3>&, const AnyFeature<3>&, double, double,
                                        double, const MeshOptions&, EditIndex);
template absl::Status CheckSize(const SizeFeature<2>&, const Box&, double, EditIndex);
template absl::Status CheckSize(const SizeFeature<3>&, const Box&, double, EditIndex);
template absl::Status CheckPosition(const PointFeature<2>&, const Box&, EditIndex);
template absl::Status CheckPosition(const PointFeature<3>&, const Box&, EditIndex);

}  // namespace dynmesh::plc
