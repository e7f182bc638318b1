// The rules between a facet and what is near it, pair by pair. As rules.h: pure functions of the
// two features, thread-safe, decided in doubles at stated distances and angles.
//
// A facet is as thick as its corners are off its plane (`deviation`, 0 where coordinates allow).
// What lies no farther than that from the plane, give or take a 64th of the close limit, is on it.
// Distances of places over the inside of a facet are to its plane; what is nearest to it beside the
// inside is nearest to one of its edges, and those are segments with rules of their own. So the
// rules here need only find places over the inside and lines that pass through it.
//
// Angles: at least 70 degrees (less a millionth of the sine) between two facets at a common edge,
// and between a facet and a segment, or an edge of another facet that has only the corner in
// common, that rises from a corner over the facet's inside. Regular tetrahedra have 70.53.
#ifndef DYNMESH_CORE_PLC_FACET_RULES_H_
#define DYNMESH_CORE_PLC_FACET_RULES_H_

#include "core/plc/delta.h"
#include "core/plc/facet.h"
#include "core/plc/rules.h"

namespace dynmesh::plc {

inline constexpr double kLeastFacetAngle = 70;  // degrees

// How far corners may be off the plane: 1e-9 of the facet's extent, at least 8 spacings of doubles.
double PlanarityTolerance(double extent, double limit);

// kPointOnPolygon, kTooClose. None for its corners.
Conflict Between(const PointFeature<3>& p, const Facet& f, double limit);

// kSegmentMeetsPolygon: it passes through the inside, or joins two corners across it; kSmallAngle,
// of segment features only. None for its edges.
Conflict Between(const SegmentFeature<3>& s, const Facet& f, double limit);

// kDuplicatePolygon, the same edges; kPolygonsMeet, the insides have something in common;
// kSmallAngle. What an edge or a corner of one does in the other is left to the rules above.
Conflict Between(const Facet& f, const Facet& g, double limit);

// The least angle, in degrees, of those that kSmallAngle is about; 180 if there are none.
double LeastAngle(const SegmentFeature<3>& s, const Facet& f);
double LeastAngle(const Facet& f, const Facet& g);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_FACET_RULES_H_
