// Rings of a polygon from the edges that it has: what is left when corners were merged, edges
// became chains, and what was used twice has gone. Edges that stand an odd number of times
// along closed chains are an even number at each place, so they can always be cut into rings;
// and the even-odd inside is a function of the edges, however that is done.
//
// Pure, thread-safe. O(n lg n) for n edges.
#ifndef DYNMESH_CLIENT_CLEANING_POLYGON_RINGS_H_
#define DYNMESH_CLIENT_CLEANING_POLYGON_RINGS_H_

#include <utility>
#include <vector>

#include "client/cleaning/point_places.h"

namespace dynmesh::cleaning {

using PlaceRing = std::vector<Place>;
using PlacePair = std::pair<Place, Place>;  // first < second

struct RemadeRings {
  // In the order of the rings that they come from. One whose edges are all there is as it was.
  std::vector<PlaceRing> rings;
  std::vector<Place> cuts;  // places through which rings that are not as they were go twice
};

// `edges` sorted, each once; `were` closed chains, whose corners need not be on them any more.
RemadeRings RemakeRings(const std::vector<PlaceRing>& were, const std::vector<PlacePair>& edges);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_POLYGON_RINGS_H_
