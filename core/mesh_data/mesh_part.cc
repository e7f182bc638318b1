#include <algorithm>
#include <array>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/container/inlined_vector.h"
#include "core/base/text.h"
#include "core/mesh_data/region_filter.h"
#include "dynmesh/part.h"

namespace dynmesh {
namespace {

using text::Concat;

std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }

constexpr std::int32_t kNone = -1;

// The ids of a facet's corners, ascending; in 2D the last one is none.
using FacetKey = std::array<VertexId, 3>;

FacetKey KeyOf(const VertexId* ids, std::size_t count) {
  FacetKey key = {ids[0], ids[1], count == 3 ? ids[2] : ~VertexId{0}};
  if (key[1] < key[0]) std::swap(key[0], key[1]);
  if (key[2] < key[1]) std::swap(key[1], key[2]);
  if (key[1] < key[0]) std::swap(key[0], key[1]);
  return key;
}

// The corners of the facet opposite to each corner, such that the cell is on its left or below it.
constexpr std::size_t kEdgesOf[3][3] = {{1, 2}, {2, 0}, {0, 1}};
constexpr std::size_t kFacesOf[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

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

}  // namespace

struct MeshPart::State {
  int dimension = 2;
  std::uint64_t revision = 0;
  PartChoice choice;
  mesh_data::RegionChoice regions;  // by the ids of all polygons that are chosen

  SlotColumn<double> points;
  SlotColumn<Slot> vertex_slots, cell_slots, facet_cells;
  SlotColumn<std::int32_t> cells, facets, vertex_numbers, cell_numbers;
  SlotColumn<RegionId> cell_regions;
  SlotColumn<FeatureId> facet_owners;
  Changes changes;

  std::vector<std::int32_t> uses;         // of each vertex: its cells
  std::vector<std::int32_t> cell_facets;  // of each cell, opposite to each corner: its facet
  std::vector<std::array<std::uint8_t, 2>> facet_sides;  // the corners of facet_cells opposite it
  std::vector<Slot> cell_at;  // of each slot of a vertex of the mesh: a cell's slot

  // The owners of subsegments, in 3D of subfacets, of the whole mesh. More than one is a moment
  // between two diffs.
  absl::flat_hash_map<FacetKey, absl::InlinedVector<FeatureId, 1>> owners;

  std::size_t width() const { return static_cast<std::size_t>(dimension) + 1; }
  std::size_t facet_width() const { return static_cast<std::size_t>(dimension); }

  // ---- the whole

  mesh_data::RegionChoice Choose(const LabelColumn& labels) const {
    mesh_data::RegionChoice chosen;
    chosen.in = choice.polygons;
    chosen.out = choice.without;
    chosen.in_any = choice.inside;
    for (const LabelOfFeature& of : labels) {
      if (std::ranges::find(choice.names, of.label.name) != choice.names.end() &&
          !of.label.name.empty()) {
        chosen.in.push_back(of.id);
      }
    }
    mesh_data::Normalize(chosen);
    return chosen;
  }

  // Nothing is chosen. RegionChoice takes that for everything.
  bool IsEmptyChoice() const { return regions.in.empty() && !regions.in_any; }

