#include "server/revisions/diff_algebra.h"

#include <array>
#include <utility>

#include "absl/container/btree_map.h"
#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "core/mesh_data/constraints.h"
#include "core/mesh_data/labels.h"
#include "core/mesh_data/regions.h"

namespace dynmesh::server {
namespace {

using SimplexKey = std::array<std::uint64_t, 5>;  // ids, unused ones 0, then the region

SimplexKey KeyOfSimplex(const SimplexColumn& column, const RegionColumn& regions, std::size_t row,
                        std::size_t corners) {
  SimplexKey key = {0, 0, 0, 0, kNoRegion};
  for (std::size_t i = 0; i < corners; ++i) key[i] = column[row * corners + i];
  if (!regions.empty()) key.back() = regions[row];
  return key;
}

void AddSimplex(SimplexColumn& to, RegionColumn& regions, const SimplexKey& key,
                std::size_t corners) {
  to.insert(to.end(), key.begin(), key.begin() + static_cast<std::ptrdiff_t>(corners));
  regions.push_back(key.back());
}

void AddVertex(VertexColumns& to, const VertexColumns& from, std::size_t row,
               std::size_t dimension) {
  to.ids.push_back(from.ids[row]);
  const double* x = from.coordinates.data() + row * dimension;
  to.coordinates.insert(to.coordinates.end(), x, x + dimension);
  to.containing_dimensions.push_back(from.containing_dimensions[row]);
  to.owners.push_back(from.owners[row]);
}

// The net change of rows that consist of a key only.
template <typename Key>
class NetRows {
 public:
  void Remove(const Key& key) {
    if (added_.erase(key) == 0) removed_.insert(key);
  }
  // `is_other`: the row differs from the one removed under that key.
  void Add(const Key& key, bool is_other = false) {
    if (is_other || removed_.erase(key) == 0) added_.insert(key);
  }
  const auto& removed() const { return removed_; }
  const auto& added() const { return added_; }

 private:
  absl::flat_hash_set<Key> removed_, added_;
};

// Region ids that `sets` gives with different polygons. Such edits are possible.
absl::flat_hash_set<RegionId> IdsOfSeveral(const std::vector<RegionSet>& sets) {
  absl::flat_hash_map<RegionId, const std::vector<FeatureId>*> polygons;
  absl::flat_hash_set<RegionId> ids;
  for (const RegionSet& set : sets) {
    const auto [it, is_new] = polygons.try_emplace(set.id, &set.polygons);
    if (!is_new && *it->second != set.polygons) ids.insert(set.id);
  }
  return ids;
}

template <class Columns>
class NetConstraints {
 public:
  void Apply(const Columns& removed, const Columns& added) {
    for (std::size_t i = 0; i < removed.size(); ++i) rows_.Remove(mesh_data::KeyOf(removed, i));
    for (std::size_t i = 0; i < added.size(); ++i) rows_.Add(mesh_data::KeyOf(added, i));
  }
  void Write(Columns& removed, Columns& added) const {
    for (const auto& key : rows_.removed()) mesh_data::Append(removed, key);
    for (const auto& key : rows_.added()) mesh_data::Append(added, key);
  }

 private:
  NetRows<mesh_data::ConstraintKey<Columns>> rows_;
};

// Vertices have content, and a removal has the id only. So a removal cancels an earlier addition,
// but an addition does not cancel an earlier removal.
class NetVertices {
 public:
  void Remove(VertexId id) {
    if (added_.erase(id) == 0) removed_.insert(id);
  }
  void Add(VertexId id, const VertexColumns* columns, std::size_t row) {
    added_[id] = {columns, row};
  }
  void Write(MeshDiff& out) const {
    out.removed_vertices.assign(removed_.begin(), removed_.end());
    for (const auto& [id, place] : added_) {
      AddVertex(out.added_vertices, *place.first, place.second,
                static_cast<std::size_t>(out.dimension));
    }
  }

 private:
  absl::flat_hash_set<VertexId> removed_;
  absl::flat_hash_map<VertexId, std::pair<const VertexColumns*, std::size_t>> added_;
};

absl::Status Missing(absl::string_view what, const MeshDiff& diff) {
  return absl::DataLossError(absl::StrCat("the diff to revision ", diff.to_revision, " removes ",
                                          what, " that the mesh does not have"));
}

absl::Status PatchVertices(const Mesh& mesh, const MeshDiff& diff, VertexColumns& out) {
  const auto dimension = static_cast<std::size_t>(mesh.dimension);
  const absl::flat_hash_set<VertexId> gone(diff.removed_vertices.begin(),
                                           diff.removed_vertices.end());
  const std::size_t room = mesh.vertices.size() + diff.added_vertices.size();
  out.ids.reserve(room);
  out.coordinates.reserve(room * dimension);
  out.containing_dimensions.reserve(room);
  out.owners.reserve(room);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!gone.contains(mesh.vertices.ids[i])) AddVertex(out, mesh.vertices, i, dimension);
  }
  if (out.size() + gone.size() != mesh.vertices.size()) return Missing("a vertex", diff);
  for (std::size_t i = 0; i < diff.added_vertices.size(); ++i) {
    AddVertex(out, diff.added_vertices, i, dimension);
  }
  return absl::OkStatus();
}

