#include "client/cleaning/node_table.h"

#include <cmath>

namespace dynmesh::cleaning {

template <std::size_t D>
typename NodeTableOf<D>::Cell NodeTableOf<D>::CellOf(const Point& p, double side) {
  Cell cell;
  for (std::size_t i = 0; i < D; ++i) {
    cell[i] = static_cast<std::int64_t>(std::floor(p[i] / side));
  }
  return cell;
}

template <std::size_t D>
std::optional<Node> NodeTableOf<D>::Near(const Point& p, int level) const {
  std::optional<Node> best;
  const double tolerance = std::ldexp(tolerance_, level);
  const Grid& grid = grids_[static_cast<std::size_t>(level)];
  double least = tolerance * tolerance;
  const Cell middle = CellOf(p, tolerance);
  constexpr std::size_t kCells = D == 2 ? 9 : 27;  // the middle one and all around it
  for (std::size_t c = 0; c < kCells; ++c) {
    Cell cell = middle;
    for (std::size_t i = 0, digits = c; i < D; ++i, digits /= 3) {
      cell[i] += static_cast<std::int64_t>(digits % 3) - 1;
    }
    const auto it = grid.first.find(cell);
    for (Node v = it == grid.first.end() ? kNone : it->second; v != kNone; v = grid.next[v]) {
      const double distance = SquaredDistance<D>(p, points_[v]);
      if (distance > least || (distance == least && !(best && v < *best))) continue;
      least = distance;
      best = v;
    }
  }
  return best;
}

template <std::size_t D>
Node NodeTableOf<D>::Add(const Point& p) {
  const auto v = static_cast<Node>(points_.size());
  points_.push_back(p);
  double side = tolerance_;
  for (Grid& grid : grids_) {
    const auto [it, is_new] = grid.first.try_emplace(CellOf(p, side), kNone);
    grid.next.push_back(it->second);
    it->second = v;
    side *= 2;
  }
  return v;
}

template class NodeTableOf<2>;
template class NodeTableOf<3>;

}  // namespace dynmesh::cleaning
