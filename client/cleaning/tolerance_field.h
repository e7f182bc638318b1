// The tolerance of a surface's cleaning at each place: the least one, and in some cubes that times
// a power of 2, where repairs with less would undo each other.
//
// Thread-compatible; const methods thread-safe. O(lg n) expected for n cubes.
#ifndef DYNMESH_CLIENT_CLEANING_TOLERANCE_FIELD_H_
#define DYNMESH_CLIENT_CLEANING_TOLERANCE_FIELD_H_

#include <cmath>
#include <compare>
#include <memory>
#include <vector>

#include "client/cleaning/box3.h"
#include "client/cleaning/node_table.h"

namespace dynmesh::cleaning {

// Where repairs undo each other, and the tolerance that would make one of what is there, if known.
struct StuckPlace {
  Point3 at{};
  double wanted = 0;
  auto operator<=>(const StuckPlace&) const = default;
};

class ToleranceField {
 public:
  explicit ToleranceField(double least);
  ~ToleranceField();

  double least() const { return least_; }
  // Of the greatest tolerance; the least one has level 0.
  int most_level() const { return most_level_; }
  double most() const { return Of(most_level_); }

  // The tolerance at p is least * 2^level.
  int LevelAt(const Point3& p) const { return LevelIn({p, p}); }
  double At(const Point3& p) const { return Of(LevelAt(p)); }
  // The greatest one in the box.
  double MostIn(const Box3& box) const { return Of(LevelIn(box)); }

  // Makes the tolerance near each of the places twice what it is, or what is wanted if that is
  // more: in a cube of some new tolerances around it, or around one that is nearly there. Up to
  // this level.
  void RaiseAt(std::vector<StuckPlace> places, int most_level);

 private:
  struct Tree;

  double Of(int level) const { return std::ldexp(least_, level); }
  int LevelIn(const Box3& box) const;

  double least_;
  int most_level_ = 0;
  std::unique_ptr<Tree> tree_;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_TOLERANCE_FIELD_H_
