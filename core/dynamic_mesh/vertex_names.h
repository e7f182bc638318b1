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
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/geometry/point.h"
#include "core/meshing/elements.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

class VertexNames {
 public:
  using Index = meshing::VertexIndex;
  // Tests put a poor hash here, to make collisions.
  using Hash = VertexId (*)(const double* coordinates, int dimension, std::uint64_t salt);

  explicit VertexNames(Hash hash = &VertexIdAt) : hash_(hash) {}

  VertexId at(Index v) const { return ids_[v]; }

  void Reserve(std::size_t vertices) {
    ids_.reserve(vertices);
    groups_.reserve(vertices);
  }

  // Vertex v at p comes. Calls renamed(w) for each other vertex *before* its id
  // changes on that account.
  template <class Position, class Renamed>
  void Add(Index v, Position position, Renamed renamed) {
    if (v >= ids_.size()) ids_.resize(v + v / 4 + 16);
    const VertexId name = Unsalted(position(v));
    ids_[v] = name;
    const auto [it, alone] = groups_.try_emplace(name, v);
    if (alone) return;
    std::vector<Index>& members = crowded_[name];
    if (members.empty()) members.push_back(it->second);
    members.push_back(v);
    Rename(members, v, position, renamed);
  }

  // Vertex v goes; its id stays readable until the index is added again.
  template <class Position, class Renamed>
  void Remove(Index v, Position position, Renamed renamed) {
    const VertexId name = Unsalted(position(v));
    const auto crowd = crowded_.find(name);
    if (crowd == crowded_.end()) {
      groups_.erase(name);
      return;
    }
    std::erase(crowd->second, v);
    Rename(crowd->second, v, position, renamed);
    groups_[name] = crowd->second.front();
    if (crowd->second.size() == 1) crowded_.erase(crowd);
  }

  std::size_t bytes() const { return groups_.capacity() * 17 + ids_.capacity() * sizeof(VertexId); }

 private:
  VertexId Unsalted(const geometry::Point2& p) const { return hash_(p.c.data(), 2, 0); }

  template <class Position, class Renamed>
  void Rename(std::vector<Index>& members, Index except, Position position, Renamed renamed) {
    std::sort(members.begin(), members.end(),
              [&](Index a, Index b) { return position(a) < position(b); });
    for (std::size_t salt = 0; salt < members.size(); ++salt) {
      const VertexId id = hash_(position(members[salt]).c.data(), 2, salt);
      if (ids_[members[salt]] == id) continue;
      if (members[salt] != except) renamed(members[salt]);
      ids_[members[salt]] = id;
    }
  }

  Hash hash_;
  std::vector<VertexId> ids_;                                  // by index
  absl::flat_hash_map<VertexId, Index> groups_;                // by unsalted id: one member
  absl::flat_hash_map<VertexId, std::vector<Index>> crowded_;  // those with more than one
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_VERTEX_NAMES_H_
