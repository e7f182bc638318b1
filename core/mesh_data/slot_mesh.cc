#include "dynmesh/slot_mesh.h"

#include <algorithm>
#include <new>
#include <utility>

#include "core/base/huge_pages.h"
#include "core/mesh_data/check_columns.h"
#include "core/mesh_data/regions.h"
#include "core/mesh_data/slot_state.h"

namespace dynmesh {

using mesh_data::At;
using text::Concat;

namespace slot_mesh_internal {

std::shared_ptr<void> MakeBlock(std::size_t bytes) {
  if (!huge_pages::AreFor(bytes)) {
    return {::operator new(bytes), [](void* block) { ::operator delete(block); }};
  }
  return {huge_pages::Map(bytes), [bytes](void* block) { huge_pages::Unmap(block, bytes); }};
}

}  // namespace slot_mesh_internal

absl::Status SlotMesh::State::Apply(const MeshDiff& diff, bool extends) {
  if (auto status = mesh_data::CheckColumns(diff); !status.ok()) return status;
  if (diff.dimension != dimension) {
    return absl::InvalidArgumentError(
        Concat("a diff of dimension ", diff.dimension, " for a mesh of dimension ", dimension));
  }
  if (diff.from_revision != revision) {
    return absl::FailedPreconditionError(Concat("the diff starts at revision ", diff.from_revision,
                                                ", the mesh is at ", revision,
                                                ": fetch what lies between, or a new snapshot"));
  }
  Netting netting;
  if (auto status = Net(diff, netting); !status.ok()) return status;
  if (netting.replaced.empty()) {
    Commit(diff, netting, extends);
    return absl::OkStatus();
  }
  const MeshDiff whole = WithReplaced(diff, netting);
  netting = Netting();
  if (auto status = Net(whole, netting); !status.ok()) return status;
  Commit(whole, netting, extends);
  return absl::OkStatus();
}

void SlotMesh::State::AppendRegions(Mesh& mesh) const {
  if (labelled == 0) return;
  mesh.regions.reserve(simplices.size());
  for (const Slot slot : simplices) mesh.regions.push_back(regions[At(slot)]);
  for (const auto& [id, set] : sets) mesh.region_sets.push_back({id, set.first});
  mesh_data::KeepNamed(mesh.region_sets, {&mesh.regions});
}

SlotMesh::SlotMesh(int dimension) : state_(std::make_unique<State>(dimension)) {}
SlotMesh::SlotMesh(const SlotMesh& other) : state_(std::make_unique<State>(*other.state_)) {}
SlotMesh::SlotMesh(SlotMesh&& other) noexcept = default;
SlotMesh& SlotMesh::operator=(SlotMesh other) noexcept {
  state_.swap(other.state_);
  return *this;
}
SlotMesh::~SlotMesh() = default;

absl::StatusOr<SlotMesh> SlotMesh::FromMesh(const Mesh& mesh) {
  if (auto status = mesh_data::CheckColumns(mesh); !status.ok()) return status;
  SlotMesh result(mesh.dimension);
  if (auto status = result.state_->Fill(mesh); !status.ok()) return status;
  return result;
}

absl::Status SlotMesh::Apply(const MeshDiff& diff) { return state_->Apply(diff, false); }
absl::Status SlotMesh::Extend(const MeshDiff& diff) { return state_->Apply(diff, true); }
const MeshPatch& SlotMesh::patch() const { return state_->patch; }

Mesh SlotMesh::ToMesh() const {
  const State& s = *state_;
  Mesh mesh;
  mesh.dimension = s.dimension;
  mesh.revision = s.revision;
  mesh.hash = s.hash;
  const std::size_t n = s.vertices.size();
  mesh.vertices.ids.reserve(n), mesh.vertices.coordinates.reserve(n * s.d());
  mesh.vertices.containing_dimensions.reserve(n), mesh.vertices.owners.reserve(n);
  for (std::size_t i = 0; i < s.ids.size(); ++i) {
    if (s.ids[i] == 0) continue;
    mesh.vertices.ids.push_back(s.ids[i]);
    for (std::size_t k = 0; k < s.d(); ++k) {
      mesh.vertices.coordinates.push_back(s.points[i * s.d() + k]);
    }
    mesh.vertices.containing_dimensions.push_back(s.containing_dimensions[i]);
    mesh.vertices.owners.push_back(s.owners[i]);
  }
  mesh.simplices.reserve(s.simplices.size() * s.width());
  for (const Slot slot : s.simplices) {
    const State::IdKey ids = s.IdsOfCell(slot);
    mesh.simplices.insert(mesh.simplices.end(), ids.begin(),
                          ids.begin() + static_cast<std::ptrdiff_t>(s.width()));
  }
  s.AppendRegions(mesh);
  mesh.subsegments = s.subsegments.ToColumns();
  mesh.subfacets = s.subfacets.ToColumns();
  mesh.labels = labels();
  return mesh;
}

CompactNumbering SlotMesh::Compact() const {
  const State& s = *state_;
  CompactNumbering numbering;
  const auto number = [](std::size_t slots, std::size_t count, auto&& is_live,
                         std::vector<Slot>& slot_of, std::vector<std::int32_t>& number_of) {
    slot_of.reserve(count);
    number_of.assign(slots, -1);
    for (std::size_t i = 0; i < slots; ++i) {
      if (!is_live(i)) continue;
      number_of[i] = static_cast<std::int32_t>(slot_of.size());
      slot_of.push_back(static_cast<Slot>(i));
    }
  };
  number(
      s.ids.size(), s.vertices.size(), [&](std::size_t i) { return s.ids[i] != 0; },
      numbering.vertex_slots, numbering.vertex_numbers);
  number(
      s.regions.size(), s.simplices.size(),
      [&](std::size_t i) { return s.cells[i * s.width()] != kNoSlot; }, numbering.simplex_slots,
      numbering.simplex_numbers);
  return numbering;
}

int SlotMesh::dimension() const { return state_->dimension; }
std::uint64_t SlotMesh::revision() const { return state_->revision; }
MeshHash SlotMesh::hash() const { return state_->hash; }
std::size_t SlotMesh::vertex_count() const { return state_->vertices.size(); }
std::size_t SlotMesh::simplex_count() const { return state_->simplices.size(); }
std::size_t SlotMesh::subsegment_count() const { return state_->subsegments.slots.size(); }
std::size_t SlotMesh::subfacet_count() const { return state_->subfacets.slots.size(); }

const SlotColumn<double>& SlotMesh::points() const { return state_->points; }
const SlotColumn<VertexId>& SlotMesh::ids() const { return state_->ids; }
const SlotColumn<std::uint8_t>& SlotMesh::containing_dimensions() const {
  return state_->containing_dimensions;
}
const SlotColumn<FeatureId>& SlotMesh::owners() const { return state_->owners; }
const SlotColumn<Slot>& SlotMesh::cells() const { return state_->cells; }
const SlotColumn<Slot>& SlotMesh::neighbours() const { return state_->neighbours; }
const SlotColumn<RegionId>& SlotMesh::regions() const { return state_->regions; }
bool SlotMesh::has_regions() const { return state_->labelled > 0; }
const SlotColumn<Slot>& SlotMesh::subsegments() const { return state_->subsegments.corners; }
const SlotColumn<FeatureId>& SlotMesh::subsegment_owners() const {
  return state_->subsegments.owners;
}
const SlotColumn<Slot>& SlotMesh::subfacets() const { return state_->subfacets.corners; }
const SlotColumn<FeatureId>& SlotMesh::subfacet_owners() const { return state_->subfacets.owners; }

std::vector<RegionSet> SlotMesh::region_sets() const {
  std::vector<RegionSet> result;
  for (const auto& [id, set] : state_->sets) result.push_back({id, set.first});
  std::sort(result.begin(), result.end(),
            [](const RegionSet& a, const RegionSet& b) { return a.id < b.id; });
  return result;
}

LabelColumn SlotMesh::labels() const {
  LabelColumn result;
  result.reserve(state_->label_of.size());
  for (const auto& [id, label] : state_->label_of) result.push_back({id, label});
  return result;
}

FeatureLabel SlotMesh::FindLabel(FeatureId id) const {
  const auto it = state_->label_of.find(id);
  return it == state_->label_of.end() ? FeatureLabel() : it->second;
}

Slot SlotMesh::FindSlot(VertexId id) const { return state_->FindVertex(id); }

Slot SlotMesh::FindSimplexSlot(std::span<const VertexId> ids) const {
  return ids.size() == state_->width() ? state_->FindSimplex(ids.data()) : kNoSlot;
}

std::optional<SlotMesh::Vertex> SlotMesh::FindVertex(VertexId id) const {
  const Slot slot = FindSlot(id);
  if (slot == kNoSlot) return std::nullopt;
  Vertex vertex;
  std::copy_n(state_->points.data() + At(slot) * state_->d(), state_->d(),
              vertex.coordinates.begin());
  vertex.containing_dimension = state_->containing_dimensions[At(slot)];
  vertex.owner = state_->owners[At(slot)];
  return vertex;
}

bool SlotMesh::HasSimplex(std::span<const VertexId> ids) const {
  return FindSimplexSlot(ids) != kNoSlot;
}

std::optional<RegionId> SlotMesh::FindRegion(std::span<const VertexId> ids) const {
  const Slot slot = FindSimplexSlot(ids);
  if (slot == kNoSlot) return std::nullopt;
  return state_->regions[At(slot)];
}

bool SlotMesh::HasSubsegment(VertexId a, VertexId b, FeatureId owner) const {
  return state_->subsegments.slots.contains({std::min(a, b), std::max(a, b), owner});
}

bool SlotMesh::HasSubfacet(const std::array<VertexId, 3>& corners, FeatureId owner) const {
  const SubfacetColumns row = {{corners.begin(), corners.end()}, {owner}};
  return state_->subfacets.slots.contains(mesh_data::KeyOf(row, 0));
}

}  // namespace dynmesh
