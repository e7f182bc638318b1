#include "core/mesh_data/face_links.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/base/large_vector.h"

namespace dynmesh::mesh_data {
namespace {

inline std::array<Slot, 3> FaceOf(const Slot* corners, std::size_t width, std::size_t k) {
  std::array<Slot, 3> face = {kNoSlot, kNoSlot, kNoSlot};
  std::size_t count = 0;
  for (std::size_t j = 0; j < width; ++j) {
    if (j != k) face[count++] = corners[j];
  }
  const auto order = [&](std::size_t a, std::size_t b) {
    if (face[b] < face[a]) std::swap(face[a], face[b]);
  };
  order(0, 1);
  if (count == 3) order(1, 2), order(0, 1);
  return face;
}

std::size_t At(Slot slot) { return static_cast<std::size_t>(slot); }

template <class Face>
void LinkPair(const Face& a, const Face& b, Slot* neighbours, std::size_t width) {
  neighbours[At(a.simplex) * width + a.side] = b.simplex;
  neighbours[At(b.simplex) * width + b.side] = a.simplex;
}

// Links pairs of equal adjacent faces.
template <class Face>
void LinkSorted(std::span<const Face> faces, Slot* neighbours, std::size_t width) {
  for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
    const Face &a = faces[i], &b = faces[i + 1];
    if (a.corners != b.corners || a.simplex == b.simplex) continue;
    LinkPair(a, b, neighbours, width);
    ++i;
  }
}

}  // namespace

void FaceLinks::Add(const Slot* corners, std::size_t width, std::size_t k, Slot simplex,
                    std::size_t side) {
  faces_.push_back({FaceOf(corners, width, k), simplex, static_cast<std::uint32_t>(side)});
}

void FaceLinks::Link(Slot* neighbours, std::size_t width) {
  // A hash table with open addressing. Entries of faces with both simplices are skipped.
  constexpr std::uint32_t kNone = ~std::uint32_t{0}, kBoth = kNone - 1;
  std::vector<std::uint32_t> table(std::bit_ceil(2 * faces_.size() + 1), kNone);
  const std::size_t mask = table.size() - 1;
  const auto hash = [](const std::array<Slot, 3>& face) {
    std::uint64_t h = 0;
    for (const Slot slot : face) {
      h = (h ^ static_cast<std::uint32_t>(slot)) * 0x9e3779b97f4a7c15;
      h ^= h >> 32;
    }
    return static_cast<std::size_t>(h);
  };
  for (std::uint32_t i = 0; i < faces_.size(); ++i) {
    const Face& face = faces_[i];
    std::size_t at = hash(face.corners) & mask;
    while (table[at] != kNone && (table[at] == kBoth || faces_[table[at]].corners != face.corners ||
                                  faces_[table[at]].simplex == face.simplex)) {
      at = (at + 1) & mask;
    }
    if (table[at] == kNone) {
      table[at] = i;
    } else {
      LinkPair(faces_[table[at]], face, neighbours, width);
      table[at] = kBoth;
    }
  }
}

void LinkAllFaces(std::span<const Slot> cells, std::size_t width, std::size_t vertex_count,
                  Slot* neighbours) {
  struct Face {
    std::uint64_t corners;  // all but the least, which is the row
    Slot simplex;
    std::uint32_t side;
  };
  const std::size_t rows = cells.size() / width;
  LargeVector<std::size_t> ends(vertex_count + 1, 0);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t k = 0; k < width; ++k) {
      ++ends[At(FaceOf(&cells[row * width], width, k)[0]) + 1];
    }
  }
  for (std::size_t v = 0; v < vertex_count; ++v) ends[v + 1] += ends[v];
  LargeVector<std::size_t> place = ends;
  LargeVector<Face> faces(rows * width);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t k = 0; k < width; ++k) {
      const std::array<Slot, 3> face = FaceOf(&cells[row * width], width, k);
      const auto high = static_cast<std::uint32_t>(face[1]),
                 low = static_cast<std::uint32_t>(face[2]);
      faces[place[At(face[0])]++] = {std::uint64_t{high} << 32 | low, static_cast<Slot>(row),
                                     static_cast<std::uint32_t>(k)};
    }
  }
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const std::span<Face> of_vertex(faces.data() + ends[v], ends[v + 1] - ends[v]);
    std::sort(of_vertex.begin(), of_vertex.end(), [](const Face& a, const Face& b) {
      if (a.corners != b.corners) return a.corners < b.corners;
      return a.simplex != b.simplex ? a.simplex < b.simplex : a.side < b.side;
    });
    LinkSorted(std::span<const Face>(of_vertex), neighbours, width);
  }
}

}  // namespace dynmesh::mesh_data
