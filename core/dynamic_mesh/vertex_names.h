// Public ids of vertices: a hash of the coordinates, and what happens when two collide.
//
// Vertices whose unsalted ids agree form a group; in the order of their coordinates
// they take salts 0, 1, 2, ... So a vertex's id is a function of the set of vertices
// present, and changes only if one that collides comes or goes. (Salted ids are not
// checked against other groups: that would take a second collision of 64 bits.)
// Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_VERTEX_NAMES_H_
#define DYNMESH_CORE_DYNAMIC_MESH_VERTEX_NAMES_H_

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/hash/hash.h"
#include "core/base/huge_pages.h"
#include "core/geometry/point.h"
#include "core/meshing/elements.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

// Tests put a poor hash here, to make collisions.
using VertexHash = VertexId (*)(const double* coordinates, int dimension, std::uint64_t salt);

template <int D>
class VertexNames {
 public:
  using Index = meshing::VertexIndex;
  explicit VertexNames(VertexHash hash = &VertexIdAt)
      : hash_(hash), alone_(0, HashOfName{&ids_}, SameName{&ids_}) {}
  VertexNames(const VertexNames&) = delete;
  VertexNames& operator=(const VertexNames&) = delete;

  VertexId at(Index v) const { return ids_[v]; }

  void Reserve(std::size_t vertices) {
    ids_.reserve(vertices);
    alone_.reserve(vertices);
  }

  // Vertex v comes. Calls renamed(w) for each other vertex *before* its id changes on that
  // account.
  template <class Position, class Renamed>
  void Add(Index v, Position position, Renamed renamed) {
    Name(v, position);
    Enter(v, position, renamed);
  }

  // Many come, one after the other.
  template <class Position>
  void AddAll(std::span<const Index> vertices, Position position) {
    constexpr std::size_t kBlock = 16;  // asked of memory together
    for (; !vertices.empty(); vertices = vertices.subspan(std::min(kBlock, vertices.size()))) {
      const auto block = vertices.first(std::min(kBlock, vertices.size()));
      for (const Index v : block) {
        Name(v, position);
        alone_.prefetch(v);
      }
      for (const Index v : block) Enter(v, position, [](Index) {});
    }
  }

  // Vertex v goes; its id stays readable until the index is added again.
  template <class Position, class Renamed>
  void Remove(Index v, Position position, Renamed renamed) {
    const VertexId name = Unsalted(position(v));
    const auto crowd = crowded_.find(name);
    if (crowd == crowded_.end()) {
      alone_.erase(v);
      return;
    }
    std::erase(crowd->second, v);
    Rename(crowd->second, v, position, renamed);
    if (crowd->second.size() > 1) return;
    alone_.insert(crowd->second.front());
    crowded_.erase(crowd);
  }

  std::size_t bytes() const {
    return alone_.capacity() * (sizeof(Index) + 1) + ids_.size() * sizeof(VertexId);
  }

 private:
  // Vertices that are alone in their group are known by their ids, which need not be kept
  // twice.
  struct HashOfName {
    const LargeVector<VertexId>* ids;
    std::size_t operator()(Index v) const { return absl::Hash<VertexId>()((*ids)[v]); }
  };
  struct SameName {
    const LargeVector<VertexId>* ids;
    bool operator()(Index v, Index w) const { return (*ids)[v] == (*ids)[w]; }
  };

  VertexId Unsalted(const geometry::Point<D>& p) const { return hash_(p.c.data(), D, 0); }

  template <class Position>
  void Name(Index v, Position position) {
    if (v >= ids_.size()) ids_.resize(v + v / 4 + 16);
    ids_[v] = Unsalted(position(v));
  }

  template <class Position, class Renamed>
  void Enter(Index v, Position position, Renamed renamed) {
    const VertexId name = ids_[v];
    auto crowd = crowded_.empty() ? crowded_.end() : crowded_.find(name);
    if (crowd == crowded_.end()) {
      const auto [it, is_alone] = alone_.insert(v);
      if (is_alone) return;
      crowd = crowded_.try_emplace(name, std::vector<Index>{*it}).first;
      alone_.erase(it);
    }
    crowd->second.push_back(v);
    Rename(crowd->second, v, position, renamed);
  }

  template <class Position, class Renamed>
  void Rename(std::vector<Index>& members, Index except, Position position, Renamed renamed) {
    std::sort(members.begin(), members.end(),
              [&](Index a, Index b) { return position(a) < position(b); });
    for (std::size_t salt = 0; salt < members.size(); ++salt) {
      const VertexId id = hash_(position(members[salt]).c.data(), D, salt);
      if (ids_[members[salt]] == id) continue;
      if (members[salt] != except) renamed(members[salt]);
      ids_[members[salt]] = id;
    }
  }

  const VertexHash hash_;
  LargeVector<VertexId> ids_;                                  // by index
  absl::flat_hash_set<Index, HashOfName, SameName> alone_;     // with salt 0
  absl::flat_hash_map<VertexId, std::vector<Index>> crowded_;  // the others, by unsalted id
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_VERTEX_NAMES_H_
