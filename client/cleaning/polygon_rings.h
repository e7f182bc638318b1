// Rings of a polygon from its remaining edges, after corners were merged, edges became chains, and
// doubly used edges were removed. In closed chains, the edges with odd count have even degree at
// each node, so they can always be cut into rings. The even-odd inside is a function of the edges,
// however they are cut.
//
// Pure, thread-safe. O(n lg n) for n edges.
#ifndef DYNMESH_CLIENT_CLEANING_POLYGON_RINGS_H_
#define DYNMESH_CLIENT_CLEANING_POLYGON_RINGS_H_

#include <utility>
#include <vector>

#include "client/cleaning/node_table.h"

namespace dynmesh::cleaning {

using NodeRing = std::vector<Node>;

struct RemadeRings {
  // In the order of the rings that they come from. A ring with all its edges left is unchanged.
  std::vector<NodeRing> rings;
  std::vector<Node> cuts;  // nodes that changed rings pass twice
};

// `edges` must be sorted and unique; `were`: the old closed chains. Their corners may no longer be
// on edges.
RemadeRings RemakeRings(const std::vector<NodeRing>& were, const std::vector<NodePair>& edges);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_POLYGON_RINGS_H_
