// The state of a SlotMesh. A diff is first netted: checked against the mesh, without a change
// (slot_netting.cc). Then it is committed, which cannot fail (slot_patch.cc). A whole mesh is
// filled in (slot_fill.cc). Only for these files and slot_mesh.cc.
#ifndef DYNMESH_CORE_MESH_DATA_SLOT_STATE_H_
#define DYNMESH_CORE_MESH_DATA_SLOT_STATE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/status/status.h"
#include "core/base/text.h"
#include "core/mesh_data/face_links.h"
#include "core/mesh_data/slot_columns.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh {

struct SlotMesh::State {
  // Ids or slots of a simplex's corners; unused entries are 0 or kNoSlot.
  using IdKey = std::array<VertexId, 4>;
  using SlotKey = std::array<Slot, 4>;

  // Hashes a simplex by the corners in its row: no second copy of these.
  struct CellHash {
    using is_transparent = void;
    const State* state;
    std::size_t operator()(Slot slot) const { return (*this)(state->KeyOfCell(slot)); }
    std::size_t operator()(const SlotKey& key) const { return absl::HashOf(key); }
  };
  struct CellEqual {
    using is_transparent = void;
    const State* state;
    bool operator()(Slot a, Slot b) const {
      return a == b || state->KeyOfCell(a) == state->KeyOfCell(b);
    }
    bool operator()(Slot a, const SlotKey& key) const { return state->KeyOfCell(a) == key; }
    bool operator()(const SlotKey& key, Slot a) const { return state->KeyOfCell(a) == key; }
  };
  using CellSet = absl::flat_hash_set<Slot, CellHash, CellEqual>;

  // The effect of the patch so far.
  struct GoneSimplex {
    Slot slot;
    SlotKey corners;
    RegionId region;
  };
  struct Patch {
    absl::flat_hash_map<VertexId, Slot> gone_vertices;
    absl::flat_hash_map<IdKey, GoneSimplex> gone_simplices;
    absl::flat_hash_set<Slot> come_vertices, come_simplices;
    absl::flat_hash_map<Slot, RegionId> relabelled;  // and the region before the patch
  };

  // The net effect of a diff, before anything is changed.
  struct Netting {
    MeshHash hash;
    absl::flat_hash_map<VertexId, Slot> removed_vertices;
    absl::flat_hash_set<VertexId> added_vertices;
    absl::flat_hash_set<VertexId> replaced;  // ids that stand for another vertex after the diff
    // Per added row: the slot of the vertex or simplex that stays, but changes its owner or region;
    // else kNoSlot.
    std::vector<Slot> kept_vertices, kept_simplices;
    absl::flat_hash_set<Slot> removed_simplices;
    std::vector<Slot> removed_rows;  // the simplex of each removed row
  };

  explicit State(int of_dimension)
      : dimension(of_dimension), simplices(0, CellHash{this}, CellEqual{this}) {}
  State(const State& o)
      : dimension(o.dimension),
        revision(o.revision),
        hash(o.hash),
        points(o.points),
        ids(o.ids),
        containing_dimensions(o.containing_dimensions),
        owners(o.owners),
        cells(o.cells),
        neighbours(o.neighbours),
        regions(o.regions),
        vertex_pool(o.vertex_pool),
        simplex_pool(o.simplex_pool),
        labelled(o.labelled),
        vertices(o.vertices),
        simplices(o.simplices.size(), CellHash{this}, CellEqual{this}),
        sets(o.sets),
        subsegments(o.subsegments),
        subfacets(o.subfacets),
        label_of(o.label_of),
        going(o.going),
        patch(o.patch) {
    for (const Slot slot : o.simplices) simplices.insert(slot);
  }
  State& operator=(const State&) = delete;

  std::size_t width() const { return static_cast<std::size_t>(dimension) + 1; }
  std::size_t d() const { return static_cast<std::size_t>(dimension); }

