// The errors that relations between features and places of points cause, as
// statuses: code, reason, features (the offender first), and what to do.
// Pure functions.
#ifndef DYNMESH_CORE_PLC_MESSAGES_H_
#define DYNMESH_CORE_PLC_MESSAGES_H_

#include <span>
#include <variant>

#include "absl/status/status.h"
#include "core/plc/delta.h"
#include "core/plc/draft.h"
#include "core/plc/facet.h"
#include "core/plc/rules.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

template <int D>
using AnyFeature = std::variant<PointFeature<D>, SegmentFeature<D>, Facet>;

// `conflict` is not kNone; it is between `offender`, blamed on `edit`, and `other`.
template <int D>
absl::Status ConflictError(Conflict conflict, const AnyFeature<D>& offender,
                           const AnyFeature<D>& other, double limit, EditIndex edit);

// The rings of polygon or sizing polygon `id` by themselves, combinatorially: at least one,
// each of three points or more, none twice; no edge twice. BAD_POLYGON.
absl::Status CheckRings(FeatureId id, const Rings& rings, EditIndex edit);

// Polygon `id` in a mesh of `options`: in space one whose quality allows polygons
// (QUALITY_TOO_LOW).
absl::Status CheckQuality(FeatureId id, const MeshOptions& options, EditIndex edit);

// A facet by itself: an area (BAD_POLYGON), and corners in one plane as nearly as
// PlanarityTolerance allows (NON_PLANAR).
absl::Status CheckFacet(const Facet& facet, double limit, EditIndex edit);

// A sizing feature by itself: numbers finite, a region that meets the box (a point or
// centre in it), a target that distances of `limit` leave room for. In
// space no polygon.
template <int D>
absl::Status CheckSize(const SizeFeature<D>& size, const Box& box, double limit, EditIndex edit);

// OK if the point is finite, in the closed box, and no coordinate is too near to 0.
template <int D>
absl::Status CheckPlace(const PointFeature<D>& point, const Box& box, EditIndex edit);

absl::Status DegenerateSegmentError(FeatureId segment, FeatureId end, EditIndex edit);

// The ids in `missing` (at least one) are ends of a segment or corners of a polygon and are no
// points.
absl::Status UnknownEndError(FeatureId feature, std::span<const FeatureId> missing, EditIndex edit);

// Point `id` is gone, but `users` (at least one) end there.
absl::Status PointInUseError(FeatureId id, std::span<const FeatureId> users, EditIndex edit);

// A sizing feature, alone or with others, that takes more vertices than a mesh of `options` may
// have: `vertices` of its own at least, `all` together. RESOURCE_EXHAUSTED (VERTEX_LIMIT).
template <int D>
absl::Status RegionDemandError(const SizeFeature<D>& size, double vertices, double all,
                               const MeshOptions& options, EditIndex edit);

// The same of two features that are `distance` apart.
template <int D>
absl::Status GapDemandError(const AnyFeature<D>& offender, const AnyFeature<D>& other,
                            double distance, double vertices, double all,
                            const MeshOptions& options, EditIndex edit);

// The same of max_edge; OK if it does not.
absl::Status CheckMaxEdge(const MeshOptions& options);

// Not the batch's fault: it was not looked at to the end.
absl::Status InterruptedError();

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_MESSAGES_H_
