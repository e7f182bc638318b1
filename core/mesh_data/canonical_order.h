// The canonical order of a simplex's corners (dynmesh/mesh.h), by ids or other names. Pure
// functions, thread-safe, O(1).
#ifndef DYNMESH_CORE_MESH_DATA_CANONICAL_ORDER_H_
#define DYNMESH_CORE_MESH_DATA_CANONICAL_ORDER_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace dynmesh::mesh_data {

// The same corners with the least first and, of four, the second least second. Keeps the
// orientation: of three corners it is a rotation, of four an even permutation. So any positively
// oriented order becomes the canonical one. Of equal corners, as in a broken file, the first counts
// as the least.
template <class T>
constexpr std::array<T, 3> InCanonicalOrder(const std::array<T, 3>& corners) {
  // The least is random: no branch.
  const auto& [a, b, c] = corners;
  const std::array<T, 5> twice = {a, b, c, a, b};
  const T less = b < a ? b : a;
  const std::size_t least = c < less ? 2 : b < a ? 1 : 0;
  return {twice[least], twice[least + 1], twice[least + 2]};
}

template <class T>
constexpr std::array<T, 4> InCanonicalOrder(std::array<T, 4> corners) {
  const auto least =
      static_cast<std::size_t>(std::min_element(corners.begin(), corners.end()) - corners.begin());
  if (least != 0) {
    const std::size_t second = least == 1 ? 2 : 1, third = 6 - least - second;
    std::swap(corners[0], corners[least]);
    std::swap(corners[second], corners[third]);  // two swaps are an even permutation
  }
  const auto rest = InCanonicalOrder(std::array<T, 3>{corners[1], corners[2], corners[3]});
  return {corners[0], rest[0], rest[1], rest[2]};
}

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_CANONICAL_ORDER_H_
