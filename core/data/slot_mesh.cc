#include "dynmesh/slot_mesh.h"

#include <algorithm>
#include <array>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/base/huge_pages.h"
#include "core/data/check_columns.h"
#include "core/data/face_links.h"
#include "core/data/pieces.h"
#include "core/data/regions.h"
#include "core/data/text.h"

namespace dynmesh {
namespace {

using data::Concat;

// Ids or slots of a simplex's corners; unused entries are 0 or kNoSlot.
using IdKey = std::array<VertexId, 4>;
using SlotKey = std::array<Slot, 4>;

absl::Status Lost(std::string_view what, std::string_view trouble) {
  return absl::DataLossError(Concat(what, " ", trouble, ": take a new snapshot"));
}

RegionId RegionOfRow(const RegionColumn& regions, std::size_t row) {
  return regions.empty() ? kNoRegion : regions[row];
}

std::string VertexName(VertexId id) { return Concat("vertex ", data::Hex(id)); }

std::size_t At(Slot slot) { return static_cast<std::size_t>(slot); }

// How many rows ahead a snapshot's corners are asked for.
constexpr std::size_t kAhead = 12;

// Slots that are free, and how many there are of a kind.
struct SlotPool {
  std::vector<Slot> free;
  Slot end = 0;  // slots 0, 1, ... have been handed out
  Slot Take() {
    if (free.empty()) return end++;
    const Slot slot = free.back();
    free.pop_back();
    return slot;
  }
};

// Subsegments or subfacets by key, in slots.
template <class Columns>
struct PieceTable {
  static constexpr std::size_t kCorners = data::kCorners<Columns>;
  using Key = data::PieceKey<Columns>;

  absl::flat_hash_map<Key, Slot> slots;
  SlotColumn<Slot> corners;
  SlotColumn<FeatureId> owners;
  SlotPool pool;

  // Finds what a diff does, and adds to `hash`.
  absl::Status Net(const Columns& removed, const Columns& added, MeshHash& hash) const {
    const std::string what = Concat("a ", data::kPieceName<Columns>);
    absl::flat_hash_set<Key> gone, come;
    for (std::size_t i = 0; i < removed.size(); ++i) {
      const auto key = data::KeyOf(removed, i);
      if (!slots.contains(key)) return Lost(what, "is to go but is absent");
      if (!gone.insert(key).second) return Lost(what, "goes twice");
      hash -= data::HashOf(key);
    }
    for (std::size_t i = 0; i < added.size(); ++i) {
      const auto key = data::KeyOf(added, i);
      if (slots.contains(key) && !gone.contains(key)) {
        return Lost(what, "is to come but is present");
      }
      if (!come.insert(key).second) return Lost(what, "comes twice");
      hash += data::HashOf(key);
    }
    return absl::OkStatus();
  }

  // `slot_of` finds a vertex by id.
  template <class SlotOf>
  void Commit(const Columns& removed, const Columns& added, const SlotOf& slot_of) {
    for (std::size_t i = 0; i < removed.size(); ++i) {
      const auto it = slots.find(data::KeyOf(removed, i));
      const Slot slot = it->second;
      slots.erase(it);
      for (std::size_t k = 0; k < kCorners; ++k) corners[At(slot) * kCorners + k] = kNoSlot;
      owners[At(slot)] = kNoFeature;
      pool.free.push_back(slot);
    }
    for (std::size_t i = 0; i < added.size(); ++i) {
      const auto key = data::KeyOf(added, i);
      const Slot slot = pool.Take();
      slots.emplace(key, slot);
      corners.resize(At(pool.end) * kCorners, kNoSlot);
      owners.resize(At(pool.end), kNoFeature);
      for (std::size_t k = 0; k < kCorners; ++k) {
        corners[At(slot) * kCorners + k] = slot_of(key[k]);
      }
      owners[At(slot)] = key[kCorners];
    }
  }

  // Appends to both what stays and has a corner that is replaced.
  template <class IsReplaced>
  void AddReplaced(const IsReplaced& is_replaced, Columns& removed, Columns& added) const {
    absl::flat_hash_set<Key> gone;
    for (std::size_t i = 0; i < removed.size(); ++i) gone.insert(data::KeyOf(removed, i));
    for (const auto& [key, slot] : slots) {
      if (gone.contains(key) || std::none_of(key.begin(), key.end() - 1, is_replaced)) continue;
      data::Append(removed, key), data::Append(added, key);
    }
  }

