// The positions of the cleaned input's points: no two are nearer than the tolerance. Nodes are
// only added, and only finitely many fit into the input's box. At some places the tolerance may be
// greater by a power of 2, the level.
//
// In 2D, or in 3D for surfaces. Thread-compatible. Expected O(1) per operation.
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

template <std::size_t D>
using PointOf = std::array<double, D>;  // < is lexicographic
using Point = PointOf<2>;
using Point3 = PointOf<3>;
using Node = std::uint32_t;
using NodePair = std::pair<Node, Node>;  // first < second

// Symmetric to the bit.
template <std::size_t D>
double SquaredDistance(const PointOf<D>& a, const PointOf<D>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < D; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

template <std::size_t D>
class NodeTableOf {
 public:
  using Point = PointOf<D>;

  explicit NodeTableOf(double tolerance, int most_level = 0)
      : tolerance_(tolerance), grids_(static_cast<std::size_t>(most_level) + 1) {}

  // The node nearest to p within the tolerance of the level; the oldest one of several.
  // REQUIRES: 0 <= level <= most_level.
  std::optional<Node> Near(const Point& p, int level = 0) const;
  // REQUIRES: no node is within the tolerance.
  Node Add(const Point& p);

  const Point& at(Node v) const { return points_[v]; }
  std::size_t size() const { return points_.size(); }
  double tolerance() const { return tolerance_; }

 private:
  using Cell = std::array<std::int64_t, D>;
  static constexpr Node kNone = ~Node{0};
  // Squares or cubes with the tolerance of a level as side.
  struct Grid {
    std::vector<Node> next;  // the next node in the same cell
    absl::flat_hash_map<Cell, Node> first;
  };
  static Cell CellOf(const Point& p, double side);

  double tolerance_;
  std::vector<Point> points_;
  std::vector<Grid> grids_;  // by level
};

using NodeTable = NodeTableOf<2>;
using NodeTable3 = NodeTableOf<3>;
extern template class NodeTableOf<2>;
extern template class NodeTableOf<3>;

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_NODE_TABLE_H_
