// Which gap an edge of the star has, in space: all around it is its Voronoi face.
#ifndef DYNMESH_CORE_MESHING_SPACE_GAPS_H_
#define DYNMESH_CORE_MESHING_SPACE_GAPS_H_

#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

// Looks at a Refinement `R`. Cheap to make.
template <class R>
class SpaceGaps {
 public:
  using Candidate = typename R::Candidate;

  explicit SpaceGaps(const R& refinement) : r_(refinement) {}

  // Has the edge to the neighbour in slot i a gap that a point may be put into?
  bool OfNeighbour(int i, Candidate* gap) const {
    const auto& u = r_.star_[i];
    if (r_.IsSkipped(u.p, false)) return false;
    const auto x = r_.rules_.PointInGap(r_.star_, i);
    if (!x) return false;
    gap->e2 = u.d2;
    gap->neighbour = u.p;
    gap->left = false;
    gap->x = *x;
    return true;
  }

 private:
  const R& r_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SPACE_GAPS_H_
