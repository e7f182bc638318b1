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
// In 3D the vertex is beside its shell by a tiny part of the subsegment, its *skew*. Without it,
// two shells cut two edges of a facet in four points on a circle. Rounding takes these off the
// facet's plane, and the Delaunay triangulation fills the gap with a tetrahedron of 1e-14 degrees.
// The skew is so small beside the wedge's angle that 1. stays true.
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
#include <cstddef>
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
  // 3D, of acute ends: skews are at most 2^-that of the subsegment that is split. 0: there are
  // none.
  std::uint8_t skew_at_a = 0, skew_at_b = 0;
  bool unsplit = false;  // it is not; then nothing else counts
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
    kUnsplit,  // not at all
  };
  Kind kind = Kind::kHalve;
  bool from_b = false;                        // the apex is the greater end of the whole segment
  std::uint8_t skew_at_a = 0, skew_at_b = 0;  // of the segment's shape
  // kShells: distances of the subsegment's lesser and greater end from the apex. kHandOver: 0, and
  // the distance from the lesser end at which to split.
  double at_a = 0, at_b = 0;

  static SplitRule Whole(const SegmentShape& shape, double length);
};

// SplitDistance: where a subsegment that is not halved is split, as a distance from the apex
// (kHandOver: from the lesser end). RulesOfParts: its two parts, the lesser one first.
double SplitDistance(const SplitRule& rule);
std::array<SplitRule, 2> RulesOfParts(const SplitRule& rule, double length);

// A number in [-1, 1] for a direction u from an apex: a continuous function that varies within a
// thousandth of a radian. So edges of one facet differ in it, and parallel edges do not, even where
// rounding made their directions differ: what is a rectangle across a plate stays one.
double WaveOf(const std::array<double, 3>& u);

// kShells in 3D: how much farther from the apex than SplitDistance the vertex is, on the segment
// from `apex` to `other`. At most 2^-18 of SplitDistance, on either side.
template <int D>
double SkewOf(const SplitRule& rule, const geometry::Point<D>& apex,
              const geometry::Point<D>& other, double length) {
  const int exponent = rule.from_b ? rule.skew_at_b : rule.skew_at_a;
  if (D == 2 || exponent == 0) return 0;
  std::array<double, 3> u = {};
  for (int i = 0; i < D; ++i) u[static_cast<std::size_t>(i)] = (other[i] - apex[i]) / length;
  return std::ldexp(WaveOf(u) * std::fabs(rule.at_b - rule.at_a), -exponent);
}

// 3D. How much nearer to the apex a counterpart (sharp_facets.h) is than the vertex of a segment
// that it comes from, in units of the vertex's distance; of the angle between them the sine's
// square. 0 for the least angles.
double SkewOfCounterpart(double squared_sine);

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