absl::Status PatchSimplices(const Mesh& mesh, const MeshDiff& diff, Mesh& out) {
  const auto corners = static_cast<std::size_t>(mesh.dimension) + 1;
  const bool labelled = !mesh.regions.empty() || !diff.added_regions.empty();
  absl::flat_hash_set<SimplexKey> gone;
  for (std::size_t i = 0; i < diff.removed_simplex_count(); ++i) {
    gone.insert(KeyOfSimplex(diff.removed_simplices, diff.removed_regions, i, corners));
  }
  const std::size_t room = mesh.simplex_count() + diff.added_simplex_count();
  out.simplices.reserve(room * corners);
  if (labelled) out.regions.reserve(room);
  for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
    const SimplexKey key = KeyOfSimplex(mesh.simplices, mesh.regions, i, corners);
    if (gone.contains(key)) continue;
    const VertexId* const ids = &mesh.simplices[i * corners];
    out.simplices.insert(out.simplices.end(), ids, ids + corners);
    if (labelled) out.regions.push_back(key.back());
  }
  if (out.simplex_count() + gone.size() != mesh.simplex_count()) return Missing("a simplex", diff);
  out.simplices.insert(out.simplices.end(), diff.added_simplices.begin(),
                       diff.added_simplices.end());
  if (!labelled) return absl::OkStatus();
  out.regions.insert(out.regions.end(), diff.added_regions.begin(), diff.added_regions.end());
  out.regions.resize(out.simplex_count(), kNoRegion);
  mesh_data::DropIfIdle(out.regions);
  out.region_sets = diff.region_sets;  // where ids agree, these take precedence
  mesh_data::AppendSets(out.region_sets, mesh.region_sets);
  mesh_data::KeepNamed(out.region_sets, {&out.regions});
  return absl::OkStatus();
}

template <class Columns>
absl::Status PatchConstraints(const Columns& held, const MeshDiff& diff, const Columns& removed,
                              const Columns& added, Columns& out) {
  absl::flat_hash_set<mesh_data::ConstraintKey<Columns>> gone;
  for (std::size_t i = 0; i < removed.size(); ++i) gone.insert(mesh_data::KeyOf(removed, i));
  for (std::size_t i = 0; i < held.size(); ++i) {
    const auto key = mesh_data::KeyOf(held, i);
    if (!gone.contains(key)) mesh_data::Append(out, key);
  }
  if (out.size() + gone.size() != held.size()) {
    return Missing(absl::StrCat("a ", mesh_data::kConstraintName<Columns>), diff);
  }
  for (std::size_t i = 0; i < added.size(); ++i) mesh_data::Append(out, mesh_data::KeyOf(added, i));
  return absl::OkStatus();
}

std::size_t Bytes(const VertexColumns& v) {
  return v.ids.size() * 17 + v.coordinates.size() * sizeof(double);
}

}  // namespace

std::size_t ByteSize(const MeshDiff& d) {
  return sizeof(MeshDiff) + Bytes(d.added_vertices) + mesh_data::ByteSize(d.added_subsegments) +
         mesh_data::ByteSize(d.removed_subsegments) + mesh_data::ByteSize(d.added_subfacets) +
         mesh_data::ByteSize(d.removed_subfacets) +
         8 * (d.removed_vertices.size() + d.removed_simplices.size() + d.removed_regions.size() +
              d.added_simplices.size() + d.added_regions.size()) +
         mesh_data::ByteSize(d.region_sets) + mesh_data::ByteSize(d.labels);
}

std::size_t ByteSize(const Mesh& m) {
  return sizeof(Mesh) + Bytes(m.vertices) + mesh_data::ByteSize(m.subsegments) +
         mesh_data::ByteSize(m.subfacets) + 8 * (m.simplices.size() + m.regions.size()) +
         mesh_data::ByteSize(m.region_sets) + mesh_data::ByteSize(m.labels);
}

