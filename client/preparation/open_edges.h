// Edges of a surface that have one face: where it has holes and cracks, or is folded to one layer.
//
// Pure, thread-safe. Expected O(n lg n) for n faces.
#ifndef DYNMESH_CLIENT_PREPARATION_OPEN_EDGES_H_
#define DYNMESH_CLIENT_PREPARATION_OPEN_EDGES_H_

#include <cstddef>
#include <vector>

#include "client/cleaning/box3.h"
#include "client/cleaning/node_table.h"
#include "dynmesh/feature.h"

namespace dynmesh::preparation {

struct OpenEdge {
  FeatureId p = kNoFeature, q = kNoFeature;  // p < q
  cleaning::Point3 at_p{}, at_q{};
  cleaning::Box3 box;
};

// Those of the polygons. REQUIRES: their corners are points of `features`.
std::vector<OpenEdge> OpenEdgesOf(const std::vector<Feature>& features);

// Does each open edge have another one near its middle, so that both may become one if either moves
// by the distance? Conservative: may return true needlessly.
bool MayBeClosed(const std::vector<OpenEdge>& open, double distance);

// Where a closed surface is folded onto itself, two faces become one, which encloses nothing. Drops
// those of `doubled` that have an open edge, one after the other, and points without a feature.
// Then no edge is open, if the surface was closed. Returns how many faces.
std::size_t DropFlaps(const std::vector<FeatureId>& doubled, std::vector<Feature>& features);

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_OPEN_EDGES_H_
