// Cuts closed chains of edges into rings that visit no vertex twice. The inside by the even-odd
// rule depends on the edges only, not on the cuts.
//
// Pure, thread-safe. Expected O(edges).
#ifndef DYNMESH_CORE_BASE_RING_WALK_H_
#define DYNMESH_CORE_BASE_RING_WALK_H_

#include <cstddef>
#include <optional>
#include <vector>

#include "absl/container/flat_hash_map.h"

namespace dynmesh {

// Walks from `start`. `step(v)` removes an edge that leaves v and returns its end, or nothing if
// there is none. Whenever the walk reaches a vertex again it has closed a ring: appends it, in the
// order walked. REQUIRES: each vertex has as many incoming as outgoing edges.
template <class Vertex, class Step>
void WalkRings(Vertex start, Step step, std::vector<std::vector<Vertex>>& rings) {
  std::vector<Vertex> path = {start};
  absl::flat_hash_map<Vertex, std::size_t> at = {{start, 0}};
  while (const std::optional<Vertex> next = step(path.back())) {
    const auto [it, fresh] = at.emplace(*next, path.size());
    if (fresh) {
      path.push_back(*next);
      continue;
    }
    const std::size_t first = it->second;
    rings.emplace_back(path.begin() + static_cast<std::ptrdiff_t>(first), path.end());
    for (; path.size() > first + 1; path.pop_back()) at.erase(path.back());
  }
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_RING_WALK_H_
