// The sides of simplices, by their vertices. Pure.
#ifndef DYNMESH_CORE_REGIONS_SIDES_H_
#define DYNMESH_CORE_REGIONS_SIDES_H_

#include <algorithm>
#include <array>
#include <cstddef>

namespace dynmesh {

// The side opposite to a corner, its vertices ascending.
template <class Vertex, std::size_t N>
std::array<Vertex, N - 1> SideOpposite(const std::array<Vertex, N>& simplex, int corner) {
  std::array<Vertex, N - 1> side;
  for (std::size_t i = 0, k = 0; i < N; ++i) {
    if (i != static_cast<std::size_t>(corner)) side[k++] = simplex[i];
  }
  std::sort(side.begin(), side.end());
  return side;
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_REGIONS_SIDES_H_