  Columns ToColumns() const {
    Columns columns;
    for (const auto& [key, slot] : slots) data::Append(columns, key);
    return columns;
  }
};

}  // namespace

namespace slot_mesh_internal {

std::shared_ptr<void> MakeBlock(std::size_t bytes) {
  if (!huge_pages::AreFor(bytes)) {
    return {::operator new(bytes), [](void* block) { ::operator delete(block); }};
  }
  return {huge_pages::Map(bytes), [bytes](void* block) { huge_pages::Unmap(block, bytes); }};
}

}  // namespace slot_mesh_internal

struct SlotMesh::State {
  // Finds simplices by the corners in their rows: no second copy of these.
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

  // What a patch has done so far.
  struct GoneSimplex {
    Slot slot;
    SlotKey corners;
    RegionId region;
  };
  struct Patch {
    absl::flat_hash_map<VertexId, Slot> gone_vertices;
    absl::flat_hash_map<IdKey, GoneSimplex> gone_simplices;
    absl::flat_hash_set<Slot> come_vertices, come_simplices;
    absl::flat_hash_map<Slot, RegionId> relabelled;  // and the region before
  };

  // What has been seen of a diff while nothing has been changed yet.
  struct Netting {
    MeshHash hash;
    absl::flat_hash_map<VertexId, Slot> removed_vertices;
    absl::flat_hash_set<VertexId> added_vertices;
    absl::flat_hash_set<VertexId> replaced;  // ids that stand for another vertex after the diff
    // Of each added row: the slot of the vertex or simplex that stays, but changes its owner or
    // its region; else kNoSlot.
    std::vector<Slot> kept_vertices, kept_simplices;
    absl::flat_hash_set<Slot> removed_simplices;
    std::vector<Slot> removed_rows;  // the simplex of each
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
        going(o.going),
        patch(o.patch) {
    for (const Slot slot : o.simplices) simplices.insert(slot);
  }
  State& operator=(const State&) = delete;

  std::size_t width() const { return static_cast<std::size_t>(dimension) + 1; }
  std::size_t d() const { return static_cast<std::size_t>(dimension); }

  SlotKey KeyOfCell(Slot slot) const {
    SlotKey key = {kNoSlot, kNoSlot, kNoSlot, kNoSlot};
    for (std::size_t k = 0; k < width(); ++k) key[k] = cells[At(slot) * width() + k];
    return key;
  }
  IdKey IdsOfCell(Slot slot) const {
    IdKey key = {0, 0, 0, 0};
    for (std::size_t k = 0; k < width(); ++k) key[k] = ids[At(cells[At(slot) * width() + k])];
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
    return HashVertex(points.data() + At(slot) * d(), dimension, containing_dimensions[At(slot)],
                      owners[At(slot)]);
  }

  absl::Status NetVertices(const MeshDiff& diff, Netting& netting) const;
  absl::Status NetSimplices(const MeshDiff& diff, Netting& netting) const;
  absl::Status Net(const MeshDiff& diff, Netting& netting) const;
  MeshDiff WithReplaced(MeshDiff diff, const Netting& netting) const;

  void BeginPatch();
  void RemoveSimplices(const MeshDiff& diff, const Netting& netting, data::FaceLinks& faces);
  void RemoveVertices(const MeshDiff& diff, const Netting& netting);
  void AddVertices(const MeshDiff& diff, const Netting& netting);
  void AddSimplices(const MeshDiff& diff, const Netting& netting, data::FaceLinks& faces);
  void RelabelSimplex(Slot slot, RegionId region);
  void PlaceVertex(Slot slot, VertexId id, const double* place, int containing, FeatureId owner);
  // False if there is such a simplex: then the slot must not stay.
  bool PlaceSimplex(Slot slot, const SlotKey& corners, RegionId region);
  void CommitSets(const MeshDiff& diff);
  void Commit(const MeshDiff& diff, const Netting& netting, bool extends);
  void WritePatch();
  absl::Status Apply(const MeshDiff& diff, bool extends);
  absl::Status Fill(const Mesh& mesh);
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
  SlotPool vertex_pool, simplex_pool;
  std::size_t labelled = 0;  // simplices in regions

  absl::flat_hash_map<VertexId, Slot> vertices;
  CellSet simplices;
  // Polygons and number of simplices, of regions in several polygons.
  absl::flat_hash_map<RegionId, std::pair<std::vector<FeatureId>, std::size_t>> sets;
  PieceTable<SubsegmentColumns> subsegments;
  PieceTable<SubfacetColumns> subfacets;

  Patch going;
  MeshPatch patch;
};

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
    // The same id at another place (of two vertices whose hashes agree) is another vertex.
    const double* place = &added.coordinates[i * d()];
    const auto removed = netting.removed_vertices.find(id);
    const bool stays = removed != netting.removed_vertices.end() &&
                       std::equal(place, place + d(), &points[At(removed->second) * d()]);
    netting.kept_vertices.push_back(stays ? removed->second : kNoSlot);
    if (!stays && removed != netting.removed_vertices.end()) netting.replaced.insert(id);
    netting.hash += HashVertex(place, dimension, added.containing_dimensions[i], added.owners[i]);
  }
  return absl::OkStatus();
}

