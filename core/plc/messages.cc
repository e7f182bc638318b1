#include "core/plc/messages.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/base/rings.h"
#include "core/base/size_shapes.h"
#include "core/plc/facet_rules.h"
#include "core/plc/least_vertices.h"
#include "core/plc/message_parts.h"
#include "core/plc/size_rules.h"
#include "core/plc/text.h"
#include "core/plc/validation_terms.h"
#include "dynmesh/error.h"

namespace dynmesh::plc {
namespace {

using geometry::Point;

// The most features that an error names; enough for a client to act on.
constexpr std::size_t kMostNamed = 16;
// Targets of sizing features, in units of the least distance between features.
constexpr double kLeastTargetLimits = 64;

}  // namespace

absl::Status CheckRings(FeatureId id, const Rings& rings, EditIndex edit) {
  const auto refuse = [&](std::vector<FeatureId> features, const std::string& what) {
    features.insert(features.begin(), id);
    return Error(absl::StatusCode::kInvalidArgument, reason::kBadPolygon, std::move(features), edit,
                 absl::StrCat("polygon ", id, " ", what));
  };
  if (!IsOn(ValidationTerm::kRingsAreSimple)) return absl::OkStatus();
  if (rings.empty()) return refuse({}, "has no ring; give it at least one");
  std::vector<EdgeKey> edges;
  for (const std::vector<FeatureId>& ring : rings) {
    if (ring.size() < 3) {
      return refuse({}, absl::StrCat("has a ring of ", ring.size(),
                                     " points; a ring has at least 3, the first not repeated"));
    }
    if (ring.front() == ring.back()) {
      return refuse({ring.front()},
                    absl::StrCat("has a ring that begins and ends with point ", ring.front(),
                                 "; a ring closes itself: leave its last point out"));
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
  if (!IsOn(ValidationTerm::kQualityAllowsPolygons)) return absl::OkStatus();
  return Error(
      absl::StatusCode::kFailedPrecondition, reason::kQualityTooLow, {id}, edit,
      absl::StrCat("polygon ", id, " is in a 3D mesh of quality (rho) ", Shortest(options.quality),
                   ", which has none below ", Shortest(kMinPolygonQuality3D),
                   ": refinement beside them might not ", "end; make the mesh with ",
                   Shortest(kMinPolygonQuality3D), " or more, or leave polygons out"));
}

absl::Status CheckFacet(const Facet& facet, double limit, EditIndex edit) {
  if (IsOn(ValidationTerm::kHasArea) && !(facet.area() > limit * facet.Extent())) {
    return Error(absl::StatusCode::kInvalidArgument, reason::kBadPolygon, {facet.id()}, edit,
                 absl::StrCat("polygon ", facet.id(), " has no area; move its corners apart"));
  }
  const double tolerance = PlanarityTolerance(facet.Extent(), limit);
  if (facet.deviation() <= tolerance) return absl::OkStatus();
  if (!IsOn(ValidationTerm::kIsPlanar)) return absl::OkStatus();
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

absl::Status SizeUnusedError(FeatureId id, const MeshOptions& options, EditIndex edit) {
  const char* const what =
      options.kind == MeshKind::kQuadtree ? "the quadtree" : "the triangulation";
  return Error(absl::StatusCode::kInvalidArgument, reason::kBadSize, {id}, edit,
               absl::StrCat("feature ", id,
                            " is a sizing feature, which only a mesh of kind "
                            "delaunay has; leave it out, or add points where ",
                            what, " must be finer"));
}

template <int D>
absl::Status UnsplitError(const SegmentFeature<D>& segment, const MeshOptions& options,
                          EditIndex edit) {
  const char* const where = options.kind == MeshKind::kQuadtree ? "a quadtree, which splits nothing"
                            : options.kind == MeshKind::kTriangulation
                                ? "a triangulation, which splits nothing"
                            : D == 3 ? "a mesh of three dimensions"
                                     : "a mesh of criterion thesis";
  return Error(
      absl::StatusCode::kInvalidArgument, reason::kBadUnsplit, {segment.id}, edit,
      absl::StrCat("feature ", segment.id, " is marked unsplit in ", where,
                   ": only segments and polygons of planar meshes of criterion edge may be; "
                   "leave out the mark"));
}
template absl::Status UnsplitError(const SegmentFeature<2>&, const MeshOptions&, EditIndex);
template absl::Status UnsplitError(const SegmentFeature<3>&, const MeshOptions&, EditIndex);

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
      fault.has_value() && IsOn(ValidationTerm::kSizesAreSound)) {
    return refuse(fault->reason, fault->what);
  }
  const double least = kLeastTargetLimits * limit;
  if (IsOn(ValidationTerm::kTargetsAreKept) && !(s.target >= least)) {
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
    if (IsOn(ValidationTerm::kIsFinite) && !std::isfinite(point.p[i])) {
      return refuse(reason::kNotFinite, "is not finite; give finite coordinates");
    }
  }
  for (int i = 0; i < D; ++i) {
    const double x = point.p[i];
    if (IsOn(ValidationTerm::kIsInBox) && (x < box.lo[i] || x > box.hi[i])) {
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

// If a higher limit helps: ", or create the mesh with a higher limit".
std::string HigherLimit(double all, const MeshOptions& options) {
  if (all > static_cast<double>(MostVertices(options.dimension))) return "";
  return ", or create the mesh with a higher limit";
}

}  // namespace

template <int D>
absl::Status SizeDemandError(const SizeFeature<D>& size, double vertices, double all,
                             const MeshOptions& options, EditIndex edit) {
  return Error(
      absl::StatusCode::kResourceExhausted, reason::kVertexLimit, {size.id}, edit,
      absl::StrCat("sizing feature ", size.id, " with target length ", Shortest(size.sizing.target),
                   " ", DemandText(vertices, all, options), "; give it a target of about ",
                   BetterTarget(size, vertices, all, options), " or more, or a smaller region",
                   HigherLimit(all, options)));
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
                            "; move them apart or make them one", HigherLimit(all, options)));
}

absl::Status CheckMaxEdge(const MeshOptions& options) {
  if (!(options.max_edge > 0)) return absl::OkStatus();
  const auto check = [&](const auto& region) {
    const double vertices = LeastVerticesIn(region, DomainBox(options));
    if (vertices <= static_cast<double>(options.limits.max_vertices)) return absl::OkStatus();
    return Error(absl::StatusCode::kResourceExhausted, reason::kVertexLimit, {}, kUntouched,
                 absl::StrCat("max_edge = ", Shortest(options.max_edge), " ",
                              DemandText(vertices, vertices, options), "; make it about ",
                              BetterTarget(region, vertices, vertices, options), " or more",
                              HigherLimit(vertices, options)));
  };
  return options.dimension == 2 ? check(SizeOfMaxEdge<2>(options))
                                : check(SizeOfMaxEdge<3>(options));
}

absl::Status InterruptedError() {
  return MakeError(absl::StatusCode::kCancelled,
                   "the batch was cancelled; the mesh is as it was before",
                   {reason::kCancelled, {}, {}});
}

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
