// Where the mesh is to be finer than its geometry asks: regions with a target length, and
// which balls are too large for them.
//
// A triangle that meets a region of target h is to have no edge longer than sqrt(2) h: its
// circumradius is at most h / sqrt(2). Asked of the triangle's circumscribed *ball* if that
// meets the region, so that no triangle which meets it escapes.
//
// Answers are a function of the regions present. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_SIZING_FIELD_H_
#define DYNMESH_CORE_MESHING_SIZING_FIELD_H_

#include <cmath>
#include <cstddef>
#include <memory>

#include "core/geometry/point.h"
#include "core/meshing/polygon_area.h"
#include "core/meshing/region_tree.h"

namespace dynmesh::meshing {

// All places within `radius` of a box: a point, a disc, a box; or what is inside some rings.
template <int D>
struct SizingRegion {
  geometry::Point<D> lo = {}, hi = {};
  double radius = 0;
  double target = 0;                                  // h
  std::shared_ptr<const PolygonArea> area = nullptr;  // in the plane: between lo and hi; radius 0
  double most_radius() const { return target * 0.70710678118654752; }
  bool Meets(const geometry::Point<D>& centre, double ball_radius) const;
  // For RegionTree: balls that are not too large for the target need not find it.
  double LeastCell() const { return target; }
  double Key() const { return most_radius(); }
  friend bool operator==(const SizingRegion&, const SizingRegion&) = default;
};

template <int D>
class SizingField {
 public:
  using Region = SizingRegion<D>;
  using Point = geometry::Point<D>;
  using Index = typename RegionTree<D, Region>::Index;

  // Covers the box: regions should meet it.
  SizingField(const Point& lo, const Point& hi) : regions_(lo, hi) {}

  Index Add(const Region& region) { return regions_.Add(region); }
  void Remove(Index index) { regions_.Remove(index); }
  bool empty() const { return regions_.empty(); }
  const Region& operator[](Index index) const { return regions_[index]; }

  // Is there a region that the ball meets and is too large for? O(cells of its size nearby)
  // where none is, less where one is.
  bool IsTooLarge(const Point& centre, double radius) const {
    return regions_.Any(centre, radius, radius,
                        [&](Index i) { return regions_[i].Meets(centre, radius); });
  }

  // Is there a region near the ball for which accept(region) says yes? Asks of all that meet the
  // ball, and of some others.
  template <class Accept>
  bool Any(const Point& centre, double radius, Accept accept) const {
    return regions_.Any(centre, radius, INFINITY, [&](Index i) { return accept(regions_[i]); });
  }

  // The least target of regions that meet the ball; INFINITY if none does.
  double LeastTarget(const Point& centre, double radius) const {
    double least = INFINITY;
    Any(centre, radius, [&](const Region& region) {
      if (region.target < least && region.Meets(centre, radius)) least = region.target;
      return false;
    });
    return least;
  }

  std::size_t bytes() const { return regions_.bytes(); }

 private:
  RegionTree<D, Region> regions_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SIZING_FIELD_H_
