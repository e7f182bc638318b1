// The state of a MeshPart. Its functions are in mesh_part.cc (the whole, updates), part_cells.cc
// (vertices and cells), part_facets.cc, part_seams.cc (opened features) and part_sides.cc. Only for
// these files.
//
// Invariants between calls of MeshPart:
//   1. each cell's corners are rows of vertices; `uses` counts them, and none is 0;
//   2. the copies of a vertex are a list: the first is that of vertex_numbers, others follow by
//      next_copy, and origin of each is the first. A vertex of no opened facet has one;
//   3. facet_cells and facet_sides of a row lead to the cells whose cell_facets is the row;
//   4. open_facets are the facets of the whole mesh with an owner in `open`; seam_uses counts them
//      at each of their vertices.
#ifndef DYNMESH_CORE_MESH_DATA_PART_STATE_H_
#define DYNMESH_CORE_MESH_DATA_PART_STATE_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/container/inlined_vector.h"
#include "absl/status/status.h"
#include "core/mesh_data/region_filter.h"
#include "dynmesh/part.h"

namespace dynmesh {
namespace part_state {

inline std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }

inline constexpr std::int32_t kNone = -1;

// The ids of a facet's corners, ascending; in 2D the last one is none.
using FacetKey = std::array<VertexId, 3>;

inline FacetKey KeyOf(const VertexId* ids, std::size_t count) {
  FacetKey key = {ids[0], ids[1], count == 3 ? ids[2] : ~VertexId{0}};
  if (key[1] < key[0]) std::swap(key[0], key[1]);
  if (key[2] < key[1]) std::swap(key[1], key[2]);
  if (key[1] < key[0]) std::swap(key[0], key[1]);
  return key;
}

// A column whose rows are removed by moving the last one.
template <class T>
void MoveLast(SlotColumn<T>& column, std::size_t width, std::size_t row) {
  const std::size_t last = column.size() / width - 1;
  std::copy_n(column.data() + last * width, width, column.data() + row * width);
  column.resize(last * width, T());
}

template <class T>
std::size_t AddRow(SlotColumn<T>& column, std::size_t width, T value) {
  const std::size_t row = column.size() / width;
  column.resize(column.size() + width, value);
  return row;
}

}  // namespace part_state

struct MeshPart::State {
  class Opener;  // part_mesh.cc
  using FacetKey = part_state::FacetKey;

  int dimension = 2;
  std::uint64_t revision = 0;
  PartChoice choice;
  mesh_data::RegionChoice regions;  // by the ids of all polygons that are chosen

  SlotColumn<double> points;
  SlotColumn<Slot> vertex_slots, cell_slots, facet_cells;
  SlotColumn<std::int32_t> origin, cells, facets, facet_twins, vertex_numbers, cell_numbers;
  SlotColumn<RegionId> cell_regions;
  SlotColumn<FeatureId> facet_owners;
  Changes changes;

  std::vector<std::int32_t> uses;         // of each vertex: its cells
  std::vector<std::int32_t> next_copy;    // of each vertex: the next copy of the mesh's vertex
  std::vector<std::int32_t> cell_facets;  // of each cell, opposite to each corner: its facet
  std::vector<std::array<std::uint8_t, 2>> facet_sides;  // the corners of facet_cells opposite it
  std::vector<Slot> cell_at;  // of each slot of a vertex of the mesh: a cell's slot

  // The owners of subsegments, in 3D of subfacets, of the whole mesh. More than one is a moment
  // between two diffs.
  absl::flat_hash_map<FacetKey, absl::InlinedVector<FeatureId, 1>> owners;

  absl::flat_hash_set<FeatureId> open;  // the features that are opened: by id and by name
  absl::flat_hash_set<FacetKey> open_facets;
  absl::flat_hash_map<VertexId, std::int32_t> seam_uses;
  absl::flat_hash_map<FeatureId, std::int32_t> owned;  // by feature, if names are opened: facets

  std::vector<Slot> unused;      // vertices that lost the last cell of a copy
  std::vector<Slot> seam_stars;  // vertices whose copies may be others now

  std::size_t width() const { return static_cast<std::size_t>(dimension) + 1; }
  std::size_t facet_width() const { return static_cast<std::size_t>(dimension); }
  bool Has(Slot cell) const {
    return cell != kNoSlot && cell_numbers[part_state::At(cell)] != part_state::kNone;
  }

  // ---- the whole, and updates: mesh_part.cc

