// A gap of an edge, or a missing part of a facet, and the point to insert there.
#ifndef DYNMESH_CORE_MESHING_CANDIDATE_H_
#define DYNMESH_CORE_MESHING_CANDIDATE_H_

#include <vector>

#include "core/meshing/elements.h"

namespace dynmesh::meshing {

template <int D>
struct Candidate {
  double e2 = 0;  // squared; at most the distance from the point to its nearest neighbour
  geometry::Point<D> neighbour = {};
  bool left = false;  // 2D: the side of the gap, seen from the lesser end of the edge
  int corner = 0;     // 2D: the star's corner in the gap
  geometry::Point<D> x = {};
  FeatureSlot facet = kNil;  // the facet on which x lies
  Origin origin;             // of x, if it is a counterpart
  bool required = false;     // a facet needs it: it cannot be left out
};

// The gaps that an operation leaves as they are.
template <int D>
class SkippedGaps {
 public:
  void Clear() { gaps_.clear(); }
  void Add(const Candidate<D>& gap) { gaps_.push_back({gap.neighbour, gap.left}); }
  bool Has(const geometry::Point<D>& neighbour, bool left) const {
    for (const Gap& gap : gaps_) {
      if (gap.left == left && gap.neighbour == neighbour) return true;
    }
    return false;
  }

 private:
  struct Gap {
    geometry::Point<D> neighbour;
    bool left;
  };
  std::vector<Gap> gaps_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_CANDIDATE_H_
