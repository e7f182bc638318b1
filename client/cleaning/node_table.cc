#include "client/cleaning/node_table.h"

#include <cmath>

namespace dynmesh::cleaning {

double SquaredDistance(const Point& a, const Point& b) {
  const double dx = a[0] - b[0], dy = a[1] - b[1];
  return dx * dx + dy * dy;
}

NodeTable::Cell NodeTable::CellOf(const Point& p) const {
  return {static_cast<std::int64_t>(std::floor(p[0] / tolerance_)),
          static_cast<std::int64_t>(std::floor(p[1] / tolerance_))};
}

std::optional<Node> NodeTable::Near(const Point& p) const {
  std::optional<Node> best;
  double least = tolerance_ * tolerance_;
  const Cell middle = CellOf(p);
  for (std::int64_t x = middle.first - 1; x <= middle.first + 1; ++x) {
    for (std::int64_t y = middle.second - 1; y <= middle.second + 1; ++y) {
      const auto it = first_.find({x, y});
      for (Node v = it == first_.end() ? kNone : it->second; v != kNone; v = next_[v]) {
        const double distance = SquaredDistance(p, points_[v]);
        if (distance > least || (distance == least && !(best && v < *best))) continue;
        least = distance;
        best = v;
      }
    }
  }
  return best;
}

Node NodeTable::Add(const Point& p) {
  const auto v = static_cast<Node>(points_.size());
  points_.push_back(p);
  const auto [it, is_new] = first_.try_emplace(CellOf(p), kNone);
  next_.push_back(it->second);
  it->second = v;
  return v;
}

}  // namespace dynmesh::cleaning
