// Sizing regions, where the mesh is to be finer than its geometry requires, with their target
// lengths; and which balls are too large for them.
//
// A triangle that meets a region of target h may have no edge longer than sqrt(2) h: its
// circumradius must be at most h / sqrt(2). The test is applied if the triangle's circumscribed
// *ball* meets the region, so no triangle that meets it is missed.
//
// Answers are a function of the regions present. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_SIZING_FIELD_H_
#define DYNMESH_CORE_MESHING_SIZING_FIELD_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>

#include "core/base/rounding.h"
#include "core/geometry/point.h"
#include "core/meshing/anchor_lattice.h"
#include "core/meshing/box_tree.h"
#include "core/meshing/sizing_shape.h"

namespace dynmesh::meshing {

// All points within `radius` of a box (a point, a disc, a box), or of a shape in it.
template <int D>
struct SizingRegion {
  geometry::Point<D> lo = {}, hi = {};
  double radius = 0;
  double target = 0;                                      // h
  std::shared_ptr<const SizingShape<D>> shape = nullptr;  // between lo and hi; null: all of the box
  double most_radius() const { return KeyOf(target); }
  Extent<D> Box() const {
    Extent<D> box = Extent<D>::Nothing();
    box.AddBall(lo, radius);
    box.AddBall(hi, radius);
    return box;
  }
  bool Meets(const geometry::Point<D>& centre, double ball_radius) const;
  // True if all of the ball, or of the box, is certainly in the region, by more than tests of
  // regions round. Conservative: may return false needlessly, never true wrongly.
  bool Holds(const geometry::Point<D>& centre, double ball_radius) const {
    return Holds(centre, ball_radius, 0);
  }
  bool Holds(const Extent<D>& box) const { return HoldsAround(box, 0); }
  bool Holds(const SizingRegion& other) const {
    return HoldsAround({other.lo.c, other.hi.c}, other.radius);
  }
  // True if a point of the box may be in the region. Conservative: may return true needlessly.
  bool MayMeet(const Extent<D>& box) const;
  // The finest level of lattice (anchor_lattice.h) that the region has at a point within `margin`
  // of x. margin < 0: at all points within -margin. Returns `below` if no level finer than that
  // applies.
  int LevelNear(const geometry::Point<D>& x, double margin, int below) const;
  // The same at all points within `ball_radius` of x. Conservative: may return a wider level if
  // ball_radius > 0.
  int LevelOver(const geometry::Point<D>& x, double ball_radius, int below) const;
  // How far x is from the box with its radius around; inside, minus how deep it is.
  double DistanceToBox(const geometry::Point<D>& x) const;
  // For BoxTree: a ball that is not too large for the target need not find the region.
  double LeastCell() const { return target; }
  double Key() const { return most_radius(); }
  static double KeyOf(double target) { return target * 0.70710678118654752; }
  friend bool operator==(const SizingRegion&, const SizingRegion&) = default;

 private:
  double SquaredDistanceToBox(const geometry::Point<D>& x) const;
  // All within `margin` of the box is certainly in the region.
  bool HoldsAround(const Extent<D>& box, double margin) const;
  // All of the ball is certainly within `reach` of the region.
  bool Holds(const geometry::Point<D>& centre, double ball_radius, double reach) const;
};

template <int D>
class SizingField {
 public:
  using Region = SizingRegion<D>;
  using Point = geometry::Point<D>;
  using Index = typename BoxTree<D, Region>::Index;

  // Covers the box: regions should meet it.
  SizingField(const Point& lo, const Point& hi) : regions_(lo, hi) {}

  Index Add(const Region& region) {
    ++levels_[AnchorLattice<D>::LevelOf(region.target)];
    return regions_.Add(region);
  }
  void Remove(Index index) {
    const auto level = levels_.find(AnchorLattice<D>::LevelOf(regions_[index].target));
    if (--level->second == 0) levels_.erase(level);
    regions_.Remove(index);
  }
  // The levels of the regions' own lattices, with how many regions have each.
  const std::map<int, int>& levels() const { return levels_; }
  bool empty() const { return regions_.empty(); }
  std::size_t size() const { return regions_.size(); }
  const Region& operator[](Index index) const { return regions_[index]; }

  // True if the ball meets a region for which it is too large. If not: O(cells of its size nearby);
  // else less.
  bool IsTooLarge(const Point& centre, double radius) const {
    return regions_.Any(centre, radius, radius,
                        [&](Index i) { return regions_[i].Meets(centre, radius); });
  }

  // True if accept(region) holds for a region near the ball. Calls accept for all that meet the
  // ball and for some others.
  template <class Accept>
  bool Any(const Point& centre, double radius, Accept accept) const {
    return regions_.Any(centre, radius, INFINITY, [&](Index i) { return accept(regions_[i]); });
  }

