// The chords of one cell: segments that cross the whole cell, in order.
//
// Flat segments that span a cell's range of x and do not cross are totally ordered by y, at every x
// alike; steep ones by x. So bisection finds the chords near a position. Not thread-safe; const
// members may run concurrently. O(log size) each.
#ifndef DYNMESH_CORE_PLC_CHORD_LIST_H_
#define DYNMESH_CORE_PLC_CHORD_LIST_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/container/btree_set.h"
#include "absl/functional/function_ref.h"
#include "core/base/large_vector.h"
#include "core/plc/cell_grid.h"

namespace dynmesh::plc {

// Two positions (major coordinate, minor coordinate), maybe equal.
struct ChordProbe {
  double major_a, minor_a, major_b, minor_b;
};

// Does the flat (steep) chord i pass below (left of) chord j? Exact.
// REQUIRES: both flat or both steep; they overlap on the major axis; no crossing.
struct ChordBefore {
  using is_transparent = void;
  const SegmentTable<2>* table;

  bool operator()(Slot i, Slot j) const;
  bool operator()(Slot i, const ChordProbe& probe) const {
    const GridSegment<2>& s = (*table)[i];
    return s.MinorAt(probe.major_a) < probe.minor_a && s.MinorAt(probe.major_b) < probe.minor_b;
  }
  bool operator()(const ChordProbe& probe, Slot i) const {
    const GridSegment<2>& s = (*table)[i];
    return s.MinorAt(probe.major_a) > probe.minor_a && s.MinorAt(probe.major_b) > probe.minor_b;
  }
};

class ChordList {
 public:
  explicit ChordList(const SegmentTable<2>* table) : table_(table), sets_{Set(table), Set(table)} {}

  // REQUIRES: the chord spans the cell and crosses no other chord in the list.
  void Insert(Slot chord) { SetOf(chord).insert(chord); }
  void Erase(Slot chord) { SetOf(chord).erase(chord); }

  std::size_t size() const { return sets_[0].size() + sets_[1].size(); }
  void AppendTo(std::vector<Slot>& slots) const;

  // Visits the chords with major axis `major` that pass within `margin` of one of the two
  // positions, or between them: above one, below the other. REQUIRES: the positions' major
  // coordinates are in the cell's closed range.
  void Visit(int major, const ChordProbe& positions, double margin,
             absl::FunctionRef<void(const GridSegment<2>&)> visit) const;

 private:
  struct Set : absl::btree_set<Slot, ChordBefore> {
    explicit Set(const SegmentTable<2>* table)
        : absl::btree_set<Slot, ChordBefore>(ChordBefore{table}) {}
  };
  Set& SetOf(Slot chord) { return sets_[(*table_)[chord].major()]; }

  const SegmentTable<2>* table_;
  Set sets_[2];  // by major axis
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_CHORD_LIST_H_
