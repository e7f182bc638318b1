// Parts: the whole, and updates.
#include <algorithm>
#include <utility>

#include "core/base/text.h"
#include "core/mesh_data/part_state.h"

namespace dynmesh {

using part_state::At;
using part_state::KeyOf;
using part_state::kNone;
using text::Concat;

mesh_data::RegionChoice MeshPart::State::Choose(const LabelColumn& labels) const {
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

void MeshPart::State::Build(const SlotMesh& mesh) {
  State empty;
  empty.choice = std::move(choice);
  *this = std::move(empty);
  dimension = mesh.dimension();
  regions = Choose(mesh.labels());
  ChooseOpen(mesh.labels());
  Grow(mesh);
  std::vector<FacetKey> all_facets;
  const auto take_owners = [&](const SlotColumn<Slot>& rows, std::size_t corners,
                               const SlotColumn<FeatureId>& of) {
    for (std::size_t row = 0; row * corners < rows.size(); ++row) {
      if (rows[row * corners] == kNoSlot) continue;
      VertexId ids[3] = {};
      for (std::size_t i = 0; i < corners; ++i) ids[i] = mesh.ids()[At(rows[row * corners + i])];
      AddOwner(KeyOf(ids, corners), of[row]);
      if (open.contains(of[row])) all_facets.push_back(KeyOf(ids, corners));
    }
  };
  if (dimension == 2) {
    take_owners(mesh.subsegments(), 2, mesh.subsegment_owners());
  } else {
    take_owners(mesh.subfacets(), 3, mesh.subfacet_owners());
  }
  SetOpen(mesh, all_facets);
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
  SetCopies(mesh);
  for (std::size_t row = 0; row < cell_slots.size(); ++row) SetFacetsOf(mesh, cell_slots[row]);
  changes = {};
  revision = mesh.revision();
}

void MeshPart::State::Grow(const SlotMesh& mesh) {
  const std::size_t vertices = mesh.ids().size(), all = mesh.cells().size() / width();
  if (vertex_numbers.size() < vertices) vertex_numbers.resize(vertices, kNone);
  if (cell_numbers.size() < all) cell_numbers.resize(all, kNone);
  cell_at.resize(vertices, kNoSlot);
}

void MeshPart::State::AddOwner(const FacetKey& key, FeatureId owner) {
  owners[key].push_back(owner);
  if (!choice.open_names.empty()) ++owned[owner];
}

void MeshPart::State::RemoveOwner(const FacetKey& key, FeatureId owner) {
  const auto it = owners.find(key);
  if (it == owners.end()) return;
  const auto at = std::ranges::find(it->second, owner);
  if (at == it->second.end()) return;
  it->second.erase(at);
  if (it->second.empty()) owners.erase(it);
  if (!choice.open_names.empty() && --owned[owner] == 0) owned.erase(owner);
}

void MeshPart::State::ChangeOwners(const MeshDiff& diff, std::vector<FacetKey>& changed) {
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
    changed.push_back(KeyOf(removed_ids.data() + i * n, n));
    RemoveOwner(changed.back(), removed_of[i]);
  }
  for (std::size_t i = 0; i < added_of.size(); ++i) {
    changed.push_back(KeyOf(added_ids.data() + i * n, n));
    AddOwner(changed.back(), added_of[i]);
  }
}

absl::Status MeshPart::State::CheckFollows(const SlotMesh& mesh,
                                           std::span<const MeshDiff* const> diffs) const {
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
  return absl::OkStatus();
}

absl::Status MeshPart::State::CheckIsAt(const SlotMesh& mesh) const {
  if (mesh.dimension() == dimension && mesh.revision() == revision) return absl::OkStatus();
  return absl::FailedPreconditionError(Concat("the part is of revision ", revision,
                                              ", the mesh is at ", mesh.revision(),
                                              ": update the part first"));
}

// `left` are cells at facets that went, `others` those whose facets may change.
void MeshPart::State::ChangeCells(const SlotMesh& mesh, std::vector<Slot>& left,
                                  std::vector<Slot>& others) {
  const MeshPatch& patch = mesh.patch();
  const std::vector<RegionSet> sets = mesh.region_sets();
  mesh_data::RegionFilter filter(regions, sets);
  for (const Slot cell : patch.removed_simplices) {
    if (Has(cell)) RemoveCell(mesh, cell, left);
  }
  for (const Slot cell : patch.relabelled_simplices) {
    const RegionId region = mesh.regions()[At(cell)];
    const bool is_in = IsIn(filter, region), was_in = Has(cell);
    if (is_in && was_in) {
      const std::int32_t number = cell_numbers[At(cell)];
      cell_regions[At(number)] = region;
      changes.cells.push_back(number);
    }
    if (is_in == was_in) continue;
    if (was_in) RemoveCell(mesh, cell, left);
    if (is_in) AddCell(mesh, cell);
    others.push_back(cell);
  }
  for (const Slot cell : patch.added_simplices) {
    NoteCellAt(mesh, cell);
    if (IsIn(filter, mesh.regions()[At(cell)])) AddCell(mesh, cell);
    others.push_back(cell);
  }
}

absl::Status MeshPart::State::Update(const SlotMesh& mesh, std::span<const MeshDiff* const> diffs) {
  if (absl::Status s = CheckFollows(mesh, diffs); !s.ok()) return s;
  const bool may_name = !choice.names.empty() && std::ranges::any_of(diffs, [](const MeshDiff* d) {
    return !d->labels.empty();
  });
  if (may_name && Choose(mesh.labels()) != regions) {
    Build(mesh);
    return absl::OkStatus();
  }
  changes = {};
  changes.is_all = false;
  Grow(mesh);
  const std::vector<FeatureId> toggled = FollowNames(mesh, diffs);
  std::vector<FacetKey> changed;
  for (const MeshDiff* const diff : diffs) ChangeOwners(*diff, changed);
  AddFacetsOf(toggled, changed);
  SetOpen(mesh, changed);
  std::vector<Slot> left, others;
  ChangeCells(mesh, left, others);
  SetCopies(mesh);
  DropUnused(mesh);
  for (const Slot cell : left) {
    if (Has(cell)) SetFacetsOf(mesh, cell);
  }
  for (const Slot cell : others) SetFacetsBeside(mesh, cell);
  for (const FacetKey& key : changed) SetFacetBetween(mesh, key);
  revision = mesh.revision();
  return absl::OkStatus();
}

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

absl::StatusOr<std::vector<std::int32_t>> MeshPart::CellsAround(
    const SlotMesh& mesh, std::span<const std::int32_t> vertices) const {
  if (absl::Status s = state_->CheckIsAt(mesh); !s.ok()) return s;
  std::vector<std::int32_t> around;
  for (const std::int32_t vertex : vertices) {
    if (vertex < 0 || At(vertex) >= state_->vertex_slots.size()) {
      return absl::OutOfRangeError(Concat("the part has ", state_->vertex_slots.size(),
                                          " vertices, and none with number ", vertex));
    }
    state_->ForEachCellAt(mesh, state_->vertex_slots[At(vertex)], [&](Slot cell, std::size_t k) {
      const std::int32_t number = state_->cell_numbers[At(cell)];
      // Of the cells around the mesh's vertex, those of this copy.
      if (number != kNone && state_->cells[At(number) * state_->width() + k] == vertex) {
        around.push_back(number);
      }
      return false;
    });
  }
  std::ranges::sort(around);
  const auto rest = std::ranges::unique(around);
  around.erase(rest.begin(), rest.end());
  return around;
}

int MeshPart::dimension() const { return state_->dimension; }
std::uint64_t MeshPart::revision() const { return state_->revision; }
const SlotColumn<double>& MeshPart::points() const { return state_->points; }
const SlotColumn<std::int32_t>& MeshPart::origin() const { return state_->origin; }
const SlotColumn<Slot>& MeshPart::vertex_slots() const { return state_->vertex_slots; }
const SlotColumn<std::int32_t>& MeshPart::cells() const { return state_->cells; }
const SlotColumn<Slot>& MeshPart::cell_slots() const { return state_->cell_slots; }
const SlotColumn<RegionId>& MeshPart::cell_regions() const { return state_->cell_regions; }
const SlotColumn<std::int32_t>& MeshPart::facets() const { return state_->facets; }
const SlotColumn<FeatureId>& MeshPart::facet_owners() const { return state_->facet_owners; }
const SlotColumn<std::int32_t>& MeshPart::facet_twins() const { return state_->facet_twins; }
const SlotColumn<Slot>& MeshPart::facet_cells() const { return state_->facet_cells; }
const SlotColumn<std::int32_t>& MeshPart::vertex_numbers() const { return state_->vertex_numbers; }
const SlotColumn<std::int32_t>& MeshPart::cell_numbers() const { return state_->cell_numbers; }
const MeshPart::Changes& MeshPart::changes() const { return state_->changes; }

}  // namespace dynmesh
