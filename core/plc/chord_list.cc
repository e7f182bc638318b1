#include "core/plc/chord_list.h"

#include <vector>

#include "core/geometry/predicates.h"

namespace dynmesh::plc {

using geometry::Orientation;
using geometry::Point2;

bool ChordBefore::operator()(Slot i, Slot j) const {
  if (i == j) return false;
  const GridSegment<2>& s = (*table)[i];
  const GridSegment<2>& t = (*table)[j];
  const int axis = s.major();
  // "Left of a chord from lo to hi" is above a flat chord, but before a steep one.
  const int sign = s.flat ? 1 : -1;
  const Point2 &s_lo = s.lo_point(), &s_hi = s.hi_point();
  const Point2 &t_lo = t.lo_point(), &t_hi = t.hi_point();
  // The end of one chord within the range of the other determines the order. If they share that
  // end, the other ends do.
  const int at_lo =
      s_lo[axis] <= t_lo[axis] ? Orientation(s_lo, s_hi, t_lo) : -Orientation(t_lo, t_hi, s_lo);
  if (at_lo != 0) return sign * at_lo > 0;
  const int at_hi =
      t_hi[axis] <= s_hi[axis] ? Orientation(s_lo, s_hi, t_hi) : -Orientation(t_lo, t_hi, s_hi);
  return sign * at_hi > 0;
}

void ChordList::AppendTo(std::vector<Slot>& slots) const {
  for (const Set& set : sets_) slots.insert(slots.end(), set.begin(), set.end());
}

void ChordList::Visit(int major, const ChordProbe& positions, double margin,
                      absl::FunctionRef<void(const GridSegment<2>&)> visit) const {
  const Set& set = sets_[major];
  // MinorAt errs by less than 1/16 unit, so bisection stops at most that far from the true
  // position. The margin covers it.
  ChordProbe below = positions;
  below.minor_a -= margin;
  below.minor_b -= margin;
  for (auto it = set.lower_bound(below); it != set.end(); ++it) {
    const GridSegment<2>& chord = (*table_)[*it];
    if (chord.MinorAt(positions.major_a) > positions.minor_a + margin &&
        chord.MinorAt(positions.major_b) > positions.minor_b + margin) {
      break;
    }
    visit(chord);
  }
}

}  // namespace dynmesh::plc
