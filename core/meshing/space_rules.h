// The gap of an edge in space, and the Steiner point for it.
//
// The Voronoi face between v and u has a gap if it reaches farther from them than rho e. Where
// in the face a point goes must depend on what is near alone: else an edit moves points far
// away, and views of different reach disagree. So all is decided within a *cap*, the distance c
// from both ends:
//   1. of 8, then 16, then 32 fixed directions in the plane between v and u, those whose place
//      at distance c lies in the face; of them the one farthest from the face's border, as far
//      as that matters (kEnough), else the first;
//   2. if there is none: a corner of the face between rho e and c away, or where an edge of the
//      face leaves the ball of radius c; the farthest, the least of equally far ones.
// If there is neither, shorter edges have the same gap, or it is outside of the domain.
//
//   v, u    the ends: v is the one whose star is known, the edge's owner
//   e       their distance       c       the cap, kCap rho e
// Immutable once made; thread-safe.
#ifndef DYNMESH_CORE_MESHING_SPACE_RULES_H_
#define DYNMESH_CORE_MESHING_SPACE_RULES_H_

#include <array>
#include <optional>

#include "core/meshing/rules.h"
#include "core/meshing/space_star.h"

namespace dynmesh::meshing {

class SpaceRules : public CommonRules<3> {
 public:
  explicit SpaceRules(const MeshOptions& options)
      : CommonRules(options, kCap * options.quality + kEnough) {}

  // The place for a point in the gap of the edge from the star's vertex to its neighbour in
  // `slot`, no ghost. Nothing if there is no gap or no place for it. A function of the four
  // vertices of each corner within reach, to the bit. O(degree of the neighbour in the link).
  std::optional<geometry::Point3> PointInGap(const SpaceStar& star, int slot) const;

  // Is a place at squared distance r2 from the star's vertex one that every view knows in which
  // an edge of squared length e2 is judged?
  bool IsWithinCap(double r2, double e2) const {
    return r2 <= (kCap * quality()) * (kCap * quality()) * e2;
  }

 private:
  static constexpr double kCap = 1.1;
  // How far from the face's border a place need be at most, in units of e.
  static constexpr double kEnough = 0.05;

  class Face;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SPACE_RULES_H_