  // The same with accept(index), for regions with at most that target.
  template <class Accept>
  bool AnyAsFine(const Point& centre, double radius, double target, Accept accept) const {
    return regions_.Any(centre, radius, INFINITY,
                        [&](Index i) { return regions_[i].target <= target && accept(i); });
  }
  // True if accept(index) holds for a region with at most that target. Calls accept for those that
  // hold the box, and for some others. O(their number).
  template <class Accept>
  bool AnyAround(const Extent<D>& box, double target, Accept accept) const;
  // The least LevelOver of the regions for which counts(index) is true.
  template <class Counts>
  int LevelOver(const Point& x, double ball_radius, int below, Counts counts) const;

  // The least target of the regions that meet the ball; INFINITY if there is none.
  double LeastTarget(const Point& centre, double radius) const {
    double least = INFINITY;
    Any(centre, radius, [&](const Region& region) {
      if (region.target < least && region.Meets(centre, radius)) least = region.target;
      return false;
    });
    return least;
  }

  // The least LevelNear of all regions.
  int FinestLevel(const Point& x, double margin, int below) const {
    return LevelNear(x, margin, below, false, [](const Region&) { return true; });
  }
  // True if LevelNear of a region with accept(region) is less than `below`.
  template <class Accept>
  bool HasFinerLevel(const Point& x, double margin, int below, Accept accept) const {
    return LevelNear(x, margin, below, true, accept) < below;
  }
  bool HasFinerLevel(const Point& x, double margin, int below) const {
    return HasFinerLevel(x, margin, below, [](const Region&) { return true; });
  }

  std::size_t bytes() const { return regions_.bytes(); }

 private:
  template <class Accept>
  int LevelNear(const Point& x, double margin, int below, bool any, Accept accept) const;

  BoxTree<D, Region> regions_;
  std::map<int, int> levels_;
};

template <int D>
template <class Accept>
bool SizingField<D>::AnyAround(const Extent<D>& box, double target, Accept accept) const {
  const double key = Region::KeyOf(target);
  return regions_.Visit(
      [&](double least, const Extent<D>& around) {
        bool holds = least <= key;
        for (int k = 0; k < D; ++k) {
          holds &= around.lo[k] <= box.lo[k] && box.hi[k] <= around.hi[k];
        }
        return holds;
      },
      [&](Index i) { return regions_[i].target <= target && accept(i); });
}

template <int D>
template <class Counts>
int SizingField<D>::LevelOver(const Point& x, double ball_radius, int below, Counts counts) const {
  using Lattice = AnchorLattice<D>;
  int finest = below;
  double key = 0, far2 = 0;  // as in LevelNear
  const auto set_bounds = [&] {
    const double reach = Lattice::MostReach(finest);
    key = Region::KeyOf(Lattice::MostTarget(finest));
    far2 = reach * reach * kBarelyWider;
  };
  set_bounds();
  regions_.Visit(
      [&](double least, const Extent<D>& box) {
        if (!(least < key)) return false;
        double d2 = 0;
        for (int k = 0; k < D; ++k) {
          const double d = std::max({0.0, box.lo[k] - x[k], x[k] - box.hi[k]});
          d2 += d * d;
        }
        return d2 < far2;
      },
      [&](Index i) {
        if (!(regions_[i].Key() < key)) return false;
        const int level = regions_[i].LevelOver(x, ball_radius, finest);
        if (level < finest && counts(i)) finest = level, set_bounds();
        return false;
      });
  return finest;
}

template <int D>
template <class Accept>
int SizingField<D>::LevelNear(const Point& x, double margin, int below, bool any,
                              Accept accept) const {
  using Lattice = AnchorLattice<D>;
  int finest = below;
  double key = 0, far2 = 0;  // Regions with this key or more, or this far away, have no finer level
                             // here.
  const auto set_bounds = [&] {
    const double reach = Lattice::MostReach(finest) + margin;
    key = reach >= 0 ? Region::KeyOf(Lattice::MostTarget(finest)) : 0;
    far2 = reach * reach * kBarelyWider;
  };
  set_bounds();
  regions_.Visit(
      [&](double least, const Extent<D>& box) {
        if (!(least < key)) return false;
        double d2 = 0;
        for (int k = 0; k < D; ++k) {
          const double d = std::max({0.0, box.lo[k] - x[k], x[k] - box.hi[k]});
          d2 += d * d;
        }
        return d2 < far2;
      },
      [&](Index i) {
        const Region& region = regions_[i];
        if (!(region.Key() < key) || !accept(region)) return false;
        const int level = region.LevelNear(x, margin, finest);
        if (level < finest) finest = level, set_bounds();
        return any && finest < below;
      });
  return finest;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SIZING_FIELD_H_
