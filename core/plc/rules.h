// The rules between two features: which may not be near, on or across each other. Pure functions of
// coordinates and ids, thread-safe, O(1).
//
// Contacts are decided exactly (geometry/predicates.h). *Too close* and *too acute* are decided in
// doubles, by formulas with bits that do not depend on the order of arguments. So a verdict is a
// function of the two features alone.
#ifndef DYNMESH_CORE_PLC_RULES_H_
#define DYNMESH_CORE_PLC_RULES_H_

#include <cstdint>

#include "core/base/rounding.h"
#include "core/geometry/point.h"
#include "core/plc/delta.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

// Coordinates are 0 or at least this in magnitude: products of four of their differences are then
// exact multiples of 2^-1008 and cannot underflow.
inline constexpr double kMinCoordinate = 0x1p-200;

// The distance below which two features are too close: LeastDistance (core/base/rounding.h).
double CloseLimit(const MeshOptions& options);

// sin^2 of the least angle between segments, 0.001 degrees, less a millionth.
inline constexpr double kLeastSine2 = 3.046174197557781e-10 * kNarrower;

// The conflict of two features; of several, the least is reported.
enum class Conflict : std::uint8_t {
  kDuplicatePoint,
  kDuplicateSegment,
  kDuplicatePolygon,  // those of polygons: facet_rules.h
  kSegmentsOverlap,
  kPointOnSegment,
  kSegmentsCross,
  kPointOnPolygon,
  kSegmentMeetsPolygon,
  kPolygonsMeet,
  kSmallAngle,
  kTooClose,
  kEncroached,  // 2D: the circle over an unsplit segment
  kNone,
};

// Equal coordinates: kDuplicatePoint; nearer than `limit`: kTooClose.
template <int D>
Conflict Between(const PointFeature<D>& p, const PointFeature<D>& q, double limit);

// A point and a segment. None if the point is an end of it (by id).
template <int D>
Conflict Between(const PointFeature<D>& p, const SegmentFeature<D>& s, double limit);

// Two segments. The edges that polygons share with each other and with segment features are no
// conflict. The end of one *in* the other is left to the rule for point and segment. Segments with
// a common end must have an angle. With u, w the vectors from the common point:
//   kSmallAngle iff u.w > 0 and (u x w)^2 < sin^2(0.001 degrees) (1 - 1e-6) |u|^2 |w|^2.
//   3D: segments that do not meet may not be nearer than `limit`.
template <int D>
Conflict Between(const SegmentFeature<D>& s, const SegmentFeature<D>& t, double limit);

// 2D. Does p lie inside the circle over s, a segment that is unsplit? If it is on the circle: 0,
// else not. Neither for an end of s (by id). Exact.
enum class CircleSide : std::uint8_t { kOutside, kOn, kInside };
CircleSide SideOfCircle(const PointFeature<2>& p, const SegmentFeature<2>& s);

// 2D. Would splits of `f` be in the way of s? If s is unsplit and f is not (nor marked), f may not
// come within a radius of the middle of s, nor leave an end of s at less than 90 degrees. In
// doubles, the same to the bit whatever the directions. `limit`: CloseLimit.
bool MayEncroach(const SegmentFeature<2>& f, const SegmentFeature<2>& s, double limit);

// Is the angle between apex-a and apex-b, and any larger one up to 180 degrees, certainly no
// kSmallAngle? In doubles.
bool AreAtClearAngle(const geometry::Point2& apex, const geometry::Point2& a,
                     const geometry::Point2& b);

// Is the distance of p to segment ab below `limit`? In doubles, with an error of an ulp of the
// domain; the same to the bit for ba.
template <int D>
bool IsNear(const geometry::Point<D>& p, const geometry::Point<D>& a, const geometry::Point<D>& b,
            double limit);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_RULES_H_
