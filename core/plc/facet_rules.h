// The rules between a facet and a feature near it, pair by pair. As rules.h: pure functions of the
// two features, thread-safe. Decided in doubles at the stated distances and angles.
//
// A facet's thickness is the largest distance of a corner from its plane (`deviation`, 0 where
// coordinates allow). A position is on the plane if it is at most that distance away, within a 64th
// of the close limit. The distance of a position over the inside of a facet is that to its plane.
// Beside the inside, the nearest part is an edge, and edges are segments with rules of their own.
// So these rules need to treat only positions over the inside and lines that pass through it.
//
// Angles have a least size, less a millionth of the sine's square:
//   * between two facets at a common edge: 0.05 degrees. Vertices between them grow as 1 / angle;
//   * between a facet and a segment that rises from one of its corners over its inside: 0.001
//     degrees, as between segments (rules.h);
//   * between a facet and such an edge of another facet, if only the corner is common: the same.
//     Beside a needle of a triangulated wall the next facets are often below 1 degree.
#ifndef DYNMESH_CORE_PLC_FACET_RULES_H_
#define DYNMESH_CORE_PLC_FACET_RULES_H_

#include "core/plc/delta.h"
#include "core/plc/facet.h"
#include "core/plc/rules.h"

namespace dynmesh::plc {

// In degrees.
inline constexpr double kLeastAngleAtEdges = 0.05, kLeastAngleAtCorners = 0.001;

// The greatest allowed distance of corners from the plane: 1e-9 of the facet's extent, at least 8
// ulps.
double PlanarityTolerance(double extent, double limit);

// kPointOnPolygon, kTooClose. kNone for its corners.
Conflict Between(const PointFeature<3>& p, const Facet& f, double limit);

// kSegmentMeetsPolygon: it passes through the inside, or joins two corners across it. kSmallAngle:
// for segment features only. kNone for its edges.
Conflict Between(const SegmentFeature<3>& s, const Facet& f, double limit);

// kDuplicatePolygon: the same edges. kPolygonsMeet: the insides intersect. kSmallAngle. Edges and
// corners of one in the other are left to the rules above.
Conflict Between(const Facet& f, const Facet& g, double limit);

// An angle at which features meet, and the least allowed one of its kind. In degrees.
struct SharpContact {
  double angle, allowed;
};
// Of two features with kSmallAngle.
SharpContact LeastAngle(const SegmentFeature<3>& s, const Facet& f);
SharpContact LeastAngle(const Facet& f, const Facet& g);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_FACET_RULES_H_