  void Build(const SlotMesh& mesh) {
    dimension = mesh.dimension();
    regions = Choose(mesh.labels());
    points = {}, vertex_slots = {}, cell_slots = {}, facet_cells = {};
    cells = {}, facets = {}, vertex_numbers = {}, cell_numbers = {};
    cell_regions = {}, facet_owners = {};
    uses.clear(), cell_facets.clear(), facet_sides.clear(), cell_at.clear(), owners.clear();
    Grow(mesh);
    const auto take_owners = [&](const SlotColumn<Slot>& rows, std::size_t corners,
                                 const SlotColumn<FeatureId>& of) {
      for (std::size_t row = 0; row * corners < rows.size(); ++row) {
        if (rows[row * corners] == kNoSlot) continue;
        VertexId ids[3] = {};
        for (std::size_t i = 0; i < corners; ++i) ids[i] = mesh.ids()[At(rows[row * corners + i])];
        owners[KeyOf(ids, corners)].push_back(of[row]);
      }
    };
    if (dimension == 2) {
      take_owners(mesh.subsegments(), 2, mesh.subsegment_owners());
    } else {
      take_owners(mesh.subfacets(), 3, mesh.subfacet_owners());
    }
    const std::vector<RegionSet> sets = mesh.region_sets();
    mesh_data::RegionFilter filter(regions, sets);
    const SlotColumn<Slot>& corners = mesh.cells();
    const std::size_t count = corners.size() / width();
    // Vertices by ascending slot, too.
    std::vector<bool> is_used(mesh.ids().size());
    for (std::size_t cell = 0; cell < count; ++cell) {
      if (corners[cell * width()] == kNoSlot) continue;
      NoteCellAt(mesh, static_cast<Slot>(cell));
      if (!IsIn(filter, mesh.regions()[cell])) continue;
      for (std::size_t k = 0; k < width(); ++k) is_used[At(corners[cell * width() + k])] = true;
    }
    for (std::size_t slot = 0; slot < is_used.size(); ++slot) {
      if (is_used[slot]) AddVertex(mesh, static_cast<Slot>(slot));
    }
    for (std::size_t cell = 0; cell < count; ++cell) {
      if (corners[cell * width()] != kNoSlot && IsIn(filter, mesh.regions()[cell])) {
        AddCell(mesh, static_cast<Slot>(cell));
      }
    }
    for (std::size_t row = 0; row < cell_slots.size(); ++row) SetFacetsOf(mesh, cell_slots[row]);
    changes = {};
    revision = mesh.revision();
  }

  bool IsIn(mesh_data::RegionFilter& filter, RegionId region) const {
    return !IsEmptyChoice() && filter.Has(region);
  }

  void Grow(const SlotMesh& mesh) {
    const std::size_t vertices = mesh.ids().size(), all = mesh.cells().size() / width();
    if (vertex_numbers.size() < vertices) vertex_numbers.resize(vertices, kNone);
    if (cell_numbers.size() < all) cell_numbers.resize(all, kNone);
    cell_at.resize(vertices, kNoSlot);
  }

  void NoteCellAt(const SlotMesh& mesh, Slot cell) {
    for (std::size_t k = 0; k < width(); ++k) {
      cell_at[At(mesh.cells()[At(cell) * width() + k])] = cell;
    }
  }

  // ---- vertices and cells

  std::int32_t AddVertex(const SlotMesh& mesh, Slot slot) {
    const auto number = static_cast<std::int32_t>(vertex_slots.size());
    vertex_slots.resize(vertex_slots.size() + 1, slot);
    const std::size_t row = AddRow(points, facet_width(), 0.0);
    for (std::size_t i = 0; i < facet_width(); ++i) {
      points[row * facet_width() + i] = mesh.points()[At(slot) * facet_width() + i];
    }
    uses.push_back(0);
    SetVertexNumber(slot, number);
    changes.vertices.push_back(number);
    return number;
  }

  void SetVertexNumber(Slot slot, std::int32_t number) {
    vertex_numbers[At(slot)] = number;
    changes.vertex_slots.push_back(slot);
  }
  void SetCellNumber(Slot slot, std::int32_t number) {
    cell_numbers[At(slot)] = number;
    changes.cell_slots.push_back(slot);
  }

  bool Has(Slot cell) const { return cell != kNoSlot && cell_numbers[At(cell)] != kNone; }

  void AddCell(const SlotMesh& mesh, Slot slot) {
    const std::size_t row = AddRow(cells, width(), kNone);
    for (std::size_t k = 0; k < width(); ++k) {
      const Slot vertex = mesh.cells()[At(slot) * width() + k];
      std::int32_t number = vertex_numbers[At(vertex)];
      if (number == kNone) number = AddVertex(mesh, vertex);
      cells[row * width() + k] = number;
      ++uses[At(number)];
    }
    cell_slots.resize(row + 1, slot);
    cell_regions.resize(row + 1, mesh.regions()[At(slot)]);
    cell_facets.resize((row + 1) * width(), kNone);
    SetCellNumber(slot, static_cast<std::int32_t>(row));
    changes.cells.push_back(static_cast<std::int32_t>(row));
  }

