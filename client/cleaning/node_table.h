// The positions of the cleaned input's points: no two are nearer than the tolerance. Nodes are
// only added, and only finitely many fit into the input's box.
//
// Thread-compatible. Expected O(1) per operation.
#ifndef DYNMESH_CLIENT_CLEANING_NODE_TABLE_H_
#define DYNMESH_CLIENT_CLEANING_NODE_TABLE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"

namespace dynmesh::cleaning {

using Point = std::array<double, 2>;  // < is lexicographic
using Node = std::uint32_t;

// Symmetric to the bit.
double SquaredDistance(const Point& a, const Point& b);

class NodeTable {
 public:
  explicit NodeTable(double tolerance) : tolerance_(tolerance) {}

  // The node nearest to p within the tolerance; the oldest one of several.
  std::optional<Node> Near(const Point& p) const;
  // REQUIRES: no node is within the tolerance.
  Node Add(const Point& p);

  const Point& at(Node v) const { return points_[v]; }
  std::size_t size() const { return points_.size(); }
  double tolerance() const { return tolerance_; }

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;  // squares with the tolerance as side
  Cell CellOf(const Point& p) const;
  static constexpr Node kNone = ~Node{0};

  double tolerance_;
  std::vector<Point> points_;
  std::vector<Node> next_;  // the next node in the same cell
  absl::flat_hash_map<Cell, Node> first_;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_NODE_TABLE_H_