absl::Status SlotMesh::State::NetSimplices(const MeshDiff& diff, Netting& netting) const {
  const int count = dimension + 1;
  for (std::size_t i = 0; i < diff.removed_simplex_count(); ++i) {
    const VertexId* row = &diff.removed_simplices[i * width()];
    const RegionId region = RegionOfRow(diff.removed_regions, i);
    // In another region it is another simplex, as a subsegment is with another owner. Not
    // left to the hash: what filters or adds up diffs believes their regions.
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
        return Lost("a piece of a feature", "has a corner that is absent");
      }
    }
  }
  if (netting.hash != diff.hash) {
    return Lost("the mesh", Concat("has hash ", netting.hash.ToHex(), " where ", diff.hash.ToHex(),
                                   " was promised"));
  }
  return absl::OkStatus();
}

absl::Status SlotMesh::State::Apply(const MeshDiff& diff, bool extends) {
  if (auto status = data::CheckColumns(diff); !status.ok()) return status;
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

// Where an id stands for another vertex after the diff (of vertices whose hashes agree), rows that
// name it by ids alone are the same before and after, so the diff leaves them out. As slots they
// change: here they go and come, too. O(mesh).
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

// Slots that the last patch freed may be filled from now on.
void SlotMesh::State::BeginPatch() {
  const auto free = [](const std::vector<Slot>& slots, SlotPool& pool) {
    pool.free.insert(pool.free.end(), slots.rbegin(), slots.rend());
  };
  free(patch.removed_vertices, vertex_pool);
  free(patch.removed_simplices, simplex_pool);
  going = Patch();
  patch = MeshPatch();
  patch.from_revision = patch.to_revision = revision;
}

// A simplex of the patch's beginning is kept in mind; one that came with the patch is forgotten.
void SlotMesh::State::RemoveSimplices(const MeshDiff& diff, const Netting& netting,
                                      data::FaceLinks& faces) {
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
  // Rows are cleared when nothing looks for them any more.
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

void SlotMesh::State::PlaceVertex(Slot slot, VertexId id, const double* place, int containing,
                                  FeatureId owner) {
  const std::size_t end = At(vertex_pool.end);
  points.resize(end * d(), 0), ids.resize(end, 0);
  containing_dimensions.resize(end, 0), owners.resize(end, kNoFeature);
  std::copy_n(place, d(), &points[At(slot) * d()]);
  ids[At(slot)] = id;
  containing_dimensions[At(slot)] = static_cast<std::uint8_t>(containing);
  owners[At(slot)] = owner;
}

// A vertex that went earlier in the patch comes back to its slot.
void SlotMesh::State::AddVertices(const MeshDiff& diff, const Netting& netting) {
  const VertexColumns& added = diff.added_vertices;
  for (std::size_t i = 0; i < added.size(); ++i) {
    const double* place = &added.coordinates[i * d()];
    Slot slot = netting.kept_vertices[i];
    const auto gone = going.gone_vertices.find(added.ids[i]);
    if (slot == kNoSlot && gone != going.gone_vertices.end() &&
        std::equal(place, place + d(), &points[At(gone->second) * d()])) {
      slot = gone->second;
      going.gone_vertices.erase(gone);
    } else if (slot == kNoSlot) {
      slot = vertex_pool.Take();
      going.come_vertices.insert(slot);
    }
    vertices.insert_or_assign(added.ids[i], slot);
    PlaceVertex(slot, added.ids[i], place, added.containing_dimensions[i], added.owners[i]);
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

// So does a simplex.
void SlotMesh::State::AddSimplices(const MeshDiff& diff, const Netting& netting,
                                   data::FaceLinks& faces) {
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

// Additions first, so that a set which stays in use is not dropped in between.
void SlotMesh::State::CommitSets(const MeshDiff& diff) {
  for (const RegionSet& set : diff.region_sets) {
    const auto [it, is_new] = sets.try_emplace(set.id, set.polygons, 0);
    if (!is_new) it->second.first = set.polygons;  // may be another set's id now
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

void SlotMesh::State::Commit(const MeshDiff& diff, const Netting& netting, bool extends) {
  if (!extends) BeginPatch();
  data::FaceLinks faces;
  RemoveSimplices(diff, netting, faces);
  RemoveVertices(diff, netting);
  CommitSets(diff);
  AddVertices(diff, netting);
  AddSimplices(diff, netting, faces);
  faces.Link(neighbours.data(), width());
  const auto slot_of = [this](VertexId id) { return FindVertex(id); };
  subsegments.Commit(diff.removed_subsegments, diff.added_subsegments, slot_of);
  subfacets.Commit(diff.removed_subfacets, diff.added_subfacets, slot_of);
  revision = diff.to_revision;
  hash = diff.hash;
  WritePatch();
}

// Writes `going` down in the order of ids.
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

// Into nothing: every row gets its slot at once, and nothing needs netting.
absl::Status SlotMesh::State::Fill(const Mesh& mesh) {
  const std::size_t vertex_count = mesh.vertices.size(), simplex_count = mesh.simplex_count();
  if (std::max(vertex_count, simplex_count) >= std::size_t{1} << 31) {
    return absl::InvalidArgumentError("a mesh of 2^31 rows or more has no slots");
  }
  MeshHash sum;
  points.reserve(vertex_count * d()), ids.reserve(vertex_count);
  containing_dimensions.reserve(vertex_count), owners.reserve(vertex_count);
  vertices.reserve(vertex_count);
  for (std::size_t i = 0; i < vertex_count; ++i) {
    const Slot slot = vertex_pool.Take();
    const VertexId id = mesh.vertices.ids[i];
    if (id == 0) return Lost("a vertex", "has no id");
    if (!vertices.emplace(id, slot).second) return Lost(VertexName(id), "comes twice");
    PlaceVertex(slot, id, &mesh.vertices.coordinates[i * d()],
                mesh.vertices.containing_dimensions[i], mesh.vertices.owners[i]);
    sum += HashOfVertex(slot);
  }
  cells.reserve(simplex_count * width()), neighbours.reserve(simplex_count * width());
  regions.reserve(simplex_count), simplices.reserve(simplex_count);
  for (std::size_t i = 0; i < simplex_count; ++i) {
    const VertexId* row = &mesh.simplices[i * width()];
    // Vertices are found at random places: asked for ahead, they are there in time.
    if (i + kAhead < simplex_count) {
      for (std::size_t k = 0; k < width(); ++k) vertices.prefetch(row[kAhead * width() + k]);
    }
    SlotKey corners;
    if (!SlotsOfRow(row, corners)) return Lost("a simplex", "has a corner that is absent");
    if (!PlaceSimplex(simplex_pool.Take(), corners, mesh.region(i))) {
      return Lost("a simplex", "comes twice");
    }
    sum += HashSimplex(row, dimension + 1, mesh.region(i));
  }
  data::LinkAllFaces(cells.span(), width(), vertex_count, neighbours.data());

  MeshDiff rest;  // pieces and sets as if they came with a diff
  rest.dimension = dimension;
  if (auto s = subsegments.Net({}, mesh.subsegments, sum); !s.ok()) return s;
  if (auto s = subfacets.Net({}, mesh.subfacets, sum); !s.ok()) return s;
  if (sum != mesh.hash) {
    return Lost("the mesh",
                Concat("has hash ", sum.ToHex(), " where ", mesh.hash.ToHex(), " was promised"));
  }
  for (const auto* ends : {&mesh.subsegments.ends, &mesh.subfacets.corners}) {
    for (const VertexId id : *ends) {
      if (!vertices.contains(id))
        return Lost("a piece of a feature", "has a corner that is absent");
    }
  }
  const auto slot_of = [this](VertexId id) { return FindVertex(id); };
  subsegments.Commit({}, mesh.subsegments, slot_of);
  subfacets.Commit({}, mesh.subfacets, slot_of);
  rest.region_sets = mesh.region_sets, rest.added_regions = mesh.regions;
  CommitSets(rest);
  revision = patch.from_revision = patch.to_revision = mesh.revision;
  hash = mesh.hash;
  return absl::OkStatus();
}

void SlotMesh::State::AppendRegions(Mesh& mesh) const {
  if (labelled == 0) return;
  mesh.regions.reserve(simplices.size());
  for (const Slot slot : simplices) mesh.regions.push_back(regions[At(slot)]);
  for (const auto& [id, set] : sets) mesh.region_sets.push_back({id, set.first});
  data::KeepNamed(mesh.region_sets, {&mesh.regions});
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
  if (auto status = data::CheckColumns(mesh); !status.ok()) return status;
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
    const IdKey ids = s.IdsOfCell(slot);
    mesh.simplices.insert(mesh.simplices.end(), ids.begin(),
                          ids.begin() + static_cast<std::ptrdiff_t>(s.width()));
  }
  s.AppendRegions(mesh);
  mesh.subsegments = s.subsegments.ToColumns();
  mesh.subfacets = s.subfacets.ToColumns();
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
  return state_->subfacets.slots.contains(data::KeyOf(row, 0));
}

}  // namespace dynmesh
