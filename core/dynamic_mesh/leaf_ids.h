// The leaves of a quadtree as vertices: a leaf's vertex is at its centre. Ids are hashes of
// centres, without a salt: two leaves with the same id are an error (Clash). Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LEAF_IDS_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LEAF_IDS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "absl/container/flat_hash_set.h"
#include "core/dynamic_mesh/vertex_names.h"
#include "core/quadtree/cell.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

template <int D>
class LeafIds {
 public:
  // `grid` must outlive this.
  LeafIds(const quadtree::Grid<D>& grid, VertexHash id_of) : grid_(grid), id_of_(id_of) {}

  // Appends the leaf's row to `vertices`.
  void AppendTo(VertexColumns& vertices, const quadtree::Cell<D>& leaf) const {
    const auto centre = grid_.CentreOf(leaf);
    Append(vertices, centre, IdAt(centre));
  }
  VertexId IdOf(const quadtree::Cell<D>& leaf) const { return IdAt(grid_.CentreOf(leaf)); }

  // Adds leaves, and their rows to `vertices`, which is empty. for_each(f) calls f(leaf) for each
  // of `count`.
  template <class ForEach>
  void AddAll(std::size_t count, ForEach for_each, VertexColumns& vertices) {
    ids_.reserve(ids_.size() + count);
    vertices.ids.reserve(count);
    vertices.coordinates.reserve(count * D);
    vertices.containing_dimensions.assign(count, D);
    vertices.owners.assign(count, kNoFeature);
    for_each([&](const quadtree::Cell<D>& leaf) {
      const auto centre = grid_.CentreOf(leaf);
      AppendPosition(vertices, centre, IdAt(centre));
      hash_ += HashAt(centre);
    });
    constexpr std::size_t kAhead = 16;  // far enough for a line of memory to arrive
    for (std::size_t i = 0; i < count; ++i) {
      if (i + kAhead < count) ids_.prefetch(vertices.ids[i + kAhead]);
      Enter(vertices.ids[i]);
    }
  }
  // Returns the id of the leaf.
  VertexId Remove(const quadtree::Cell<D>& leaf) {
    const auto centre = grid_.CentreOf(leaf);
    const VertexId id = IdAt(centre);
    const auto others = others_.empty() ? others_.end() : others_.find(id);
    if (others == others_.end()) {
      ids_.erase(id);
    } else if (--others->second == 0) {
      others_.erase(others);
    }
    hash_ -= HashAt(centre);
    return id;
  }

  // The least id that two leaves have.
  std::optional<VertexId> Clash() const {
    if (others_.empty()) return std::nullopt;
    return others_.begin()->first;
  }
  const MeshHash& hash() const { return hash_; }  // of all leaves
  std::size_t size() const {
    std::size_t all = ids_.size();
    for (const auto& [id, others] : others_) all += others;
    return all;
  }
  std::size_t bytes() const { return ids_.capacity() * (sizeof(VertexId) + 1); }

 private:
  void Enter(VertexId id) {
    if (!ids_.insert(id).second) ++others_[id];
  }
  static void AppendPosition(VertexColumns& vertices, const geometry::Point<D>& centre,
                             VertexId id) {
    vertices.ids.push_back(id);
    for (const double c : centre.c) vertices.coordinates.push_back(c);
  }
  static void Append(VertexColumns& vertices, const geometry::Point<D>& centre, VertexId id) {
    AppendPosition(vertices, centre, id);
    vertices.containing_dimensions.push_back(D);
    vertices.owners.push_back(kNoFeature);
  }
  VertexId IdAt(const geometry::Point<D>& centre) const { return id_of_(centre.c.data(), D, 0); }
  static MeshHash HashAt(const geometry::Point<D>& centre) {
    return HashVertex(centre.c.data(), D, D, kNoFeature);
  }

  const quadtree::Grid<D>& grid_;
  const VertexHash id_of_;
  absl::flat_hash_set<VertexId> ids_;
  std::map<VertexId, std::uint64_t> others_;  // how many leaves more have the id
  MeshHash hash_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LEAF_IDS_H_
