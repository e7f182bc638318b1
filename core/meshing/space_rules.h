// The gap of an edge in 3D, and its Steiner point.
//
// The Voronoi face between v and u has a gap if it reaches farther from them than rho e. The
// position of the point must depend on near vertices alone: else an edit moves points far away, and
// views of different reach disagree. So everything is decided within a *cap*, the distance c from
// both ends:
//   1. Of 8, then 16, then 32 fixed directions in the plane between v and u: those with their
//      point at distance c in the face. Of them the one farthest from the face's border, where
//      distances above kEnough count as equal; the first one of several.
//   2. If there is none: a corner of the face between rho e and c away, or a point where an edge of
//      the face leaves the ball of radius c. Of them the farthest; of several the least.
// If there is neither, shorter edges have the same gap, or it is outside of the domain.
//
//   v, u    the ends: v is the owner of the edge, and its star is known
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

  // The Steiner point for the gap of the edge from the star's vertex to its neighbour in `slot`,
  // which must not be a ghost. Nothing if there is no gap or no point for it. A function of the
  // four vertices of each corner within reach, to the bit. O(degree of the neighbour in the link).
  std::optional<geometry::Point3> PointInGap(const SpaceStar& star, int slot) const;

  // True if every view that judges an edge of squared length e2 knows the points at squared
  // distance r2 from the star's vertex.
  bool IsWithinCap(double r2, double e2) const {
    return r2 <= (kCap * quality()) * (kCap * quality()) * e2;
  }

 private:
  static constexpr double kCap = 1.1;
  // Distances from the face's border above this one count as equal, in units of e.
  static constexpr double kEnough = 0.05;

  class Face;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SPACE_RULES_H_
