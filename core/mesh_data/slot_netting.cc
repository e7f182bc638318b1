// Netting: checks a diff against the mesh and computes its net effect. Changes nothing.
#include <algorithm>

#include "core/mesh_data/slot_state.h"

namespace dynmesh {

using mesh_data::At;
using mesh_data::Lost;
using mesh_data::RegionOfRow;
using mesh_data::VertexName;
using text::Concat;

absl::Status SlotMesh::State::NetVertices(const MeshDiff& diff, Netting& netting) const {
  for (const VertexId id : diff.removed_vertices) {
    const Slot slot = FindVertex(id);
    if (slot == kNoSlot) return Lost(VertexName(id), "is to go but is absent");
    if (!netting.removed_vertices.emplace(id, slot).second) {
      return Lost(VertexName(id), "goes twice");
    }
    netting.hash -= HashOfVertex(slot);
  }
  const VertexColumns& added = diff.added_vertices;
  for (std::size_t i = 0; i < added.size(); ++i) {
    const VertexId id = added.ids[i];
    if (id == 0) return Lost("a vertex", "has no id");
    if (vertices.contains(id) && !netting.removed_vertices.contains(id)) {
      return Lost(VertexName(id), "is to come but is present");
    }
    if (!netting.added_vertices.insert(id).second) return Lost(VertexName(id), "comes twice");
    // The same id with other coordinates (hash collision) is another vertex.
    const double* position = &added.coordinates[i * d()];
    const auto removed = netting.removed_vertices.find(id);
    const bool stays = removed != netting.removed_vertices.end() &&
                       std::equal(position, position + d(), &points[At(removed->second) * d()]);
    netting.kept_vertices.push_back(stays ? removed->second : kNoSlot);
    if (!stays && removed != netting.removed_vertices.end()) netting.replaced.insert(id);
    netting.hash +=
        HashVertex(position, dimension, added.containing_dimensions[i], added.owners[i]);
  }
  return absl::OkStatus();
}

absl::Status SlotMesh::State::NetSimplices(const MeshDiff& diff, Netting& netting) const {
  const int count = dimension + 1;
  for (std::size_t i = 0; i < diff.removed_simplex_count(); ++i) {
    const VertexId* row = &diff.removed_simplices[i * width()];
    const RegionId region = RegionOfRow(diff.removed_regions, i);
    // A simplex in another region is another simplex, as a subsegment with another owner is. The
    // check is explicit, not left to the hash: filters and sums of diffs rely on regions.
    const Slot slot = FindSimplex(row);
    if (slot == kNoSlot || regions[At(slot)] != region) {
      return Lost("a simplex", "is to go but is absent");
    }
    if (!netting.removed_simplices.insert(slot).second) return Lost("a simplex", "goes twice");
    netting.removed_rows.push_back(slot);
    netting.hash -= HashSimplex(row, count, region);
  }
  absl::flat_hash_set<IdKey> come;
  for (std::size_t i = 0; i < diff.added_simplex_count(); ++i) {
    const VertexId* row = &diff.added_simplices[i * width()];
    const Slot slot = FindSimplex(row);
    if (slot != kNoSlot && !netting.removed_simplices.contains(slot)) {
      return Lost("a simplex", "is to come but is present");
    }
    for (std::size_t k = 0; k < width(); ++k) {
      const bool is_there =
          netting.added_vertices.contains(row[k]) ||
          (vertices.contains(row[k]) && !netting.removed_vertices.contains(row[k]));
      if (!is_there) return Lost("a simplex", "has a corner that is absent");
    }
    if (!come.insert(IdsOfRow(row)).second) return Lost("a simplex", "comes twice");
    const bool stays = std::none_of(row, row + width(),
                                    [&](VertexId id) { return netting.replaced.contains(id); });
    netting.kept_simplices.push_back(stays ? slot : kNoSlot);
    netting.hash += HashSimplex(row, count, RegionOfRow(diff.added_regions, i));
  }
  return absl::OkStatus();
}

absl::Status SlotMesh::State::Net(const MeshDiff& diff, Netting& netting) const {
  netting.hash = hash;
  if (auto status = NetVertices(diff, netting); !status.ok()) return status;
  if (auto status = NetSimplices(diff, netting); !status.ok()) return status;
  const auto net_pieces = [&](const auto& table, const auto& removed, const auto& added) {
    return table.Net(removed, added, netting.hash);
  };
  if (auto s = net_pieces(subsegments, diff.removed_subsegments, diff.added_subsegments); !s.ok()) {
    return s;
  }
  if (auto s = net_pieces(subfacets, diff.removed_subfacets, diff.added_subfacets); !s.ok()) {
    return s;
  }
  for (const auto* ends : {&diff.added_subsegments.ends, &diff.added_subfacets.corners}) {
    for (const VertexId id : *ends) {
      if (!netting.added_vertices.contains(id) && !vertices.contains(id)) {
        return Lost("a subsegment or subfacet", "has a corner that is absent");
      }
    }
  }
  if (netting.hash != diff.hash) {
    return Lost("the mesh", Concat("has hash ", netting.hash.ToHex(), " where ", diff.hash.ToHex(),
                                   " was promised"));
  }
  return absl::OkStatus();
}

// If an id stands for another vertex after the diff (hash collision), rows that name it by id alone
// are the same before and after, and the diff omits them. As slots they change: here they are
// removed and added. O(mesh).
MeshDiff SlotMesh::State::WithReplaced(MeshDiff diff, const Netting& netting) const {
  const auto is_replaced = [&](VertexId id) { return netting.replaced.contains(id); };
  const bool labels = labelled > 0 || !diff.removed_regions.empty() || !diff.added_regions.empty();
  if (labels) {
    diff.removed_regions.resize(diff.removed_simplex_count(), kNoRegion);
    diff.added_regions.resize(diff.added_simplex_count(), kNoRegion);
  }
  for (const Slot slot : simplices) {
    const IdKey key = IdsOfCell(slot);
    const auto end = key.begin() + static_cast<std::ptrdiff_t>(width());
    if (netting.removed_simplices.contains(slot) || std::none_of(key.begin(), end, is_replaced)) {
      continue;
    }
    for (auto* column : {&diff.removed_simplices, &diff.added_simplices}) {
      column->insert(column->end(), key.begin(), end);
    }
    if (!labels) continue;
    diff.removed_regions.push_back(regions[At(slot)]);
    diff.added_regions.push_back(regions[At(slot)]);
  }
  subsegments.AddReplaced(is_replaced, diff.removed_subsegments, diff.added_subsegments);
  subfacets.AddReplaced(is_replaced, diff.removed_subfacets, diff.added_subfacets);
  return diff;
}

}  // namespace dynmesh
