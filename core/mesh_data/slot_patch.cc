// Committing: applies a netted diff and records its effect in the patch.
#include <algorithm>
#include <utility>

#include "core/mesh_data/slot_state.h"

namespace dynmesh {

using mesh_data::At;
using mesh_data::RegionOfRow;

// From now on the slots that the last patch freed may be filled.
void SlotMesh::State::BeginPatch() {
  const auto free = [](const std::vector<Slot>& slots, mesh_data::SlotPool& pool) {
    pool.free.insert(pool.free.end(), slots.rbegin(), slots.rend());
  };
  free(patch.removed_vertices, vertex_pool);
  free(patch.removed_simplices, simplex_pool);
  going = Patch();
  patch = MeshPatch();
  patch.from_revision = patch.to_revision = revision;
}

// A simplex from before the patch is recorded. One that the patch added is forgotten.
void SlotMesh::State::RemoveSimplices(const MeshDiff& diff, const Netting& netting,
                                      mesh_data::FaceLinks& faces) {
  const absl::flat_hash_set<Slot> kept(netting.kept_simplices.begin(),
                                       netting.kept_simplices.end());
  const auto is_gone = [&](Slot slot) {
    return netting.removed_simplices.contains(slot) && !kept.contains(slot);
  };
  for (std::size_t i = 0; i < netting.removed_rows.size(); ++i) {
    const Slot slot = netting.removed_rows[i];
    if (kept.contains(slot)) continue;
    const SlotKey corners = KeyOfCell(slot);
    for (std::size_t k = 0; k < width(); ++k) {
      const Slot other = neighbours[At(slot) * width() + k];
      if (other == kNoSlot || is_gone(other)) continue;
      for (std::size_t j = 0; j < width(); ++j) {
        Slot& back = neighbours[At(other) * width() + j];
        if (back != slot) continue;
        back = kNoSlot;
        faces.Add(corners.data(), width(), k, other, j);
      }
    }
    simplices.erase(slot);
    if (!going.come_simplices.contains(slot)) {
      RegionId region = regions[At(slot)];
      if (const auto it = going.relabelled.find(slot); it != going.relabelled.end()) {
        region = it->second;
        going.relabelled.erase(it);
      }
      going.gone_simplices.emplace(IdsOfRow(&diff.removed_simplices[i * width()]),
                                   GoneSimplex{slot, corners, region});
    }
  }
  // Rows are cleared when they are not needed for lookups any more.
  for (const Slot slot : netting.removed_rows) {
    if (kept.contains(slot)) continue;
    for (std::size_t k = 0; k < width(); ++k) {
      cells[At(slot) * width() + k] = neighbours[At(slot) * width() + k] = kNoSlot;
    }
    labelled -= regions[At(slot)] != kNoRegion;
    regions[At(slot)] = kNoRegion;
    if (going.come_simplices.erase(slot) > 0) simplex_pool.free.push_back(slot);
  }
}

void SlotMesh::State::RemoveVertices(const MeshDiff& diff, const Netting& netting) {
  const absl::flat_hash_set<Slot> kept(netting.kept_vertices.begin(), netting.kept_vertices.end());
  for (const VertexId id : diff.removed_vertices) {
    const Slot slot = netting.removed_vertices.at(id);
    if (kept.contains(slot)) continue;
    vertices.erase(id);
    ids[At(slot)] = 0;
    if (going.come_vertices.erase(slot) > 0) {
      vertex_pool.free.push_back(slot);
    } else {
      going.gone_vertices.emplace(id, slot);
    }
  }
}

void SlotMesh::State::PlaceVertex(Slot slot, VertexId id, const double* position, int containing,
                                  FeatureId owner) {
  const std::size_t end = At(vertex_pool.end);
  points.resize(end * d(), 0), ids.resize(end, 0);
  containing_dimensions.resize(end, 0), owners.resize(end, kNoFeature);
  std::copy_n(position, d(), &points[At(slot) * d()]);
  ids[At(slot)] = id;
  containing_dimensions[At(slot)] = static_cast<std::uint8_t>(containing);
  owners[At(slot)] = owner;
}

// A vertex that was removed earlier in the patch returns to its slot.
void SlotMesh::State::AddVertices(const MeshDiff& diff, const Netting& netting) {
  const VertexColumns& added = diff.added_vertices;
  for (std::size_t i = 0; i < added.size(); ++i) {
    const double* position = &added.coordinates[i * d()];
    Slot slot = netting.kept_vertices[i];
    const auto gone = going.gone_vertices.find(added.ids[i]);
    if (slot == kNoSlot && gone != going.gone_vertices.end() &&
        std::equal(position, position + d(), &points[At(gone->second) * d()])) {
      slot = gone->second;
      going.gone_vertices.erase(gone);
    } else if (slot == kNoSlot) {
      slot = vertex_pool.Take();
      going.come_vertices.insert(slot);
    }
    vertices.insert_or_assign(added.ids[i], slot);
    PlaceVertex(slot, added.ids[i], position, added.containing_dimensions[i], added.owners[i]);
  }
}

bool SlotMesh::State::PlaceSimplex(Slot slot, const SlotKey& corners, RegionId region) {
  const std::size_t end = At(simplex_pool.end);
  cells.resize(end * width(), kNoSlot), neighbours.resize(end * width(), kNoSlot);
  regions.resize(end, kNoRegion);
  for (std::size_t k = 0; k < width(); ++k) {
    cells[At(slot) * width() + k] = corners[k];
    neighbours[At(slot) * width() + k] = kNoSlot;
  }
  regions[At(slot)] = region;
  labelled += region != kNoRegion;
  return simplices.insert(slot).second;
}

void SlotMesh::State::RelabelSimplex(Slot slot, RegionId region) {
  if (!going.come_simplices.contains(slot)) {
    const auto [it, is_new] = going.relabelled.try_emplace(slot, regions[At(slot)]);
    if (!is_new && it->second == region) going.relabelled.erase(it);
  }
  labelled -= regions[At(slot)] != kNoRegion;
  labelled += region != kNoRegion;
  regions[At(slot)] = region;
}

// A simplex that was removed earlier in the patch returns to its slot.
void SlotMesh::State::AddSimplices(const MeshDiff& diff, const Netting& netting,
                                   mesh_data::FaceLinks& faces) {
  for (std::size_t i = 0; i < diff.added_simplex_count(); ++i) {
    const RegionId region = RegionOfRow(diff.added_regions, i);
    Slot slot = netting.kept_simplices[i];
    if (slot != kNoSlot) {
      RelabelSimplex(slot, region);
      continue;
    }
    const VertexId* row = &diff.added_simplices[i * width()];
    SlotKey corners;
    SlotsOfRow(row, corners);
    const auto gone = going.gone_simplices.find(IdsOfRow(row));
    if (gone != going.gone_simplices.end() && gone->second.corners == corners) {
      slot = gone->second.slot;
      if (gone->second.region != region) going.relabelled.emplace(slot, gone->second.region);
      going.gone_simplices.erase(gone);
    } else {
      slot = simplex_pool.Take();
      going.come_simplices.insert(slot);
    }
    PlaceSimplex(slot, corners, region);
    for (std::size_t k = 0; k < width(); ++k) faces.Add(corners.data(), width(), k, slot, k);
  }
}

// Additions first: a set that stays in use is not dropped meanwhile.
void SlotMesh::State::CommitSets(const MeshDiff& diff) {
  for (const RegionSet& set : diff.region_sets) {
    const auto [it, is_new] = sets.try_emplace(set.id, set.polygons, 0);
    if (!is_new) it->second.first = set.polygons;  // the id may stand for another set now
  }
  if (sets.empty()) return;
  for (const RegionId region : diff.added_regions) {
    if (const auto it = sets.find(region); it != sets.end()) ++it->second.second;
  }
  for (const RegionId region : diff.removed_regions) {
    if (const auto it = sets.find(region); it != sets.end()) --it->second.second;
  }
  for (const RegionSet& set : diff.region_sets) {
    if (sets.at(set.id).second == 0) sets.erase(set.id);
  }
}

void SlotMesh::State::CommitLabels(const LabelColumn& changes) {
  for (const LabelOfFeature& row : changes) {
    if (row.label.empty()) {
      label_of.erase(row.id);
    } else {
      label_of.insert_or_assign(row.id, row.label);
    }
  }
}

void SlotMesh::State::Commit(const MeshDiff& diff, const Netting& netting, bool extends) {
  if (!extends) BeginPatch();
  mesh_data::FaceLinks faces;
  RemoveSimplices(diff, netting, faces);
  RemoveVertices(diff, netting);
  CommitSets(diff);
  AddVertices(diff, netting);
  AddSimplices(diff, netting, faces);
  faces.Link(neighbours.data(), width());
  const auto slot_of = [this](VertexId id) { return FindVertex(id); };
  subsegments.Commit(diff.removed_subsegments, diff.added_subsegments, slot_of);
  subfacets.Commit(diff.removed_subfacets, diff.added_subfacets, slot_of);
  CommitLabels(diff.labels);
  revision = diff.to_revision;
  hash = diff.hash;
  WritePatch();
}

// Writes `going` to the patch in the order of ids.
void SlotMesh::State::WritePatch() {
  const auto by_key = [](auto& rows, auto&& write) {
    std::sort(rows.begin(), rows.end());
    for (const auto& row : rows) write(row);
  };
  const std::uint64_t from = patch.from_revision;
  patch = MeshPatch();
  patch.from_revision = from, patch.to_revision = revision;
  std::vector<std::pair<VertexId, Slot>> vertices_by_id(going.gone_vertices.begin(),
                                                        going.gone_vertices.end());
  by_key(vertices_by_id, [&](const auto& v) { patch.removed_vertices.push_back(v.second); });
  vertices_by_id.clear();
  for (const Slot slot : going.come_vertices) vertices_by_id.emplace_back(ids[At(slot)], slot);
  by_key(vertices_by_id, [&](const auto& v) { patch.added_vertices.push_back(v.second); });

  std::vector<std::pair<IdKey, const GoneSimplex*>> gone;
  for (const auto& [key, simplex] : going.gone_simplices) gone.emplace_back(key, &simplex);
  by_key(gone, [&](const auto& row) {
    patch.removed_simplices.push_back(row.second->slot);
    patch.removed_corners.insert(
        patch.removed_corners.end(), row.second->corners.begin(),
        row.second->corners.begin() + static_cast<std::ptrdiff_t>(width()));
    patch.removed_regions.push_back(row.second->region);
  });
  std::vector<std::pair<IdKey, Slot>> simplices_by_ids;
  for (const Slot slot : going.come_simplices) simplices_by_ids.emplace_back(IdsOfCell(slot), slot);
  by_key(simplices_by_ids, [&](const auto& s) { patch.added_simplices.push_back(s.second); });
  simplices_by_ids.clear();
  for (const auto& [slot, former] : going.relabelled) {
    simplices_by_ids.emplace_back(IdsOfCell(slot), slot);
  }
  by_key(simplices_by_ids, [&](const auto& s) {
    patch.relabelled_simplices.push_back(s.second);
    patch.former_regions.push_back(going.relabelled.at(s.second));
  });
}

}  // namespace dynmesh