MeshDiff Compose(const std::vector<std::shared_ptr<const MeshDiff>>& diffs) {
  MeshDiff out;
  out.dimension = diffs.front()->dimension;
  out.from_revision = diffs.front()->from_revision;
  out.to_revision = diffs.back()->to_revision;
  out.hash = diffs.back()->hash;
  const auto corners = static_cast<std::size_t>(out.dimension) + 1;
  NetVertices vertices;
  // For each id the last set counts.
  for (auto diff = diffs.rbegin(); diff != diffs.rend(); ++diff) {
    mesh_data::AppendSets(out.region_sets, (*diff)->region_sets);
  }
  const absl::flat_hash_set<RegionId> others = IdsOfSeveral(out.region_sets);
  NetRows<SimplexKey> simplices;
  NetConstraints<SubsegmentColumns> subsegments;
  NetConstraints<SubfacetColumns> subfacets;
  absl::btree_map<FeatureId, const FeatureLabel*> labels;
  for (const auto& diff : diffs) {
    const MeshDiff& d = *diff;
    for (const VertexId id : d.removed_vertices) vertices.Remove(id);
    for (std::size_t i = 0; i < d.added_vertices.size(); ++i) {
      vertices.Add(d.added_vertices.ids[i], &d.added_vertices, i);
    }
    // A diff removes and adds a simplex in one region iff the region's set of polygons changed.
    absl::flat_hash_set<SimplexKey> gone;
    for (std::size_t i = 0; i < d.removed_simplex_count(); ++i) {
      const SimplexKey key = KeyOfSimplex(d.removed_simplices, d.removed_regions, i, corners);
      simplices.Remove(key);
      if (key.back() > kLastPolygonId) gone.insert(key);
    }
    for (std::size_t i = 0; i < d.added_simplex_count(); ++i) {
      const SimplexKey key = KeyOfSimplex(d.added_simplices, d.added_regions, i, corners);
      simplices.Add(key, others.contains(key.back()) || gone.contains(key));
    }
    subsegments.Apply(d.removed_subsegments, d.added_subsegments);
    subfacets.Apply(d.removed_subfacets, d.added_subfacets);
    for (const LabelOfFeature& row : d.labels) labels[row.id] = &row.label;
    out.work.executed += d.work.executed;
    out.work.created += d.work.created;
    out.work.dropped += d.work.dropped;
    out.work.microseconds += d.work.microseconds;
    out.work.validate_microseconds += d.work.validate_microseconds;
    out.work.diff_microseconds += d.work.diff_microseconds;
    out.work.notified += d.work.notified;
    out.work.visited_cells += d.work.visited_cells;
    out.work.visited_nodes += d.work.visited_nodes;
  }
  vertices.Write(out);
  for (const auto& key : simplices.removed()) {
    AddSimplex(out.removed_simplices, out.removed_regions, key, corners);
  }
  for (const auto& key : simplices.added()) {
    AddSimplex(out.added_simplices, out.added_regions, key, corners);
  }
  subsegments.Write(out.removed_subsegments, out.added_subsegments);
  subfacets.Write(out.removed_subfacets, out.added_subfacets);
  for (const auto& [id, label] : labels) out.labels.push_back({id, *label});
  // Hash sets iterate in a different order in each run; the output must not depend on it. Also
  // drops entries without information.
  Canonicalize(out);
  return out;
}

absl::StatusOr<Mesh> Patched(const Mesh& mesh, const MeshDiff& diff) {
  if (mesh.revision != diff.from_revision || mesh.dimension != diff.dimension) {
    return absl::FailedPreconditionError("the diff does not continue the mesh");
  }
  Mesh out;
  out.dimension = mesh.dimension;
  out.revision = diff.to_revision;
  out.hash = diff.hash;
  if (absl::Status s = PatchVertices(mesh, diff, out.vertices); !s.ok()) return s;
  if (absl::Status s = PatchSimplices(mesh, diff, out); !s.ok()) return s;
  const auto patch = [&](auto column, auto removed, auto added) {
    return PatchConstraints(mesh.*column, diff, diff.*removed, diff.*added, out.*column);
  };
  if (absl::Status s =
          patch(&Mesh::subsegments, &MeshDiff::removed_subsegments, &MeshDiff::added_subsegments);
      !s.ok()) {
    return s;
  }
  if (absl::Status s =
          patch(&Mesh::subfacets, &MeshDiff::removed_subfacets, &MeshDiff::added_subfacets);
      !s.ok()) {
    return s;
  }
  out.labels = mesh_data::ChangedLabels(mesh.labels, diff.labels);
  return out;
}

}  // namespace dynmesh::server
