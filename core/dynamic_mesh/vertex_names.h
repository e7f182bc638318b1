// Public ids of vertices: a hash of the coordinates, with a salt for collisions.
//
// Vertices with the same unsalted id form a group. In the order of their coordinates they get salts
// 0, 1, 2, ... So a vertex's id is a function of the set of vertices present, and changes only if a
// vertex of its group is added or removed. Coordinates can be crafted such that a salted id is
// another vertex's, too: no salt helps then, and Clash reports it. Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_VERTEX_NAMES_H_
#define DYNMESH_CORE_DYNAMIC_MESH_VERTEX_NAMES_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/hash/hash.h"
#include "core/base/large_vector.h"
#include "core/dynamic_mesh/vertex_hash.h"
#include "core/geometry/point.h"
#include "core/meshing/elements.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

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

  // Adds vertex v. Calls renamed(w) for each other vertex *before* its id changes because of v.
  template <class Position, class Renamed>
  void Add(Index v, Position position, Renamed renamed) {
    Name(v, position);
    Enter(v, position, renamed);
  }

  // Adds many vertices, one after the other.
  template <class Position>
  void AddAll(std::span<const Index> vertices, Position position) {
    constexpr std::size_t kBlock = 16;  // prefetched together
    for (; !vertices.empty(); vertices = vertices.subspan(std::min(kBlock, vertices.size()))) {
      const auto block = vertices.first(std::min(kBlock, vertices.size()));
      for (const Index v : block) {
        Name(v, position);
        alone_.prefetch(v);
      }
      for (const Index v : block) Enter(v, position, [](Index) {});
    }
  }

  // Removes vertex v; its id stays readable until the index is added again.
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

  // Two vertices with the same id: the least such id, the first two in the order of coordinates. So
  // it is a function of the vertices. O(vertices in groups of several).
  template <class Position>
  std::optional<std::array<Index, 2>> Clash(Position position) const {
    if (crowded_.empty()) return std::nullopt;
    std::vector<std::pair<VertexId, Index>> named;
    for (const auto& [name, members] : crowded_) {
      for (const Index v : members) named.emplace_back(ids_[v], v);
      for (const Index v : members) {
        const auto other = alone_.find(NameOnly{ids_[v]});
        if (other != alone_.end()) named.emplace_back(ids_[v], *other);
      }
    }
    std::sort(named.begin(), named.end(), [&](const auto& a, const auto& b) {
      return a.first != b.first ? a.first < b.first : position(a.second) < position(b.second);
    });
    // The same vertex may be there several times.
    for (std::size_t i = 1; i < named.size(); ++i) {
      if (named[i].first == named[i - 1].first && named[i].second != named[i - 1].second) {
        return std::array{named[i - 1].second, named[i].second};
      }
    }
    return std::nullopt;
  }

  std::size_t bytes() const {
    return alone_.capacity() * (sizeof(Index) + 1) + ids_.size() * sizeof(VertexId);
  }

 private:
  // A set of vertices alone in their group, hashed by their ids in `ids_`: no second copy of the
  // ids.
  struct NameOnly {
    VertexId id;
  };
  struct HashOfName {
    using is_transparent = void;
    const LargeVector<VertexId>* ids;
    std::size_t operator()(Index v) const { return absl::Hash<VertexId>()((*ids)[v]); }
    std::size_t operator()(NameOnly name) const { return absl::Hash<VertexId>()(name.id); }
  };
  struct SameName {
    using is_transparent = void;
    const LargeVector<VertexId>* ids;
    bool operator()(Index v, Index w) const { return (*ids)[v] == (*ids)[w]; }
    bool operator()(Index v, NameOnly name) const { return (*ids)[v] == name.id; }
    bool operator()(NameOnly name, Index v) const { return (*ids)[v] == name.id; }
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
