#include "core/data/mesh_store.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/data/regions.h"
#include "core/data/text.h"

namespace dynmesh::data {
namespace {

bool Agree(int dimension, const VertexColumns& v) {
  const std::size_t n = v.ids.size();
  return v.coordinates.size() == n * static_cast<std::size_t>(dimension) &&
         v.containing_dimensions.size() == n && v.owners.size() == n;
}

bool Agree(int dimension, const SimplexColumn& s, const RegionColumn& regions) {
  const std::size_t corners = static_cast<std::size_t>(dimension) + 1;
  return s.size() % corners == 0 && (regions.empty() || regions.size() == s.size() / corners);
}

absl::Status BadColumns(std::string_view what) {
  return absl::InvalidArgumentError(Concat("the columns of ", what, " disagree in length"));
}

absl::Status CheckSets(const std::vector<RegionSet>& sets) {
  if (AreRegionSets(sets)) return absl::OkStatus();
  return absl::InvalidArgumentError("a region set is not what its id says, or out of order");
}

absl::Status CheckDimension(int dimension) {
  if (dimension == 2 || dimension == 3) return absl::OkStatus();
  return absl::InvalidArgumentError(Concat("dimension ", dimension, " is neither 2 nor 3"));
}

absl::Status Lost(std::string_view what, std::string_view trouble) {
  return absl::DataLossError(Concat(what, " ", trouble, ": take a new snapshot"));
}

RegionId RegionOfRow(const RegionColumn& regions, std::size_t row) {
  return regions.empty() ? kNoRegion : regions[row];
}

std::string VertexName(VertexId id) { return Concat("vertex ", Hex(id)); }

// Finds what a diff does to the pieces `held`, and adds to `hash`.
template <class Columns, class Set>
absl::Status NetPieces(const Set& held, const Columns& removed, const Columns& added,
                       MeshHash& hash) {
  const std::string what = Concat("a ", kPieceName<Columns>);
  Set gone, come;
  for (std::size_t i = 0; i < removed.size(); ++i) {
    const auto key = KeyOf(removed, i);
    if (!held.contains(key)) return Lost(what, "is to go but is absent");
    if (!gone.insert(key).second) return Lost(what, "goes twice");
    hash -= HashOf(key);
  }
  for (std::size_t i = 0; i < added.size(); ++i) {
    const auto key = KeyOf(added, i);
    if (held.contains(key) && !gone.contains(key)) {
      return Lost(what, "is to come but is present");
    }
    if (!come.insert(key).second) return Lost(what, "comes twice");
    hash += HashOf(key);
  }
  return absl::OkStatus();
}

template <class Columns, class Set>
void CommitPieces(const Columns& removed, const Columns& added, Set& held) {
  for (std::size_t i = 0; i < removed.size(); ++i) held.erase(KeyOf(removed, i));
  for (std::size_t i = 0; i < added.size(); ++i) held.insert(KeyOf(added, i));
}

template <class Columns, class Set>
Columns ToColumns(const Set& held) {
  Columns columns;
  for (const auto& key : held) Append(columns, key);
  return columns;
}

}  // namespace

absl::Status CheckColumns(const Mesh& mesh) {
  if (auto status = CheckDimension(mesh.dimension); !status.ok()) return status;
  if (!Agree(mesh.dimension, mesh.vertices)) return BadColumns("vertices");
  if (!Agree(mesh.dimension, mesh.simplices, mesh.regions)) return BadColumns("simplices");
  if (!Agree(mesh.subsegments)) return BadColumns("subsegments");
  if (!Agree(mesh.subfacets)) return BadColumns("subfacets");
  return CheckSets(mesh.region_sets);
}

absl::Status CheckColumns(const MeshDiff& diff) {
  if (auto status = CheckDimension(diff.dimension); !status.ok()) return status;
  if (!Agree(diff.dimension, diff.added_vertices)) return BadColumns("added vertices");
  if (!Agree(diff.dimension, diff.added_simplices, diff.added_regions)) {
    return BadColumns("added simplices");
  }
  if (!Agree(diff.dimension, diff.removed_simplices, diff.removed_regions)) {
    return BadColumns("removed simplices");
  }
  if (!Agree(diff.added_subsegments)) return BadColumns("added subsegments");
  if (!Agree(diff.removed_subsegments)) return BadColumns("removed subsegments");
  if (!Agree(diff.added_subfacets)) return BadColumns("added subfacets");
  if (!Agree(diff.removed_subfacets)) return BadColumns("removed subfacets");
  return CheckSets(diff.region_sets);
}

// What has been seen of a diff while nothing has been changed yet.
struct MeshStore::Netting {
  MeshHash hash;
  absl::flat_hash_set<VertexId> removed_vertices, added_vertices;
  absl::flat_hash_set<SimplexKey> removed_simplices, added_simplices;
};

MeshStore::SimplexKey MeshStore::MakeSimplexKey(const VertexId* ids, int count) {
  SimplexKey key = {0, 0, 0, 0};
  for (int i = 0; i < count; ++i) key[static_cast<std::size_t>(i)] = ids[i];
  return key;
}

absl::Status MeshStore::NetVertices(const MeshDiff& diff, Netting& netting) const {
  for (const VertexId id : diff.removed_vertices) {
    const auto it = vertices_.find(id);
    if (it == vertices_.end()) return Lost(VertexName(id), "is to go but is absent");
    if (!netting.removed_vertices.insert(id).second) return Lost(VertexName(id), "goes twice");
    const Vertex& v = it->second;
    netting.hash -= HashVertex(v.coordinates.data(), dimension_, v.containing_dimension, v.owner);
  }
  const VertexColumns& added = diff.added_vertices;
  for (std::size_t i = 0; i < added.size(); ++i) {
    const VertexId id = added.ids[i];
    if (vertices_.contains(id) && !netting.removed_vertices.contains(id)) {
      return Lost(VertexName(id), "is to come but is present");
    }
    if (!netting.added_vertices.insert(id).second) return Lost(VertexName(id), "comes twice");
    netting.hash += HashVertex(&added.coordinates[i * static_cast<std::size_t>(dimension_)],
                               dimension_, added.containing_dimensions[i], added.owners[i]);
  }
  return absl::OkStatus();
}

absl::Status MeshStore::NetSimplices(const MeshDiff& diff, Netting& netting) const {
  const int count = dimension_ + 1;
  const std::size_t width = static_cast<std::size_t>(count);
  for (std::size_t i = 0; i < diff.removed_simplex_count(); ++i) {
    const VertexId* ids = &diff.removed_simplices[i * width];
    const SimplexKey key = MakeSimplexKey(ids, count);
    const RegionId region = RegionOfRow(diff.removed_regions, i);
    // In another region it is another simplex, as a subsegment is with another owner. Not
    // left to the hash: who filters or adds up diffs believes their regions.
    const auto it = simplices_.find(key);
    if (it == simplices_.end() || it->second != region) {
      return Lost("a simplex", "is to go but is absent");
    }
    if (!netting.removed_simplices.insert(key).second) return Lost("a simplex", "goes twice");
    netting.hash -= HashSimplex(ids, count, region);
  }
  for (std::size_t i = 0; i < diff.added_simplex_count(); ++i) {
    const VertexId* ids = &diff.added_simplices[i * width];
    const SimplexKey key = MakeSimplexKey(ids, count);
    if (simplices_.contains(key) && !netting.removed_simplices.contains(key)) {
      return Lost("a simplex", "is to come but is present");
    }
    if (!netting.added_simplices.insert(key).second) return Lost("a simplex", "comes twice");
    netting.hash += HashSimplex(ids, count, RegionOfRow(diff.added_regions, i));
  }
  return absl::OkStatus();
}

absl::Status MeshStore::Apply(const MeshDiff& diff) {
  if (auto status = CheckColumns(diff); !status.ok()) return status;
  if (diff.dimension != dimension_) {
    return absl::InvalidArgumentError(
        Concat("a diff of dimension ", diff.dimension, " for a mesh of dimension ", dimension_));
  }
  if (diff.from_revision != revision_) {
    return absl::FailedPreconditionError(Concat("the diff starts at revision ", diff.from_revision,
                                                ", the mesh is at ", revision_,
                                                ": fetch what lies between, or a new snapshot"));
  }
  Netting netting;
  netting.hash = hash_;
  if (auto status = NetVertices(diff, netting); !status.ok()) return status;
  if (auto status = NetSimplices(diff, netting); !status.ok()) return status;
  if (auto status =
          NetPieces(subsegments_, diff.removed_subsegments, diff.added_subsegments, netting.hash);
      !status.ok()) {
    return status;
  }
  if (auto status =
          NetPieces(subfacets_, diff.removed_subfacets, diff.added_subfacets, netting.hash);
      !status.ok()) {
    return status;
  }
  if (netting.hash != diff.hash) {
    return Lost("the mesh", Concat("has hash ", netting.hash.ToHex(), " where ", diff.hash.ToHex(),
                                   " was promised"));
  }
  Commit(diff);
  return absl::OkStatus();
}

void MeshStore::Commit(const MeshDiff& diff) {
  const std::size_t d = static_cast<std::size_t>(dimension_);
  for (const VertexId id : diff.removed_vertices) vertices_.erase(id);
  for (std::size_t i = 0; i < diff.removed_simplex_count(); ++i) {
    simplices_.erase(MakeSimplexKey(&diff.removed_simplices[i * (d + 1)], dimension_ + 1));
  }
  CommitSets(diff);
  const VertexColumns& added = diff.added_vertices;
  for (std::size_t i = 0; i < added.size(); ++i) {
    Vertex vertex;
    for (std::size_t k = 0; k < d; ++k) vertex.coordinates[k] = added.coordinates[i * d + k];
    vertex.containing_dimension = added.containing_dimensions[i];
    vertex.owner = added.owners[i];
    vertices_.emplace(added.ids[i], vertex);
  }
  for (std::size_t i = 0; i < diff.added_simplex_count(); ++i) {
    simplices_.emplace(MakeSimplexKey(&diff.added_simplices[i * (d + 1)], dimension_ + 1),
                       RegionOfRow(diff.added_regions, i));
  }
  CommitPieces(diff.removed_subsegments, diff.added_subsegments, subsegments_);
  CommitPieces(diff.removed_subfacets, diff.added_subfacets, subfacets_);
  revision_ = diff.to_revision;
  hash_ = diff.hash;
}

// Additions first, so that a set which stays in use is not dropped in between.
void MeshStore::CommitSets(const MeshDiff& diff) {
  for (const RegionSet& set : diff.region_sets) {
    const auto [it, is_new] = sets_.try_emplace(set.id, set.polygons, 0);
    if (!is_new) it->second.first = set.polygons;  // may be another set's id now
  }
  if (sets_.empty()) return;
  for (const RegionId region : diff.added_regions) {
    if (const auto it = sets_.find(region); it != sets_.end()) ++it->second.second;
  }
  for (const RegionId region : diff.removed_regions) {
    if (const auto it = sets_.find(region); it != sets_.end()) --it->second.second;
  }
  for (const RegionSet& set : diff.region_sets) {
    if (sets_.at(set.id).second == 0) sets_.erase(set.id);
  }
}

absl::StatusOr<MeshStore> MeshStore::FromMesh(const Mesh& mesh) {
  if (auto status = CheckColumns(mesh); !status.ok()) return status;
  // A mesh is the diff from nothing: the same checks, the same hash.
  MeshDiff diff;
  diff.dimension = mesh.dimension;
  diff.to_revision = mesh.revision;
  diff.added_vertices = mesh.vertices;
  diff.added_simplices = mesh.simplices;
  diff.added_regions = mesh.regions;
  diff.region_sets = mesh.region_sets;
  diff.added_subsegments = mesh.subsegments;
  diff.added_subfacets = mesh.subfacets;
  diff.hash = mesh.hash;
  MeshStore store(mesh.dimension);
  store.vertices_.reserve(mesh.vertices.size());
  store.simplices_.reserve(mesh.simplex_count());
  if (auto status = store.Apply(diff); !status.ok()) return status;
  return store;
}

Mesh MeshStore::ToMesh() const {
  Mesh mesh;
  const std::size_t d = static_cast<std::size_t>(dimension_);
  mesh.dimension = dimension_;
  mesh.revision = revision_;
  mesh.hash = hash_;
  mesh.vertices.ids.reserve(vertices_.size());
  mesh.vertices.coordinates.reserve(vertices_.size() * d);
  mesh.vertices.containing_dimensions.reserve(vertices_.size());
  mesh.vertices.owners.reserve(vertices_.size());
  for (const auto& [id, vertex] : vertices_) {
    mesh.vertices.ids.push_back(id);
    for (std::size_t k = 0; k < d; ++k) {
      mesh.vertices.coordinates.push_back(vertex.coordinates[k]);
    }
    mesh.vertices.containing_dimensions.push_back(
        static_cast<std::uint8_t>(vertex.containing_dimension));
    mesh.vertices.owners.push_back(vertex.owner);
  }
  mesh.simplices.reserve(simplices_.size() * (d + 1));
  for (const auto& [key, region] : simplices_) {
    mesh.simplices.insert(mesh.simplices.end(), key.begin(),
                          key.begin() + static_cast<std::ptrdiff_t>(d) + 1);
  }
  AppendRegions(mesh);
  mesh.subsegments = ToColumns<SubsegmentColumns>(subsegments_);
  mesh.subfacets = ToColumns<SubfacetColumns>(subfacets_);
  return mesh;
}

void MeshStore::AppendRegions(Mesh& mesh) const {
  const auto is_labelled = [](const auto& entry) { return entry.second != kNoRegion; };
  if (std::none_of(simplices_.begin(), simplices_.end(), is_labelled)) return;
  mesh.regions.reserve(simplices_.size());
  for (const auto& [key, region] : simplices_) mesh.regions.push_back(region);
  for (const auto& [id, set] : sets_) mesh.region_sets.push_back({id, set.first});
  KeepNamed(mesh.region_sets, {&mesh.regions});
}

std::optional<MeshStore::Vertex> MeshStore::FindVertex(VertexId id) const {
  const auto it = vertices_.find(id);
  if (it == vertices_.end()) return std::nullopt;
  return it->second;
}

bool MeshStore::HasSimplex(std::span<const VertexId> ids) const {
  return FindRegion(ids).has_value();
}

std::optional<RegionId> MeshStore::FindRegion(std::span<const VertexId> ids) const {
  if (ids.size() != static_cast<std::size_t>(dimension_) + 1) return std::nullopt;
  const auto it = simplices_.find(MakeSimplexKey(ids.data(), dimension_ + 1));
  if (it == simplices_.end()) return std::nullopt;
  return it->second;
}

bool MeshStore::HasSubsegment(VertexId a, VertexId b, FeatureId owner) const {
  return subsegments_.contains({std::min(a, b), std::max(a, b), owner});
}

bool MeshStore::HasSubfacet(const std::array<VertexId, 3>& corners, FeatureId owner) const {
  const SubfacetColumns row = {{corners.begin(), corners.end()}, {owner}};
  return subfacets_.contains(KeyOf(row, 0));
}

}  // namespace dynmesh::data
