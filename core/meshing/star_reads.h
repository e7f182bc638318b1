// How an operation encodes the star that it read in its words.
//
// 2D: the neighbours in a ring, counter-clockwise. 3D: the neighbours in any order, then the link's
// triangles, one word each: three indices into that list, and the highest bit set. Vertices are
// below 2^31, ghosts above all triangles.
#ifndef DYNMESH_CORE_MESHING_STAR_READS_H_
#define DYNMESH_CORE_MESHING_STAR_READS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/delaunay/vertex_link.h"
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
// The star with this link. REQUIRES: the link is closed, with less than 2^10 neighbours.
template <class Read>
void WriteStar(const delaunay::VertexLink& link, Read read);

// The neighbours alone, ghosts included.
template <int D>
std::span<const std::uint32_t> NeighboursIn(std::span<const std::uint32_t> words);

// Calls f(ids) for each corner of the star, in its orientation, until f returns false. Returns
// false if it did, or if the corners were not kept.
template <int D, class F>
bool ForEachCornerIn(std::span<const std::uint32_t> words, F f);

// 3D: the words of the corners; none if they were not kept.
inline std::span<const std::uint32_t> TrianglesIn(std::span<const std::uint32_t> words);
// The three neighbours of a triangle, as indices into the list.
inline std::array<int, 3> IndicesIn(std::uint32_t triangle_word);

// --- Implementation ---------------------------------------------------------------------

namespace internal {

inline constexpr int kIndexBits = 10;
inline constexpr std::uint32_t kIndexMask = (1u << kIndexBits) - 1;

inline bool IsTriangleWord(std::uint32_t word) {
  return !IsVertexWord(word) && !SpaceStar::IsGhost(word);
}
// a, b, c: indices of the corners in the list.
inline std::uint32_t TriangleWord(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return 1u << 31 | a | b << kIndexBits | c << (2 * kIndexBits);
}

}  // namespace internal

template <class Read>
void WriteStar(const SpaceStar& star, Read read) {
  // Most stars have only a handful of neighbours. Of larger ones the triangles are not kept.
  std::array<std::uint32_t, 1u << internal::kIndexBits> index_of_slot;
  std::uint32_t count = 0;
  for (int slot = 0; slot < star.slot_count(); ++slot) {
    if (!SpaceStar::IsUsed(star[slot])) continue;
    if (static_cast<std::size_t>(slot) < index_of_slot.size()) index_of_slot[slot] = count;
    ++count;
    read(star[slot].id);
  }
  if (static_cast<std::size_t>(star.slot_count()) > index_of_slot.size()) return;
  for (const SpaceStar::Corner& c : star.corners()) {
    read(internal::TriangleWord(index_of_slot[c.n[0]], index_of_slot[c.n[1]],
                                index_of_slot[c.n[2]]));
  }
}
template <class Read>
void WriteStar(const delaunay::VertexLink& link, Read read) {
  for (const std::uint32_t u : link.neighbours) read(u);
  for (const auto& [a, b, c] : link.triangles) {
    read(internal::TriangleWord(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                                static_cast<std::uint32_t>(c)));
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

inline std::span<const std::uint32_t> TrianglesIn(std::span<const std::uint32_t> words) {
  return words.subspan(NeighboursIn<3>(words).size());
}
inline std::array<int, 3> IndicesIn(std::uint32_t triangle_word) {
  std::array<int, 3> indices;
  for (int k = 0; k < 3; ++k) {
    indices[k] =
        static_cast<int>(triangle_word >> (k * internal::kIndexBits) & internal::kIndexMask);
  }
  return indices;
}

template <int D, class F>
bool ForEachCornerIn(std::span<const std::uint32_t> words, F f) {
  if constexpr (D == 2) {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (!f(std::array{words[i], words[i + 1 == words.size() ? 0 : i + 1]})) return false;
    }
    return !words.empty();
  } else {
    const auto triangles = TrianglesIn(words);
    for (const std::uint32_t triangle : triangles) {
      const auto [a, b, c] = IndicesIn(triangle);
      if (!f(std::array{words[a], words[b], words[c]})) return false;
    }
    return !triangles.empty();
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_STAR_READS_H_