  mesh_data::RegionChoice Choose(const LabelColumn& labels) const;
  bool IsIn(mesh_data::RegionFilter& filter, RegionId region) const {
    return !IsEmptyChoice() && filter.Has(region);
  }
  // Nothing is chosen. RegionChoice takes that for everything.
  bool IsEmptyChoice() const { return regions.in.empty() && !regions.in_any; }
  void Build(const SlotMesh& mesh);
  absl::Status CheckFollows(const SlotMesh& mesh, std::span<const MeshDiff* const> diffs) const;
  absl::Status CheckIsAt(const SlotMesh& mesh) const;
  absl::Status Update(const SlotMesh& mesh, std::span<const MeshDiff* const> diffs);
  void Grow(const SlotMesh& mesh);
  void AddOwner(const FacetKey& key, FeatureId owner);
  void RemoveOwner(const FacetKey& key, FeatureId owner);
  void ChangeOwners(const MeshDiff& diff, std::vector<FacetKey>& changed);
  void ChangeCells(const SlotMesh& mesh, std::vector<Slot>& left, std::vector<Slot>& others);

  // ---- vertices and cells: part_cells.cc

  // A new copy of the mesh's vertex, its first one if there is none.
  std::int32_t AddVertex(const SlotMesh& mesh, Slot slot);
  void SetVertexNumber(Slot slot, std::int32_t number);
  void SetCellNumber(Slot slot, std::int32_t number);
  void NoteCellAt(const SlotMesh& mesh, Slot cell);
  // Its corners at a seam are none until SetCopies.
  void AddCell(const SlotMesh& mesh, Slot slot);
  // Its facets go; cells that stay at one of them are `left`.
  void RemoveCell(const SlotMesh& mesh, Slot slot, std::vector<Slot>& left);
  // Copies without a cell go, and the last ones take their numbers.
  void DropUnused(const SlotMesh& mesh);
  void DropVertex(const SlotMesh& mesh, std::int32_t number);
  void Unlink(std::int32_t number);
  void SetOrigins(Slot slot);
  void Renumber(const SlotMesh& mesh, Slot vertex, std::int32_t from, std::int32_t to);

  // Calls f(cell, corner) for the mesh's cells at the vertex until it returns true.
  template <class F>
  void ForEachCellAt(const SlotMesh& mesh, Slot vertex, const F& f) const {
    const Slot first = cell_at[part_state::At(vertex)];
    if (first == kNoSlot) return;
    std::vector<Slot> star = {first};
    absl::flat_hash_set<Slot> seen = {first};
    for (std::size_t i = 0; i < star.size(); ++i) {
      const Slot* const corners = mesh.cells().data() + part_state::At(star[i]) * width();
      const auto at =
          static_cast<std::size_t>(std::find(corners, corners + width(), vertex) - corners);
      if (at == width()) continue;  // not one of its cells: of a mesh that is not whole
      if (f(star[i], at)) return;
      for (std::size_t k = 0; k < width(); ++k) {
        if (k == at) continue;
        const Slot beyond = mesh.neighbours()[part_state::At(star[i]) * width() + k];
        if (beyond != kNoSlot && seen.insert(beyond).second) star.push_back(beyond);
      }
    }
  }

  // ---- facets: part_facets.cc

  // The facet opposite to the cell's corner k.
  FacetKey FacetOf(const SlotMesh& mesh, Slot cell, std::size_t k) const;
  void RemoveFacet(std::int32_t facet);
  void AddFacet(Slot cell, std::size_t k, Slot other, std::size_t side, FeatureId owner);
  // The facet of the part's cell opposite to its corner k, as it is to be now.
  void SetFacet(const SlotMesh& mesh, Slot cell, std::size_t k);
  void SetFacetsOf(const SlotMesh& mesh, Slot cell);
  // The facets of the part's cells at the mesh's cell.
  void SetFacetsBeside(const SlotMesh& mesh, Slot cell);
  // That of the part between these vertices, if there is one.
  void SetFacetBetween(const SlotMesh& mesh, const FacetKey& key);

  // ---- opened features: part_seams.cc

  bool HasSeams() const { return !choice.open.empty() || !choice.open_names.empty(); }
  // Can the vertex have several copies, now or before?
  bool IsAtSeam(const SlotMesh& mesh, Slot vertex) const;
  // Fills `open`.
  void ChooseOpen(const LabelColumn& labels);
  // By the names that features have now. Of those that are opened now and were not, or the other
  // way round, returns the ones that own a facet.
  std::vector<FeatureId> FollowNames(const SlotMesh& mesh, std::span<const MeshDiff* const> diffs);
  // Adds the facets of these features: O(facets of the mesh) if they own any, else O(features).
  void AddFacetsOf(std::vector<FeatureId> features, std::vector<FacetKey>& keys) const;
  // After the owners of these facets, or `open`, have changed.
  void SetOpen(const SlotMesh& mesh, std::span<const FacetKey> changed);
  // Gives each sector of the part's cells around the vertices of seam_stars a copy of its own.
  void SetCopies(const SlotMesh& mesh);
  void SetCopiesOf(const SlotMesh& mesh, Slot vertex);
  void SetCorner(Slot cell, std::size_t k, std::int32_t number);
  // The row of the other side of an opened facet.
  void SetTwins(std::int32_t a, std::int32_t b);
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_MESH_DATA_PART_STATE_H_
