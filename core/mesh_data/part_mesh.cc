// The part as a mesh of its own.
#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh_data/constraints.h"
#include "core/mesh_data/part_state.h"

namespace dynmesh {

using part_state::At;
using part_state::kNone;

namespace {

// The least id first, then the least of the others: turned only, not mirrored.
void TurnToLeast(std::span<VertexId> row) {
  if (row.size() == 3) {
    std::rotate(row.begin(), std::min_element(row.begin(), row.end()), row.end());
    return;
  }
  const auto least = std::min_element(row.begin(), row.end()) - row.begin();
  if (least != 0) {  // two exchanges
    std::swap(row[0], row[static_cast<std::size_t>(least)]);
    const std::size_t a = least == 1 ? 2 : 1, b = least == 3 ? 2 : 3;
    std::swap(row[a], row[b]);
  }
  std::rotate(row.begin() + 1, std::min_element(row.begin() + 1, row.end()), row.end());
}

}  // namespace

// Ids of the part's vertices: the mesh's, and new ones of further copies. A function of the mesh
// and what is opened.
class MeshPart::State::Opener {
 public:
  Opener(const State& part, const SlotMesh& mesh, const Mesh& whole)
      : part_(part), ids_(part.vertex_slots.size()) {
    absl::flat_hash_set<VertexId> used(whole.vertices.ids.begin(), whole.vertices.ids.end());
    const auto least = LeastCells(mesh);
    for (std::size_t number = 0; number < ids_.size(); ++number) {
      const VertexId first = mesh.ids()[At(part.vertex_slots[number])];
      ids_[number] = first;
      if (part.origin[number] != static_cast<std::int32_t>(number)) continue;
      std::vector<std::pair<CellKey, std::int32_t>> copies;
      for (auto copy = static_cast<std::int32_t>(number); copy != kNone;
           copy = part.next_copy[At(copy)]) {
        copies.push_back({least[At(copy)], copy});
      }
      if (copies.size() > 1) with_copies_.push_back(std::move(copies));
    }
    // In the order of ids, too: each new id is the next free one.
    std::sort(with_copies_.begin(), with_copies_.end(), [&](const auto& x, const auto& y) {
      return ids_[At(x[0].second)] < ids_[At(y[0].second)];
    });
    for (auto& copies : with_copies_) {
      std::sort(copies.begin(), copies.end());
      const VertexId first = ids_[At(copies[0].second)];
      VertexId id = first;
      for (std::size_t i = 1; i < copies.size(); ++i) {
        while (id == 0 || used.contains(id)) ++id;
        used.insert(id);
        copies_[first].push_back(id);
        ids_[At(copies[i].second)] = id;
      }
    }
  }

  // `mesh` is the part with one vertex in a place.
  void Open(Mesh& mesh) const {
    AddVertices(mesh.vertices, static_cast<std::size_t>(mesh.dimension));
    const std::size_t width = part_.width();
    mesh.simplices.clear(), mesh.regions.clear();
    for (std::size_t cell = 0; cell < part_.cell_slots.size(); ++cell) {
      for (std::size_t k = 0; k < width; ++k) {
        mesh.simplices.push_back(ids_[At(part_.cells[cell * width + k])]);
      }
      TurnToLeast(std::span(mesh.simplices).last(width));
      mesh.regions.push_back(part_.cell_regions[cell]);
    }
    mesh.subsegments = Opened<2>(mesh.simplices, width, mesh.subsegments);
    mesh.subfacets = Opened<3>(mesh.simplices, width, mesh.subfacets);
    mesh.hash = ComputeHash(mesh);
  }

 private:
  using CellKey = std::array<VertexId, 4>;  // the mesh's ids, ascending

