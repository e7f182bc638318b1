#include "core/transfer/nodal_patch.h"

#include <algorithm>
#include <bit>

namespace dynmesh::transfer {
namespace {

// The walk prefetches so many simplices ahead.
constexpr std::size_t kAhead = 6;

// The data that the walk reads at `slot`: the rows of its neighbours.
template <std::size_t D>
void Prefetch(const Slot* cells, const Slot* neighbours, Slot slot) {
  const Slot* const row = neighbours + At(slot) * (D + 1);
  for (std::size_t k = 0; k <= D; ++k) {
    if (row[k] == kNoSlot) continue;
    __builtin_prefetch(cells + At(row[k]) * (D + 1));
    __builtin_prefetch(neighbours + At(row[k]) * (D + 1));
  }
}

}  // namespace

template <std::size_t D>
NodalPatch<D>::NodalPatch(const SlotMesh& mesh, const Overlay<D>& overlay, int rings) {
  struct Origin {
    Slot slot;
    std::uint32_t open;  // bits of faces beyond which no simplex was added yet
  };
  constexpr std::uint32_t kAllFaces = (1U << (D + 1)) - 1;
  std::vector<Origin> origins;  // of `cells`
  // About as many cells and vertices as in a mesh of points.
  const std::size_t expected = overlay.to.size() * (rings == 0 ? 1 : D == 2 ? 4 : 8);
  SlotIndex seen(4 * expected);
  indices = SlotIndex(expected);
  cells.reserve(4 * expected), origins.reserve(4 * expected);
  const bool has_regions = mesh.has_regions();
  const Slot* const all_cells = mesh.cells().data();
  const Slot* const all_neighbours = mesh.neighbours().data();
  const auto index_of = [&](Slot vertex) {
    const auto [number, is_new] = indices.Add(vertex);
    if (is_new) vertices.push_back(vertex);
    return number;
  };
  for (const auto& simplex : overlay.to) {
    Cell cell;
    for (std::size_t k = 0; k <= D; ++k) cell.corners[k] = index_of(simplex.vertices[k]);
    cell.measure = simplex.measure, cell.region = simplex.region;
    seen.Add(simplex.slot);
    cells.push_back(cell), origins.push_back({simplex.slot, kAllFaces});
  }
  cavity_count = vertices.size();
  // The simplices around a vertex are connected by faces with that vertex.
  for (int ring = 0; ring <= rings; ++ring) {
    free_count = vertices.size();
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (c + kAhead < cells.size())
        Prefetch<D>(all_cells, all_neighbours, origins[c + kAhead].slot);
      std::uint32_t free = 0;  // bits of corners
      for (std::size_t k = 0; k <= D; ++k) {
        free |= std::uint32_t{cells[c].corners[k] < free_count} << k;
      }
      // Faces with a free corner: all, except the one opposite to the only free corner.
      std::uint32_t faces = free == 0 ? 0 : origins[c].open;
      if ((free & (free - 1)) == 0) faces &= ~free;  // std::has_single_bit calls a library
      origins[c].open &= ~faces;
      for (; faces != 0; faces &= faces - 1) {
        const auto k = static_cast<std::size_t>(std::countr_zero(faces));
        const Slot other = all_neighbours[At(origins[c].slot) * (D + 1) + k];
        if (other == kNoSlot || !seen.Add(other).second) continue;
        // Its corners are those of the face and one more.
        const Slot* row = all_cells + At(other) * (D + 1);
        const Slot* own = all_cells + At(origins[c].slot) * (D + 1);
        Cell cell;
        std::uint32_t open = kAllFaces;
        for (std::size_t i = 0; i <= D; ++i) {
          const auto shared = static_cast<std::size_t>(std::find(own, own + D + 1, row[i]) - own);
          if (shared <= D) {
            cell.corners[i] = cells[c].corners[shared];
          } else {
            cell.corners[i] = index_of(row[i]), open = kAllFaces & ~(1U << i);
          }
        }
        cell.measure = 0;
        cell.region = has_regions ? mesh.regions()[At(other)] : kNoRegion;
        cells.push_back(cell), origins.push_back({other, open});
      }
    }
  }
  Measure(mesh, overlay.to.size());
  lumped.assign(free_count, 0);
  for (const Cell& cell : cells) {
    for (const std::uint32_t corner : cell.corners) {
      if (corner < free_count) lumped[corner] += cell.measure / static_cast<double>(D + 1);
    }
  }
}

// For cells from `first` on: reads each vertex once.
template <std::size_t D>
void NodalPatch<D>::Measure(const SlotMesh& mesh, std::size_t first) {
  std::vector<Vec<D>> positions(vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    std::copy_n(mesh.points().data() + At(vertices[v]) * D, D, positions[v].begin());
  }
  for (std::size_t c = first; c < cells.size(); ++c) {
    Corners<D> corners;
    for (std::size_t k = 0; k <= D; ++k) corners[k] = positions[cells[c].corners[k]];
    cells[c].measure = transfer::Measure<D>(corners);
  }
}

template struct NodalPatch<2>;
template struct NodalPatch<3>;

}  // namespace dynmesh::transfer
