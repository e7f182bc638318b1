// Who meets whom? A quadtree over the input's box that is walked, not kept: a cell passes
// what is in it on to its four quarters until it holds few. So neither long diagonal
// segments nor dense corners of a large map make many pairs to look at. Pure, thread-safe.
#ifndef DYNMESH_CLIENT_CLEANING_MEETING_SEARCH_H_
#define DYNMESH_CLIENT_CLEANING_MEETING_SEARCH_H_

#include <cstdint>

#include "absl/functional/function_ref.h"
#include "client/cleaning/line_graph.h"

namespace dynmesh::cleaning {

using EdgeIndex = std::uint32_t;

// Visits at least all pairs of an edge and a place less than `reach` apart of which one
// was born in round `since` or later, each once.
void VisitPlacesNearEdges(const LineGraph& graph, double reach, int since,
                          absl::FunctionRef<void(EdgeIndex, Place)> visit);

// Visits at least all pairs of edges that meet, of which one was born in round `since` or
// later; some of them several times, lower index first. Ends early once `visit` says false.
void VisitEdgesThatMeet(const LineGraph& graph, int since,
                        absl::FunctionRef<bool(EdgeIndex, EdgeIndex)> visit);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_MEETING_SEARCH_H_
