#include "server/diff_algebra.h"

#include <array>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "core/data/regions.h"

namespace dynmesh::server {
namespace {

using SimplexKey = std::array<std::uint64_t, 5>;     // ids, unused ones 0, and region
using SubsegmentKey = std::array<std::uint64_t, 3>;  // ends, owner

SimplexKey KeyOfSimplex(const SimplexColumn& column, const RegionColumn& regions, std::size_t row,
                        std::size_t corners) {
  SimplexKey key = {0, 0, 0, 0, kNoRegion};
  for (std::size_t i = 0; i < corners; ++i) key[i] = column[row * corners + i];
  if (!regions.empty()) key.back() = regions[row];
  return key;
}

SubsegmentKey KeyOfSubsegment(const SubsegmentColumns& column, std::size_t row) {
  return {column.ends[2 * row], column.ends[2 * row + 1], column.owners[row]};
}

void AddSubsegment(SubsegmentColumns& to, const SubsegmentKey& key) {
  to.ends.insert(to.ends.end(), {key[0], key[1]});
  to.owners.push_back(key[2]);
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

// Rows without content beside their key: what was removed and what was added, net.
template <typename Key>
class NetRows {
 public:
  void Remove(const Key& key) {
    if (added_.erase(key) == 0) removed_.insert(key);
  }
  void Add(const Key& key) {
    if (removed_.erase(key) == 0) added_.insert(key);
  }
  const auto& removed() const { return removed_; }
  const auto& added() const { return added_; }

 private:
  absl::flat_hash_set<Key> removed_, added_;
};

// Vertices carry content: a removal says only the id, so it can cancel an addition
// but no addition can cancel a removal.
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

absl::Status Missing(const char* what, const MeshDiff& diff) {
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
  data::DropIfIdle(out.regions);
  out.region_sets = mesh.region_sets;
  data::AppendSets(out.region_sets, diff.region_sets);
  data::KeepNamed(out.region_sets, {&out.regions});
  return absl::OkStatus();
}

absl::Status PatchSubsegments(const Mesh& mesh, const MeshDiff& diff, SubsegmentColumns& out) {
  absl::flat_hash_set<SubsegmentKey> gone;
  for (std::size_t i = 0; i < diff.removed_subsegments.size(); ++i) {
    gone.insert(KeyOfSubsegment(diff.removed_subsegments, i));
  }
  for (std::size_t i = 0; i < mesh.subsegments.size(); ++i) {
    const SubsegmentKey key = KeyOfSubsegment(mesh.subsegments, i);
    if (!gone.contains(key)) AddSubsegment(out, key);
  }
  if (out.size() + gone.size() != mesh.subsegments.size()) return Missing("a subsegment", diff);
  for (std::size_t i = 0; i < diff.added_subsegments.size(); ++i) {
    AddSubsegment(out, KeyOfSubsegment(diff.added_subsegments, i));
  }
  return absl::OkStatus();
}

std::size_t Bytes(const VertexColumns& v) {
  return v.ids.size() * 17 + v.coordinates.size() * sizeof(double);
}

std::size_t Bytes(const SubsegmentColumns& s) { return s.size() * 24; }

}  // namespace

std::size_t ByteSize(const MeshDiff& d) {
  return sizeof(MeshDiff) + Bytes(d.added_vertices) + Bytes(d.added_subsegments) +
         Bytes(d.removed_subsegments) +
         8 * (d.removed_vertices.size() + d.removed_simplices.size() + d.removed_regions.size() +
              d.added_simplices.size() + d.added_regions.size()) +
         data::ByteSize(d.region_sets);
}

std::size_t ByteSize(const Mesh& m) {
  return sizeof(Mesh) + Bytes(m.vertices) + Bytes(m.subsegments) +
         8 * (m.simplices.size() + m.regions.size()) + data::ByteSize(m.region_sets);
}

MeshDiff Compose(const std::vector<std::shared_ptr<const MeshDiff>>& diffs) {
  MeshDiff out;
  out.dimension = diffs.front()->dimension;
  out.from_revision = diffs.front()->from_revision;
  out.to_revision = diffs.back()->to_revision;
  out.hash = diffs.back()->hash;
  const auto corners = static_cast<std::size_t>(out.dimension) + 1;
  NetVertices vertices;
  NetRows<SimplexKey> simplices;
  NetRows<SubsegmentKey> subsegments;
  for (const auto& diff : diffs) {
    const MeshDiff& d = *diff;
    for (const VertexId id : d.removed_vertices) vertices.Remove(id);
    for (std::size_t i = 0; i < d.added_vertices.size(); ++i) {
      vertices.Add(d.added_vertices.ids[i], &d.added_vertices, i);
    }
    for (std::size_t i = 0; i < d.removed_simplex_count(); ++i) {
      simplices.Remove(KeyOfSimplex(d.removed_simplices, d.removed_regions, i, corners));
    }
    for (std::size_t i = 0; i < d.added_simplex_count(); ++i) {
      simplices.Add(KeyOfSimplex(d.added_simplices, d.added_regions, i, corners));
    }
    for (std::size_t i = 0; i < d.removed_subsegments.size(); ++i) {
      subsegments.Remove(KeyOfSubsegment(d.removed_subsegments, i));
    }
    for (std::size_t i = 0; i < d.added_subsegments.size(); ++i) {
      subsegments.Add(KeyOfSubsegment(d.added_subsegments, i));
    }
    data::AppendSets(out.region_sets, d.region_sets);
    out.work.executed += d.work.executed;
    out.work.created += d.work.created;
    out.work.dropped += d.work.dropped;
    out.work.microseconds += d.work.microseconds;
  }
  vertices.Write(out);
  for (const auto& key : simplices.removed()) {
    AddSimplex(out.removed_simplices, out.removed_regions, key, corners);
  }
  for (const auto& key : simplices.added()) {
    AddSimplex(out.added_simplices, out.added_regions, key, corners);
  }
  for (const auto& key : subsegments.removed()) AddSubsegment(out.removed_subsegments, key);
  for (const auto& key : subsegments.added()) AddSubsegment(out.added_subsegments, key);
  // The order of hash sets differs between runs; what is sent must not. Drops regions that
  // say nothing, too.
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
  if (absl::Status s = PatchSubsegments(mesh, diff, out.subsegments); !s.ok()) return s;
  return out;
}

}  // namespace dynmesh::server
