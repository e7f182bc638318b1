// Small input angles. Two segments that meet in a sharp angle would split each other for
// ever if both were halved: a midpoint of one encroaches on the other, closer to their
// common end, the *apex*, each time. So a segment with a sharp angle at its end is split on
// *shells* instead: at distances from the apex that are round dyadic numbers, the same ones
// on whatever segments meet there. Pieces between the same two shells never encroach on
// each other, and splitting a piece at the coarsest dyadic in its middle half makes those
// of two segments agree after finitely many splits and never finer than either needs.
//
// An edge between two segments of a wedge that joins vertices of one shell is *seditious*:
// as short as the angle makes it. Nothing is asked of it, or the wedge would be refined
// for ever; triangles that are bad for its sake alone are exempt (SMALL_INPUT_ANGLE).
//
// Everything here is a function of the segment and of the segments at its ends, to the bit:
// distances are kept as chosen and never recomputed from rounded coordinates.
#ifndef DYNMESH_CORE_MESHING_SHELLS_H_
#define DYNMESH_CORE_MESHING_SHELLS_H_

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::meshing {

// One end of a segment, among the segments that meet there.
struct WedgeEnd {
  bool acute = false;  // a neighbour in angle makes a small one with it (geometry/angles.h)
  double sine = 1;     // of the least such angle
  double reach = 0;    // how far the shadows of such neighbours fall on the segment
  friend bool operator==(const WedgeEnd&, const WedgeEnd&) = default;
};

// For each segment from apex to others[i]. No two in one direction. O(n log n).
std::vector<WedgeEnd> FindWedges(const geometry::Point2& apex,
                                 std::span<const geometry::Point2> others);

// How a segment from a to b, a < b, is to be split.
struct SegmentShape {
  bool acute_at_a = false, acute_at_b = false;
  // If at both: the distance from a where one apex hands over to the other. Split first.
  double handover = 0;
  friend bool operator==(const SegmentShape&, const SegmentShape&) = default;
};
SegmentShape ShapeOf(double length, const WedgeEnd& a, const WedgeEnd& b);

// The dyadic number m 2^e of the largest e within [lo, hi], 0 < lo <= hi.
double Coarsest(double lo, double hi);

// A piece of a segment, as far as splitting goes.
struct Piece {
  enum class Rule : std::uint8_t {
    kHalve,     // no acute end
    kHandOver,  // the whole of a segment with two
    kShells,
  };
  Rule rule = Rule::kHalve;
  bool from_b = false;  // the apex is the greater end of the whole segment
  // kShells: distances of the piece's lesser and greater end from the apex.
  // kHandOver: 0 and the distance from the lesser end where the piece is to be split.
  double at_a = 0, at_b = 0;

  static Piece Whole(const SegmentShape& shape, double length);
};

// Where a piece that is not to be halved is split: a distance from the apex (kHandOver:
// from the lesser end), and the two parts, the lesser one first.
double SplitDistance(const Piece& piece);
std::array<Piece, 2> SplitPiece(const Piece& piece, double length);

// The point of segment ab at a distance from a. Exact on axis-parallel segments as far as
// the sum is.
geometry::Point2 PointAt(const geometry::Point2& a, const geometry::Point2& b, double length,
                         double distance);

// |ab|, correctly rounded but for its sum; the same for ba.
double LengthOf(const geometry::Point2& a, const geometry::Point2& b);

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SHELLS_H_
