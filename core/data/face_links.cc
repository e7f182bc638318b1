#include "core/data/face_links.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace dynmesh::data {
namespace {

std::array<Slot, 3> FaceOf(const Slot* corners, std::size_t width, std::size_t k) {
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

// Of faces that follow each other and are equal, two.
template <class Face>
void LinkSorted(std::span<const Face> faces, Slot* neighbours, std::size_t width) {
  for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
    const Face &a = faces[i], &b = faces[i + 1];
    if (a.corners != b.corners || a.simplex == b.simplex) continue;
    neighbours[At(a.simplex) * width + a.side] = b.simplex;
    neighbours[At(b.simplex) * width + b.side] = a.simplex;
    ++i;
  }
}

}  // namespace

void FaceLinks::Add(const Slot* corners, std::size_t width, std::size_t k, Slot simplex,
                    std::size_t side) {
  faces_.push_back({FaceOf(corners, width, k), simplex, static_cast<std::uint32_t>(side)});
}

void FaceLinks::Link(Slot* neighbours, std::size_t width) {
  std::sort(faces_.begin(), faces_.end(), [](const Face& a, const Face& b) {
    return std::tie(a.corners, a.simplex, a.side) < std::tie(b.corners, b.simplex, b.side);
  });
  LinkSorted(std::span<const Face>(faces_), neighbours, width);
}

void LinkAllFaces(std::span<const Slot> cells, std::size_t width, std::size_t vertex_count,
                  Slot* neighbours) {
  struct Face {
    std::array<Slot, 2> corners;  // without the least, by which they lie in rows
    Slot simplex;
    std::uint32_t side;
  };
  const auto least_of = [&](std::size_t row, std::size_t k) {
    return At(FaceOf(&cells[row * width], width, k)[0]);
  };
  const std::size_t rows = cells.size() / width;
  std::vector<std::size_t> ends(vertex_count + 1, 0);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t k = 0; k < width; ++k) ++ends[least_of(row, k) + 1];
  }
  for (std::size_t v = 0; v < vertex_count; ++v) ends[v + 1] += ends[v];
  std::vector<std::size_t> place(ends.begin(), ends.end() - 1);
  std::vector<Face> faces(rows * width);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t k = 0; k < width; ++k) {
      const std::array<Slot, 3> face = FaceOf(&cells[row * width], width, k);
      faces[place[At(face[0])]++] = {
          {face[1], face[2]}, static_cast<Slot>(row), static_cast<std::uint32_t>(k)};
    }
  }
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const std::span<Face> of_vertex(faces.data() + ends[v], ends[v + 1] - ends[v]);
    std::sort(of_vertex.begin(), of_vertex.end(), [](const Face& a, const Face& b) {
      return std::tie(a.corners, a.simplex, a.side) < std::tie(b.corners, b.simplex, b.side);
    });
    LinkSorted(std::span<const Face>(of_vertex), neighbours, width);
  }
}

}  // namespace dynmesh::data
