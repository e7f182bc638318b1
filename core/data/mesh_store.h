// A replica of a mesh: takes diffs in time proportional to the diff, and proves
// itself equal to the original by the hash after each.
//
// Invariants:
//   1. hash() is the sum of the hashes of the rows held (ComputeHash);
//   2. ids, simplices, subsegments and subfacets are each held once, region sets while in use;
//   3. a call that returns an error has changed nothing.
// Thread-compatible. Copies are deep; readers that must not wait want their own.
#ifndef DYNMESH_CORE_DATA_MESH_STORE_H_
#define DYNMESH_CORE_DATA_MESH_STORE_H_

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/data/pieces.h"
#include "dynmesh/mesh.h"

namespace dynmesh::data {

class MeshStore {
 public:
  struct Vertex {
    std::array<double, 3> coordinates = {0, 0, 0};  // entries past the dimension are 0
    int containing_dimension = 0;
    FeatureId owner = kNoFeature;
  };

  // No part at all, revision 0, hash 0: what the diff from nothing applies to.
  explicit MeshStore(int dimension = 2) : dimension_(dimension) {}

  // Takes over a whole mesh (a snapshot). INVALID_ARGUMENT if CheckColumns says so;
  // DATA_LOSS if a part stands twice or mesh.hash is not that of the parts.
  static absl::StatusOr<MeshStore> FromMesh(const Mesh& mesh);

  // Becomes diff.to_revision, in O(diff). INVALID_ARGUMENT if
  // CheckColumns says so or the dimension differs; FAILED_PRECONDITION unless
  // diff.from_revision is revision(); DATA_LOSS if a part to remove is absent (a simplex:
  // in that region), one to add is present, or the hash does not come out as diff.hash.
  absl::Status Apply(const MeshDiff& diff);

  // The whole mesh, O(size). Rows in no particular order.
  Mesh ToMesh() const;

  int dimension() const { return dimension_; }
  std::uint64_t revision() const { return revision_; }
  MeshHash hash() const { return hash_; }
  std::size_t vertex_count() const { return vertices_.size(); }
  std::size_t simplex_count() const { return simplices_.size(); }
  std::size_t subsegment_count() const { return subsegments_.size(); }
  std::size_t subfacet_count() const { return subfacets_.size(); }

  std::optional<Vertex> FindVertex(VertexId id) const;
  // `ids` in canonical order, dimension + 1 of them.
  bool HasSimplex(std::span<const VertexId> ids) const;
  // Of such a simplex.
  std::optional<RegionId> FindRegion(std::span<const VertexId> ids) const;
  bool HasSubsegment(VertexId a, VertexId b, FeatureId owner) const;
  bool HasSubfacet(const std::array<VertexId, 3>& corners, FeatureId owner) const;  // any order

 private:
  using SimplexKey = std::array<VertexId, 4>;  // unused entries 0, which no id is
  template <class Columns>
  using PieceSet = absl::flat_hash_set<PieceKey<Columns>>;
  struct Netting;

  static SimplexKey MakeSimplexKey(const VertexId* ids, int count);

  // Each finds what the diff does to one kind of row, and adds to netting.hash.
  absl::Status NetVertices(const MeshDiff& diff, Netting& netting) const;
  absl::Status NetSimplices(const MeshDiff& diff, Netting& netting) const;
  void Commit(const MeshDiff& diff);
  void CommitSets(const MeshDiff& diff);
  void AppendRegions(Mesh& mesh) const;  // of the simplices, in their order here

  int dimension_;
  std::uint64_t revision_ = 0;
  MeshHash hash_;
  absl::flat_hash_map<VertexId, Vertex> vertices_;
  absl::flat_hash_map<SimplexKey, RegionId> simplices_;
  // Polygons and number of simplices, of regions in several polygons.
  absl::flat_hash_map<RegionId, std::pair<std::vector<FeatureId>, std::size_t>> sets_;
  PieceSet<SubsegmentColumns> subsegments_;
  PieceSet<SubfacetColumns> subfacets_;
};

// INVALID_ARGUMENT unless the columns of the mesh or diff agree in length and the region
// sets are such, by ascending id.
absl::Status CheckColumns(const Mesh& mesh);
absl::Status CheckColumns(const MeshDiff& diff);

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_MESH_STORE_H_