  // Its facets go; cells that stay at one of them are `left`.
  void RemoveCell(Slot slot, std::vector<Slot>& left) {
    const std::int32_t number = cell_numbers[At(slot)];
    const std::size_t row = At(number);
    for (std::size_t k = 0; k < width(); ++k) {
      const std::int32_t facet = cell_facets[row * width() + k];
      if (facet != kNone) {
        for (std::size_t i = 0; i < 2; ++i) {
          const Slot other = facet_cells[At(facet) * 2 + i];
          if (other != kNoSlot && other != slot) left.push_back(other);
        }
        RemoveFacet(facet);
      }
      const std::int32_t vertex = cells[row * width() + k];
      if (--uses[At(vertex)] == 0) unused.push_back(vertex_slots[At(vertex)]);
    }
    const std::size_t last = cell_slots.size() - 1;
    if (row != last) {
      SetCellNumber(cell_slots[last], number);
      changes.cells.push_back(number);
      std::copy_n(cell_facets.begin() + static_cast<std::ptrdiff_t>(last * width()), width(),
                  cell_facets.begin() + static_cast<std::ptrdiff_t>(row * width()));
    }
    MoveLast(cells, width(), row);
    MoveLast(cell_slots, 1, row);
    MoveLast(cell_regions, 1, row);
    cell_facets.resize(last * width());
    SetCellNumber(slot, kNone);
  }

  std::vector<Slot> unused;  // vertices that lost their last cell

  // Vertices without a cell go, and the last ones take their numbers.
  void DropUnused(const SlotMesh& mesh) {
    for (const Slot slot : unused) {
      const std::int32_t number = vertex_numbers[At(slot)];
      if (number == kNone || uses[At(number)] != 0) continue;
      const std::size_t row = At(number), last = vertex_slots.size() - 1;
      const Slot moved = vertex_slots[last];
      MoveLast(points, facet_width(), row);
      MoveLast(vertex_slots, 1, row);
      uses[row] = uses[last];
      uses.pop_back();
      if (row != last) {
        SetVertexNumber(moved, number);
        changes.vertices.push_back(number);
        // One that has lost its last cell goes later.
        if (uses[row] != 0) Renumber(mesh, moved, static_cast<std::int32_t>(last), number);
      }
      SetVertexNumber(slot, kNone);
    }
    unused.clear();
  }

  void Renumber(const SlotMesh& mesh, Slot vertex, std::int32_t from, std::int32_t to) {
    ForEachCellAt(mesh, vertex, [&](Slot cell, std::size_t) {
      const std::int32_t number = cell_numbers[At(cell)];
      if (number == kNone) return false;
      const std::size_t row = At(number);
      for (std::size_t k = 0; k < width(); ++k) {
        if (cells[row * width() + k] == from) cells[row * width() + k] = to;
        const std::int32_t facet = cell_facets[row * width() + k];
        if (facet == kNone) continue;
        for (std::size_t i = 0; i < facet_width(); ++i) {
          std::int32_t& corner = facets[At(facet) * facet_width() + i];
          if (corner == from) {
            corner = to;
            changes.facets.push_back(facet);
          }
        }
      }
      changes.cells.push_back(number);
      return false;
    });
  }

  // Calls f(cell, corner) for the mesh's cells at the vertex until it returns true.
  template <class F>
  void ForEachCellAt(const SlotMesh& mesh, Slot vertex, const F& f) {
    const Slot first = cell_at[At(vertex)];
    if (first == kNoSlot) return;
    star_.assign(1, first);
    absl::flat_hash_set<Slot> seen = {first};
    for (std::size_t i = 0; i < star_.size(); ++i) {
      const Slot* const corners = mesh.cells().data() + At(star_[i]) * width();
      const auto at =
          static_cast<std::size_t>(std::find(corners, corners + width(), vertex) - corners);
      if (at == width()) continue;  // not one of its cells: of a mesh that is not whole
      if (f(star_[i], at)) return;
      for (std::size_t k = 0; k < width(); ++k) {
        if (k == at) continue;
        const Slot beyond = mesh.neighbours()[At(star_[i]) * width() + k];
        if (beyond != kNoSlot && seen.insert(beyond).second) star_.push_back(beyond);
      }
    }
  }
  std::vector<Slot> star_;

