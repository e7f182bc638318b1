// Small angles between segments. If two segments that meet at a sharp angle were both halved, they
// would split each other for ever: each time a midpoint of one encroaches on the other, closer to
// their common end, the *apex*.
//
// So a segment with a sharp angle at its end is split on *shells* instead: at distances from the
// apex that are round dyadic numbers, the same for all segments that meet there.
// 1. Subsegments between the same two shells never encroach on each other.
// 2. A subsegment is split at the coarsest dyadic number in its middle half. So the subsegments of
//    two segments agree after finitely many splits, and are never finer than either segment needs.
//
// An edge between two segments of a wedge that joins vertices of one shell is *seditious*: it is as
// short as the angle makes it. No criterion applies to it, or the wedge would be refined for ever.
// Triangles that are bad only because of it are exempt (SMALL_INPUT_ANGLE).
//
// Everything here is a function of the segment and of the segments at its ends, to the bit:
// distances are kept as chosen and never recomputed from rounded coordinates.
#ifndef DYNMESH_CORE_MESHING_SHELLS_H_
#define DYNMESH_CORE_MESHING_SHELLS_H_

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::meshing {

// One end of a segment, among the segments that meet there.
struct WedgeEnd {
  bool acute = false;  // a neighbour makes a small angle with it (geometry/angles.h)
  double sine = 1;     // of the least such angle
  double reach = 0;    // length of the longest shadow of such a neighbour on the segment
  friend bool operator==(const WedgeEnd&, const WedgeEnd&) = default;
};

// For each segment from apex to others[i]. REQUIRES: no two have one direction. In 2D the
// neighbours of a segment are the next ones by angle, in 3D all that make a small angle with it.
// O(n log n), in 3D O(n^2).
template <int D>
std::vector<WedgeEnd> FindWedges(const geometry::Point<D>& apex,
                                 std::span<const geometry::Point<D>> others);

// How a segment from a to b, a < b, is to be split.
struct SegmentShape {
  bool acute_at_a = false, acute_at_b = false;
  // If both ends are acute: the distance from a where one apex hands over to the other. Split there
  // first.
  double handover = 0;
  friend bool operator==(const SegmentShape&, const SegmentShape&) = default;
};
template <int D>
SegmentShape ShapeOf(double length, const WedgeEnd& a, const WedgeEnd& b);

// The dyadic number m 2^e of the largest e within [lo, hi], 0 < lo <= hi.
double Coarsest(double lo, double hi);

// How a subsegment is to be split.
struct SplitRule {
  enum class Kind : std::uint8_t {
    kHalve,     // no acute end
    kHandOver,  // a whole segment with two acute ends
    kShells,
  };
  Kind kind = Kind::kHalve;
  bool from_b = false;  // the apex is the greater end of the whole segment
  // kShells: distances of the subsegment's lesser and greater end from the apex. kHandOver: 0, and
  // the distance from the lesser end at which to split.
  double at_a = 0, at_b = 0;

  static SplitRule Whole(const SegmentShape& shape, double length);
};

// SplitDistance: where a subsegment that is not halved is split, as a distance from the apex
// (kHandOver: from the lesser end). RulesOfParts: its two parts, the lesser one first.
double SplitDistance(const SplitRule& rule);
std::array<SplitRule, 2> RulesOfParts(const SplitRule& rule, double length);

// The point of segment ab at `distance` from a. On axis-parallel segments as exact as the sum.
template <int D>
geometry::Point<D> PointAt(const geometry::Point<D>& a, const geometry::Point<D>& b, double length,
                           double distance) {
  const double fraction = distance / length;
  geometry::Point<D> p;
  for (int i = 0; i < D; ++i) p[i] = a[i] == b[i] ? a[i] : a[i] + fraction * (b[i] - a[i]);
  return p;
}

// |ab|, correctly rounded except for its sum; the same for ba.
template <int D>
double LengthOf(const geometry::Point<D>& a, const geometry::Point<D>& b) {
  return std::sqrt(geometry::SquaredDistance(a, b));
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SHELLS_H_
