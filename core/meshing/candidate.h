// A gap of an edge, or a missing part of a facet, and the point to insert there.
#ifndef DYNMESH_CORE_MESHING_CANDIDATE_H_
#define DYNMESH_CORE_MESHING_CANDIDATE_H_

#include <vector>

#include "core/meshing/elements.h"

namespace dynmesh::meshing {

// Made by a criterion (a gap; FacetWork::MoveToFacet may then move x) or by FacetWork::FindPoint
// (a point that a facet needs).
template <int D>
struct Candidate {
  // Squared. Of a gap: the edge's length. On a facet: at most the distance from x to its nearest
  // neighbour. Decides the bucket of x.
  double e2 = 0;
  // With `left`, what SkippedGaps knows it by. Of a gap: the edge's other end. Of a facet's point:
  // x before it is moved to a counterpart, a lattice, or out of the way.
  geometry::Point<D> neighbour = {};
  bool left = false;          // 2D gaps: the side of the gap, seen from the lesser end of the edge
  int corner = 0;             // 2D gaps: the star's corner in the gap
  geometry::Point<D> x = {};  // the point to insert
  FeatureSlot facet = kNil;   // 3D: the facet on which x lies
  Origin origin;              // of x, if it is a counterpart or on the lattice of an edge
  bool required = false;      // a facet needs it, it cannot be left out: by FindPoint only
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