  // ---- facets

  void RemoveFacet(std::int32_t facet) {
    const auto set = [&](std::size_t row, std::int32_t value) {
      for (std::size_t i = 0; i < 2; ++i) {
        const Slot cell = facet_cells[row * 2 + i];
        if (cell != kNoSlot) {
          cell_facets[At(cell_numbers[At(cell)]) * width() + facet_sides[row][i]] = value;
        }
      }
    };
    const std::size_t row = At(facet), last = facet_owners.size() - 1;
    set(row, kNone);
    if (row != last) {
      set(last, facet);
      changes.facets.push_back(facet);
    }
    MoveLast(facets, facet_width(), row);
    MoveLast(facet_owners, 1, row);
    MoveLast(facet_cells, 2, row);
    facet_sides[row] = facet_sides[last];
    facet_sides.pop_back();
  }

  FeatureId OwnerOf(const SlotMesh& mesh, Slot cell, std::size_t k, bool& is_constraint) const {
    VertexId ids[3] = {};
    std::size_t n = 0;
    for (std::size_t i = 0; i < width(); ++i) {
      if (i != k) ids[n++] = mesh.ids()[At(mesh.cells()[At(cell) * width() + i])];
    }
    const auto it = owners.find(KeyOf(ids, n));
    is_constraint = it != owners.end();
    return is_constraint ? *std::ranges::min_element(it->second) : kNoFeature;
  }

  // The facet of the part's cell opposite to its corner k, as it is to be now.
  void SetFacet(const SlotMesh& mesh, Slot cell, std::size_t k) {
    const Slot beyond = mesh.neighbours()[At(cell) * width() + k];
    const bool is_border = !Has(beyond);
    const Slot other = is_border ? kNoSlot : beyond;
    std::size_t side = 0;
    std::int32_t facet = cell_facets[At(cell_numbers[At(cell)]) * width() + k];
    if (!is_border) {
      while (mesh.neighbours()[At(beyond) * width() + side] != cell) ++side;
      // Until now it may have been at the border.
      const std::int32_t there = cell_facets[At(cell_numbers[At(other)]) * width() + side];
      if (there != facet && there != kNone) RemoveFacet(there);
      facet = cell_facets[At(cell_numbers[At(cell)]) * width() + k];
    }
    bool is_constraint = false;
    const FeatureId owner = OwnerOf(mesh, cell, k, is_constraint);
    if (!is_constraint && !is_border) {
      if (facet != kNone) RemoveFacet(facet);
      return;
    }
    if (facet != kNone) {
      const Slot* const sides = facet_cells.data() + At(facet) * 2;
      const bool is_same = (sides[0] == cell && sides[1] == other) ||
                           (other != kNoSlot && sides[0] == other && sides[1] == cell);
      if (is_same) {
        if (facet_owners[At(facet)] != owner) changes.facets.push_back(facet);
        facet_owners[At(facet)] = owner;
        return;
      }
      RemoveFacet(facet);
    }
    facet = static_cast<std::int32_t>(facet_owners.size());
    facet_owners.resize(facet_owners.size() + 1, owner);
    AddRow(facets, facet_width(), kNone);
    const std::size_t row = AddRow(facet_cells, 2, kNoSlot);
    facet_cells[row * 2] = cell, facet_cells[row * 2 + 1] = other;
    facet_sides.push_back({static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(side)});
    const std::size_t number = At(cell_numbers[At(cell)]);
    for (std::size_t i = 0; i < facet_width(); ++i) {
      const std::size_t corner = dimension == 2 ? kEdgesOf[k][i] : kFacesOf[k][i];
      facets[row * facet_width() + i] = cells[number * width() + corner];
    }
    cell_facets[number * width() + k] = facet;
    if (other != kNoSlot) cell_facets[At(cell_numbers[At(other)]) * width() + side] = facet;
    changes.facets.push_back(facet);
  }

