// How an operation keeps the star that it has read, among its words.
//
// In the plane: the neighbours in a ring, counter-clockwise. In space: the neighbours in any
// order, then the link's triangles, three places in that list to a word with the highest bit
// set. Vertices stay below 2^31, ghosts are above all triangles.
#ifndef DYNMESH_CORE_MESHING_STAR_READS_H_
#define DYNMESH_CORE_MESHING_STAR_READS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/meshing/star.h"

namespace dynmesh::meshing {

inline bool IsVertexWord(std::uint32_t word) { return word >> 31 == 0; }

// Calls read(word) for each word.
template <class Read>
void WriteStar(const PlanarStar& star, Read read) {
  star.ForEachNeighbour([&](const auto& u) { read(u.id); });
}
template <class Read>
void WriteStar(const SpaceStar& star, Read read);

// The neighbours alone, ghosts included.
template <int D>
std::span<const std::uint32_t> NeighboursIn(std::span<const std::uint32_t> words);

// Calls f(ids) for each corner of the star, in its orientation, until f says false.
// False if it did, or if the corners were not kept.
template <int D, class F>
bool ForEachCornerIn(std::span<const std::uint32_t> words, F f);

// --- Implementation ---------------------------------------------------------------------

namespace internal {

inline constexpr int kPlaceBits = 10;
inline constexpr std::uint32_t kPlaceMask = (1u << kPlaceBits) - 1;

inline bool IsTriangleWord(std::uint32_t word) {
  return !IsVertexWord(word) && !SpaceStar::IsGhost(word);
}

}  // namespace internal

template <class Read>
void WriteStar(const SpaceStar& star, Read read) {
  // Few have more neighbours than a handful; their triangles are not kept.
  std::array<std::uint32_t, 1u << internal::kPlaceBits> place_of_slot;
  std::uint32_t count = 0;
  for (int slot = 0; slot < star.slot_count(); ++slot) {
    if (!SpaceStar::IsUsed(star[slot])) continue;
    if (static_cast<std::size_t>(slot) < place_of_slot.size()) place_of_slot[slot] = count;
    ++count;
    read(star[slot].id);
  }
  if (static_cast<std::size_t>(star.slot_count()) > place_of_slot.size()) return;
  for (const SpaceStar::Corner& c : star.corners()) {
    std::uint32_t word = 1u << 31;
    for (int k = 0; k < 3; ++k) word |= place_of_slot[c.n[k]] << (k * internal::kPlaceBits);
    read(word);
  }
}

template <>
inline std::span<const std::uint32_t> NeighboursIn<2>(std::span<const std::uint32_t> words) {
  return words;
}
template <>
inline std::span<const std::uint32_t> NeighboursIn<3>(std::span<const std::uint32_t> words) {
  std::size_t count = 0;
  while (count < words.size() && !internal::IsTriangleWord(words[count])) ++count;
  return words.first(count);
}

template <int D, class F>
bool ForEachCornerIn(std::span<const std::uint32_t> words, F f) {
  if constexpr (D == 2) {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (!f(std::array{words[i], words[i + 1 == words.size() ? 0 : i + 1]})) return false;
    }
    return !words.empty();
  } else {
    const std::size_t count = NeighboursIn<3>(words).size();
    for (std::size_t i = count; i < words.size(); ++i) {
      std::array<std::uint32_t, 3> ids;
      for (int k = 0; k < 3; ++k) {
        ids[k] = words[words[i] >> (k * internal::kPlaceBits) & internal::kPlaceMask];
      }
      if (!f(ids)) return false;
    }
    return count < words.size();
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_STAR_READS_H_
