// Finds candidate intersections with an implicit quadtree over the input's box: a cell passes its
// content on to its four quarters until it has few. So neither long diagonal segments nor dense
// spots of a large map produce many pairs. Pure, thread-safe.
#ifndef DYNMESH_CLIENT_CLEANING_MEETING_SEARCH_H_
#define DYNMESH_CLIENT_CLEANING_MEETING_SEARCH_H_

#include <cstdint>

#include "absl/functional/function_ref.h"
#include "client/cleaning/line_graph.h"

namespace dynmesh::cleaning {

using EdgeIndex = std::uint32_t;

// Visits a superset of all pairs of an edge and a node that are less than `reach` apart and of
// which one has born >= `since`, each pair once.
void VisitNodesNearEdges(const LineGraph& graph, double reach, int since,
                         absl::FunctionRef<void(EdgeIndex, Node)> visit);

// Visits a superset of all pairs of intersecting edges of which one has born >= `since`; some pairs
// several times, lower index first. Ends early when `visit` returns false.
void VisitEdgesThatMeet(const LineGraph& graph, int since,
                        absl::FunctionRef<bool(EdgeIndex, EdgeIndex)> visit);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_MEETING_SEARCH_H_