  void SetFacetsOf(const SlotMesh& mesh, Slot cell) {
    for (std::size_t k = 0; k < width(); ++k) SetFacet(mesh, cell, k);
  }

  // The facets of the part's cells at the mesh's cell.
  void SetFacetsBeside(const SlotMesh& mesh, Slot cell) {
    if (Has(cell)) return SetFacetsOf(mesh, cell);
    for (std::size_t k = 0; k < width(); ++k) {
      const Slot beyond = mesh.neighbours()[At(cell) * width() + k];
      if (!Has(beyond)) continue;
      std::size_t side = 0;
      while (mesh.neighbours()[At(beyond) * width() + side] != cell) ++side;
      SetFacet(mesh, beyond, side);
    }
  }

  // That of the part between these vertices, if there is one.
  void SetFacetOf(const SlotMesh& mesh, const FacetKey& key) {
    Slot slots[3] = {};
    for (std::size_t i = 0; i < facet_width(); ++i) {
      slots[i] = mesh.FindSlot(key[i]);
      if (slots[i] == kNoSlot) return;
    }
    ForEachCellAt(mesh, slots[0], [&](Slot cell, std::size_t) {
      if (!Has(cell)) return false;
      const Slot* const corners = mesh.cells().data() + At(cell) * width();
      std::size_t missing = width(), found = 0;
      for (std::size_t k = 0; k < width(); ++k) {
        if (std::find(slots, slots + facet_width(), corners[k]) != slots + facet_width()) {
          ++found;
        } else {
          missing = k;
        }
      }
      if (found != facet_width()) return false;
      SetFacet(mesh, cell, missing);
      return true;
    });
  }

  // ---- updates

  void ChangeOwners(const MeshDiff& diff, std::vector<FacetKey>& changed) {
    const std::size_t n = facet_width();
    const auto& removed_ids =
        dimension == 2 ? diff.removed_subsegments.ends : diff.removed_subfacets.corners;
    const auto& removed_of =
        dimension == 2 ? diff.removed_subsegments.owners : diff.removed_subfacets.owners;
    const auto& added_ids =
        dimension == 2 ? diff.added_subsegments.ends : diff.added_subfacets.corners;
    const auto& added_of =
        dimension == 2 ? diff.added_subsegments.owners : diff.added_subfacets.owners;
    for (std::size_t i = 0; i < removed_of.size(); ++i) {
      const FacetKey key = KeyOf(removed_ids.data() + i * n, n);
      changed.push_back(key);
      const auto it = owners.find(key);
      if (it == owners.end()) continue;
      const auto at = std::ranges::find(it->second, removed_of[i]);
      if (at != it->second.end()) it->second.erase(at);
      if (it->second.empty()) owners.erase(it);
    }
    for (std::size_t i = 0; i < added_of.size(); ++i) {
      const FacetKey key = KeyOf(added_ids.data() + i * n, n);
      changed.push_back(key);
      owners[key].push_back(added_of[i]);
    }
  }

