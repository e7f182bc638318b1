// The edges of rings: of corners by id, of positions, of anything.
#ifndef DYNMESH_CORE_BASE_RINGS_H_
#define DYNMESH_CORE_BASE_RINGS_H_

#include <cstddef>

namespace dynmesh {

// Calls f(p, q) for each edge of the rings, from each corner to the next and from the last one
// to the first. O(corners).
template <class Rings, class F>
void ForEachEdgeOf(const Rings& rings, F f) {
  for (const auto& ring : rings) {
    for (std::size_t i = 0; i + 1 < ring.size(); ++i) f(ring[i], ring[i + 1]);
    if (!ring.empty()) f(ring.back(), ring.front());
  }
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_RINGS_H_
