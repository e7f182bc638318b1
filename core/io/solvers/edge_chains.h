// Edges as chains: what files list that have boundaries as strings of vertices. 2D.
#ifndef DYNMESH_CORE_IO_SOLVERS_EDGE_CHAINS_H_
#define DYNMESH_CORE_IO_SOLVERS_EDGE_CHAINS_H_

#include <cstdint>
#include <utility>
#include <vector>

namespace dynmesh::io {

using DirectedEdge = std::pair<std::uint32_t, std::uint32_t>;
using Chain = std::vector<std::uint32_t>;  // vertices; a closed one ends where it begins

// Distinct edges as few chains: a chain ends at vertices that have one edge or more than two. Where
// the edges of a chain go round in one direction, it has that; else that of its first edge. First
// chains with ends, then closed ones, both by their first edge. O(n) expected.
std::vector<Chain> ChainsOf(const std::vector<DirectedEdge>& edges);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SOLVERS_EDGE_CHAINS_H_