  absl::Status Update(const SlotMesh& mesh, std::span<const MeshDiff* const> diffs) {
    const MeshPatch& patch = mesh.patch();
    if (mesh.dimension() != dimension || patch.from_revision != revision ||
        patch.to_revision != mesh.revision()) {
      return absl::FailedPreconditionError(
          Concat("the part is of revision ", revision, ", the mesh's patch leads from ",
                 patch.from_revision, " to ", patch.to_revision, ": make the part anew"));
    }
    std::uint64_t at = revision;
    for (const MeshDiff* const diff : diffs) {
      if (diff->from_revision != at) break;
      at = diff->to_revision;
    }
    if (at != mesh.revision()) {
      return absl::FailedPreconditionError(
          Concat("the diffs lead to revision ", at, ", the mesh is at ", mesh.revision()));
    }
    const bool may_name =
        !choice.names.empty() &&
        std::ranges::any_of(diffs, [](const MeshDiff* d) { return !d->labels.empty(); });
    if (may_name && Choose(mesh.labels()) != regions) {
      Build(mesh);
      return absl::OkStatus();
    }
    changes = {};
    changes.is_all = false;
    Grow(mesh);
    std::vector<FacetKey> changed;
    for (const MeshDiff* const diff : diffs) ChangeOwners(*diff, changed);
    const std::vector<RegionSet> sets = mesh.region_sets();
    mesh_data::RegionFilter filter(regions, sets);
    std::vector<Slot> left;
    for (const Slot cell : patch.removed_simplices) {
      if (Has(cell)) RemoveCell(cell, left);
    }
    std::vector<Slot> others;  // whose facets may change
    for (const Slot cell : patch.relabelled_simplices) {
      const RegionId region = mesh.regions()[At(cell)];
      const bool is_in = IsIn(filter, region), was_in = Has(cell);
      if (is_in && was_in) {
        const std::int32_t number = cell_numbers[At(cell)];
        cell_regions[At(number)] = region;
        changes.cells.push_back(number);
      }
      if (is_in == was_in) continue;
      if (was_in) RemoveCell(cell, left);
      if (is_in) AddCell(mesh, cell);
      others.push_back(cell);
    }
    for (const Slot cell : patch.added_simplices) {
      NoteCellAt(mesh, cell);
      if (IsIn(filter, mesh.regions()[At(cell)])) AddCell(mesh, cell);
    }
    DropUnused(mesh);
    for (const Slot cell : left) {
      if (Has(cell)) SetFacetsOf(mesh, cell);
    }
    for (const Slot cell : patch.added_simplices) SetFacetsBeside(mesh, cell);
    for (const Slot cell : others) SetFacetsBeside(mesh, cell);
    for (const FacetKey& key : changed) SetFacetOf(mesh, key);
    revision = mesh.revision();
    return absl::OkStatus();
  }
};

MeshPart::MeshPart(const SlotMesh& mesh, PartChoice choice) : state_(std::make_unique<State>()) {
  state_->choice = std::move(choice);
  state_->Build(mesh);
}
MeshPart::MeshPart(const MeshPart& other) : state_(std::make_unique<State>(*other.state_)) {}
MeshPart::MeshPart(MeshPart&& other) noexcept = default;
MeshPart& MeshPart::operator=(MeshPart other) noexcept {
  state_.swap(other.state_);
  return *this;
}
MeshPart::~MeshPart() = default;

absl::Status MeshPart::Update(const SlotMesh& mesh, std::span<const MeshDiff* const> diffs) {
  return state_->Update(mesh, diffs);
}

absl::StatusOr<Mesh> MeshPart::ToMesh(const SlotMesh& mesh) const {
  if (mesh.dimension() != dimension() || mesh.revision() != revision()) {
    return absl::FailedPreconditionError(Concat("the part is of revision ", revision(),
                                                ", the mesh is at ", mesh.revision(),
                                                ": update the part first"));
  }
  const Mesh whole = mesh.ToMesh();
  if (!state_->IsEmptyChoice()) return mesh_data::OnlyInside(whole, state_->regions);
  return mesh_data::OnlyRows(whole, std::vector<bool>(whole.simplex_count()));
}

int MeshPart::dimension() const { return state_->dimension; }
std::uint64_t MeshPart::revision() const { return state_->revision; }
const SlotColumn<double>& MeshPart::points() const { return state_->points; }
const SlotColumn<Slot>& MeshPart::vertex_slots() const { return state_->vertex_slots; }
const SlotColumn<std::int32_t>& MeshPart::cells() const { return state_->cells; }
const SlotColumn<Slot>& MeshPart::cell_slots() const { return state_->cell_slots; }
const SlotColumn<RegionId>& MeshPart::cell_regions() const { return state_->cell_regions; }
const SlotColumn<std::int32_t>& MeshPart::facets() const { return state_->facets; }
const SlotColumn<FeatureId>& MeshPart::facet_owners() const { return state_->facet_owners; }
const SlotColumn<Slot>& MeshPart::facet_cells() const { return state_->facet_cells; }
const SlotColumn<std::int32_t>& MeshPart::vertex_numbers() const { return state_->vertex_numbers; }
const SlotColumn<std::int32_t>& MeshPart::cell_numbers() const { return state_->cell_numbers; }
const MeshPart::Changes& MeshPart::changes() const { return state_->changes; }

}  // namespace dynmesh
