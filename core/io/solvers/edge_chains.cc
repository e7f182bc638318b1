#include "core/io/solvers/edge_chains.h"

#include <cstddef>

#include "absl/container/flat_hash_map.h"

namespace dynmesh::io {
namespace {

class Chains {
 public:
  explicit Chains(const std::vector<DirectedEdge>& edges)
      : edges_(edges), is_used_(edges.size(), false) {
    for (std::size_t i = 0; i < edges.size(); ++i) {
      edges_at_[edges[i].first].push_back(i);
      edges_at_[edges[i].second].push_back(i);
    }
  }

  std::vector<Chain> Take() {
    // Edges that begin at an end come first: they have the direction of the others.
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      if (IsEnd(edges_[i].first)) Walk(i, edges_[i].first);
    }
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      if (IsEnd(edges_[i].second)) Walk(i, edges_[i].second);
    }
    for (std::size_t i = 0; i < edges_.size(); ++i) Walk(i, edges_[i].first);
    return std::move(chains_);
  }

 private:
  bool IsEnd(std::uint32_t v) const { return edges_at_.at(v).size() != 2; }

  // From edge i, whose end `from` is, to an end or around.
  void Walk(std::size_t i, std::uint32_t from) {
    if (is_used_[i]) return;
    Chain chain = {from};
    while (!is_used_[i]) {
      is_used_[i] = true;
      const std::uint32_t to = edges_[i].first == chain.back() ? edges_[i].second : edges_[i].first;
      chain.push_back(to);
      if (IsEnd(to)) break;
      const std::vector<std::size_t>& both = edges_at_.at(to);
      i = both[0] == i ? both[1] : both[0];
    }
    chains_.push_back(std::move(chain));
  }

  const std::vector<DirectedEdge>& edges_;
  absl::flat_hash_map<std::uint32_t, std::vector<std::size_t>> edges_at_;
  std::vector<bool> is_used_;
  std::vector<Chain> chains_;
};

}  // namespace

std::vector<Chain> ChainsOf(const std::vector<DirectedEdge>& edges) { return Chains(edges).Take(); }

}  // namespace dynmesh::io