  // Of each vertex of the part the least of its cells: copies are told apart by it, whatever their
  // numbers.
  std::vector<CellKey> LeastCells(const SlotMesh& mesh) const {
    CellKey none;
    none.fill(~VertexId{0});
    std::vector<CellKey> least(part_.vertex_slots.size(), none);
    const std::size_t width = part_.width();
    for (std::size_t cell = 0; cell < part_.cell_slots.size(); ++cell) {
      const std::int32_t* const corners = &part_.cells.data()[cell * width];
      CellKey key{};
      for (std::size_t k = 0; k < width; ++k) {
        key[k] = mesh.ids()[At(part_.vertex_slots[At(corners[k])])];
      }
      std::sort(key.begin(), key.end());  // in 2D one is 0
      for (std::size_t k = 0; k < width; ++k) {
        least[At(corners[k])] = std::min(least[At(corners[k])], key);
      }
    }
    return least;
  }

  void AddVertices(VertexColumns& vertices, std::size_t dimension) const {
    for (std::size_t row = 0, rows = vertices.size(); row < rows; ++row) {
      const auto copies = copies_.find(vertices.ids[row]);
      if (copies == copies_.end()) continue;
      for (const VertexId copy : copies->second) {
        vertices.ids.push_back(copy);
        for (std::size_t k = 0; k < dimension; ++k) {
          vertices.coordinates.push_back(vertices.coordinates[row * dimension + k]);
        }
        vertices.containing_dimensions.push_back(vertices.containing_dimensions[row]);
        vertices.owners.push_back(vertices.owners[row]);
      }
    }
  }

  // The rows with all copies of their vertices that are corners of one simplex.
  template <std::size_t kIds, class Columns>
  Columns Opened(const std::vector<VertexId>& simplices, std::size_t width,
                 const Columns& columns) const {
    using Ids = std::array<VertexId, kIds>;
    absl::flat_hash_map<VertexId, VertexId> first_of;  // of copies
    for (const auto& [first, copies] : copies_) {
      first_of[first] = first;
      for (const VertexId copy : copies) first_of[copy] = first;
    }
    // By first copies: the rows of simplices with some vertex that has copies.
    absl::flat_hash_map<Ids, absl::flat_hash_set<Ids>> rows;
    for (std::size_t at = 0; at < simplices.size(); at += width) {
      for (std::uint32_t choice = 0; choice < 1U << width; ++choice) {
        if (static_cast<std::size_t>(std::popcount(choice)) != kIds) continue;
        Ids own, first;
        bool has_copies = false;
        std::size_t i = 0;
        for (std::size_t k = 0; k < width; ++k) {
          if ((choice >> k & 1) == 0) continue;
          const auto found = first_of.find(simplices[at + k]);
          has_copies |= found != first_of.end();
          own[i] = simplices[at + k];
          first[i] = found == first_of.end() ? own[i] : found->second;
          ++i;
        }
        if (!has_copies) continue;
        std::sort(own.begin(), own.end()), std::sort(first.begin(), first.end());
        rows[first].insert(own);
      }
    }
    Columns result;
    for (std::size_t row = 0; row < columns.size(); ++row) {
      auto key = mesh_data::KeyOf(columns, row);
      Ids ids;
      std::copy_n(key.begin(), kIds, ids.begin());
      const auto found = rows.find(ids);
      if (found == rows.end()) {
        mesh_data::Append(result, key);
        continue;
      }
      std::vector<Ids> all(found->second.begin(), found->second.end());
      std::sort(all.begin(), all.end());
      for (const Ids& each : all) {
        std::copy(each.begin(), each.end(), key.begin());
        mesh_data::Append(result, key);
      }
    }
    return result;
  }

  const State& part_;
  std::vector<std::vector<std::pair<CellKey, std::int32_t>>> with_copies_;
  std::vector<VertexId> ids_;                                    // by number
  absl::flat_hash_map<VertexId, std::vector<VertexId>> copies_;  // the further ones
};

absl::StatusOr<Mesh> MeshPart::ToMesh(const SlotMesh& mesh) const {
  if (absl::Status s = state_->CheckIsAt(mesh); !s.ok()) return s;
  const Mesh whole = mesh.ToMesh();
  if (state_->IsEmptyChoice()) {
    return mesh_data::OnlyRows(whole, std::vector<bool>(whole.simplex_count()));
  }
  Mesh part = mesh_data::OnlyInside(whole, state_->regions);
  if (state_->HasSeams()) State::Opener(*state_, mesh, whole).Open(part);
  return part;
}

}  // namespace dynmesh
