#include "client/cleaning/polygon_rings.h"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "absl/container/flat_hash_map.h"
#include "core/base/ring_walk.h"

namespace dynmesh::cleaning {
namespace {

class Remaker {
 public:
  explicit Remaker(const std::vector<NodePair>& edges) : edges_(edges), taken_(edges.size()) {}

  // Uses the ring's edges if all are the polygon's and none is used yet.
  bool Keep(const NodeRing& ring) {
    NodeRing sorted = ring;
    std::sort(sorted.begin(), sorted.end());
    if (ring.size() < 3 || std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
      return false;
    }
    std::vector<std::size_t> own;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const NodePair pair = std::minmax(ring[i], ring[(i + 1) % ring.size()]);
      const auto it = std::lower_bound(edges_.begin(), edges_.end(), pair);
      if (it == edges_.end() || *it != pair) return false;
      own.push_back(static_cast<std::size_t>(it - edges_.begin()));
      if (taken_[own.back()]) return false;
    }
    for (const std::size_t edge : own) taken_[edge] = true;
    return true;
  }

  // Collects the unused edges at each node, and the nodes with more than one ring.
  void Open(std::vector<Node>& cuts) {
    for (std::size_t e = edges_.size(); e-- > 0;) {
      if (taken_[e]) continue;
      open_[edges_[e].first].push_back(e);
      open_[edges_[e].second].push_back(e);
    }
    for (const auto& [node, edges] : open_) {
      if (edges.size() > 2) cuts.push_back(node);
    }
    std::sort(cuts.begin(), cuts.end());
  }

  // Walks rings from `start`, the least edge first.
  void WalkFrom(Node start, std::vector<NodeRing>& rings) {
    const auto step = [this](Node v) -> std::optional<Node> {
      const auto it = open_.find(v);
      if (it == open_.end()) return std::nullopt;
      std::vector<std::size_t>& edges = it->second;
      while (!edges.empty() && taken_[edges.back()]) edges.pop_back();
      if (edges.empty()) return std::nullopt;
      const std::size_t edge = edges.back();
      taken_[edge] = true;
      return edges_[edge].first == v ? edges_[edge].second : edges_[edge].first;
    };
    WalkRings(start, step, rings);
  }

 private:
  const std::vector<NodePair>& edges_;
  std::vector<bool> taken_;  // used edges, by index
  absl::flat_hash_map<Node, std::vector<std::size_t>> open_;
};

}  // namespace

RemadeRings RemakeRings(const std::vector<NodeRing>& were, const std::vector<NodePair>& edges) {
  RemadeRings result;
  Remaker remaker(edges);
  std::vector<bool> kept;
  for (const NodeRing& ring : were) kept.push_back(remaker.Keep(ring));
  remaker.Open(result.cuts);
  for (std::size_t i = 0; i < were.size(); ++i) {
    if (kept[i]) {
      result.rings.push_back(were[i]);
      continue;
    }
    for (const Node corner : were[i]) remaker.WalkFrom(corner, result.rings);
  }
  for (const NodePair& edge : edges) remaker.WalkFrom(edge.first, result.rings);
  return result;
}

}  // namespace dynmesh::cleaning
