// Errors by relations between features and by positions of points, as statuses: code, reason,
// features (the one to blame first), and what to do. Pure functions.
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

// REQUIRES: `conflict` is not kNone. It is between `offender`, blamed on `edit`, and `other`.
template <int D>
absl::Status ConflictError(Conflict conflict, const AnyFeature<D>& offender,
                           const AnyFeature<D>& other, double limit, EditIndex edit);

// Checks the rings of polygon or sizing polygon `id` by themselves, combinatorially: at least one
// ring, each of three points or more without duplicates; no edge twice. BAD_POLYGON.
absl::Status CheckRings(FeatureId id, const Rings& rings, EditIndex edit);

// Checks that a mesh of `options` may have polygon `id`: in 3D its quality must allow polygons
// (QUALITY_TOO_LOW).
absl::Status CheckQuality(FeatureId id, const MeshOptions& options, EditIndex edit);

// Checks a facet by itself: it has an area (BAD_POLYGON), and its corners are in one plane within
// PlanarityTolerance (NON_PLANAR).
absl::Status CheckFacet(const Facet& facet, double limit, EditIndex edit);

// Checks a sizing feature by itself: finite numbers, a region that meets the box (a point or centre
// in it), a target that is large enough for the least distance `limit`. In 3D no polygon.
template <int D>
absl::Status CheckSize(const SizeFeature<D>& size, const Box& box, double limit, EditIndex edit);
absl::Status SizeUnusedError(FeatureId id, const MeshOptions& options, EditIndex edit);

// OK if the point is finite, in the closed box, and no coordinate is too close to 0.
template <int D>
absl::Status CheckPosition(const PointFeature<D>& point, const Box& box, EditIndex edit);

absl::Status DegenerateSegmentError(FeatureId segment, FeatureId end, EditIndex edit);

// A segment, or an edge of a polygon, that may not be unsplit: in 3D, or in a quadtree.
template <int D>
absl::Status UnsplitError(const SegmentFeature<D>& segment, const MeshOptions& options,
                          EditIndex edit);

// The ids in `missing` (at least one) are ends of a segment or corners of a polygon, but not
// points.
absl::Status UnknownEndError(FeatureId feature, std::span<const FeatureId> missing, EditIndex edit);

// Point `id` is removed, but `users` (at least one) need it.
absl::Status PointInUseError(FeatureId id, std::span<const FeatureId> users, EditIndex edit);

// A sizing feature, alone or with others, needs more vertices than a mesh of `options` may have: at
// least `vertices` by itself, at least `all` together. RESOURCE_EXHAUSTED (VERTEX_LIMIT).
template <int D>
absl::Status SizeDemandError(const SizeFeature<D>& size, double vertices, double all,
                             const MeshOptions& options, EditIndex edit);

// The same for two features that are `distance` apart.
template <int D>
absl::Status GapDemandError(const AnyFeature<D>& offender, const AnyFeature<D>& other,
                            double distance, double vertices, double all,
                            const MeshOptions& options, EditIndex edit);

// The same for max_edge; OK if it needs no more.
absl::Status CheckMaxEdge(const MeshOptions& options);

// The check was interrupted: CANCELLED.
absl::Status InterruptedError();

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_MESSAGES_H_