  SlotKey KeyOfCell(Slot slot) const {
    SlotKey key = {kNoSlot, kNoSlot, kNoSlot, kNoSlot};
    for (std::size_t k = 0; k < width(); ++k) key[k] = cells[mesh_data::At(slot) * width() + k];
    return key;
  }
  IdKey IdsOfCell(Slot slot) const {
    IdKey key = {0, 0, 0, 0};
    for (std::size_t k = 0; k < width(); ++k)
      key[k] = ids[mesh_data::At(cells[mesh_data::At(slot) * width() + k])];
    return key;
  }
  IdKey IdsOfRow(const VertexId* row) const {
    IdKey key = {0, 0, 0, 0};
    for (std::size_t k = 0; k < width(); ++k) key[k] = row[k];
    return key;
  }
  Slot FindVertex(VertexId id) const {
    const auto it = vertices.find(id);
    return it == vertices.end() ? kNoSlot : it->second;
  }
  // False if a corner is absent.
  bool SlotsOfRow(const VertexId* row, SlotKey& key) const {
    key = {kNoSlot, kNoSlot, kNoSlot, kNoSlot};
    for (std::size_t k = 0; k < width(); ++k) {
      key[k] = FindVertex(row[k]);
      if (key[k] == kNoSlot) return false;
    }
    return true;
  }
  Slot FindSimplex(const VertexId* row) const {
    SlotKey key;
    if (!SlotsOfRow(row, key)) return kNoSlot;
    const auto it = simplices.find(key);
    return it == simplices.end() ? kNoSlot : *it;
  }
  MeshHash HashOfVertex(Slot slot) const {
    return HashVertex(points.data() + mesh_data::At(slot) * d(), dimension,
                      containing_dimensions[mesh_data::At(slot)], owners[mesh_data::At(slot)]);
  }

  absl::Status NetVertices(const MeshDiff& diff, Netting& netting) const;
  absl::Status NetSimplices(const MeshDiff& diff, Netting& netting) const;
  absl::Status Net(const MeshDiff& diff, Netting& netting) const;
  MeshDiff WithReplaced(MeshDiff diff, const Netting& netting) const;

  void BeginPatch();
  void RemoveSimplices(const MeshDiff& diff, const Netting& netting, mesh_data::FaceLinks& faces);
  void RemoveVertices(const MeshDiff& diff, const Netting& netting);
  void AddVertices(const MeshDiff& diff, const Netting& netting);
  void AddSimplices(const MeshDiff& diff, const Netting& netting, mesh_data::FaceLinks& faces);
  void RelabelSimplex(Slot slot, RegionId region);
  void PlaceVertex(Slot slot, VertexId id, const double* position, int containing, FeatureId owner);
  // False if the simplex exists already: then the caller must free the slot.
  bool PlaceSimplex(Slot slot, const SlotKey& corners, RegionId region);
  void CommitSets(const MeshDiff& diff);
  void CommitLabels(const LabelColumn& changes);
  void Commit(const MeshDiff& diff, const Netting& netting, bool extends);
  void WritePatch();
  absl::Status Apply(const MeshDiff& diff, bool extends);
  absl::Status Fill(const Mesh& mesh);
  absl::Status FillVertices(const Mesh& mesh, MeshHash& sum);
  absl::Status FillSimplices(const Mesh& mesh, MeshHash& sum);
  void AppendRegions(Mesh& mesh) const;

  int dimension;
  std::uint64_t revision = 0;
  MeshHash hash;

  SlotColumn<double> points;
  SlotColumn<VertexId> ids;
  SlotColumn<std::uint8_t> containing_dimensions;
  SlotColumn<FeatureId> owners;
  SlotColumn<Slot> cells, neighbours;
  SlotColumn<RegionId> regions;
  mesh_data::SlotPool vertex_pool, simplex_pool;
  std::size_t labelled = 0;  // simplices in regions

  absl::flat_hash_map<VertexId, Slot> vertices;
  CellSet simplices;
  // The polygons of each region in several polygons, and its number of simplices.
  absl::flat_hash_map<RegionId, std::pair<std::vector<FeatureId>, std::size_t>> sets;
  mesh_data::ConstraintTable<SubsegmentColumns> subsegments;
  mesh_data::ConstraintTable<SubfacetColumns> subfacets;
  absl::btree_map<FeatureId, FeatureLabel> label_of;  // none is empty

  Patch going;
  MeshPatch patch;
};

namespace mesh_data {

// An empty column stands for kNoRegion in all rows.
inline RegionId RegionOfRow(const RegionColumn& regions, std::size_t row) {
  return regions.empty() ? kNoRegion : regions[row];
}

inline std::string VertexName(VertexId id) { return text::Concat("vertex ", text::Hex(id)); }

}  // namespace mesh_data
}  // namespace dynmesh

#endif  // DYNMESH_CORE_MESH_DATA_SLOT_STATE_H_
