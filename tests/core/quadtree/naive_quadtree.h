// BuildQT by its definition, slow and obvious: each cell asks all features.
#ifndef DYNMESH_TESTS_CORE_QUADTREE_NAIVE_QUADTREE_H_
#define DYNMESH_TESTS_CORE_QUADTREE_NAIVE_QUADTREE_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "core/quadtree/cell.h"
#include "core/quadtree/shape.h"

namespace dynmesh::quadtree::testing {

// Calls f(cell) for the cells of its level that touch it, itself included, within the root, until f
// returns false. Returns false if it did.
template <int D, class F>
bool ForEachTouching(const Cell<D>& cell, F f) {
  const std::uint64_t last = (std::uint64_t{1} << cell.level) - 1;
  Cell<D> other = cell;
  const auto visit = [&](auto& self, int axis) -> bool {
    if (axis == D) return f(other);
    const std::uint64_t x = cell.at[axis];
    for (std::uint64_t y = x == 0 ? 0 : x - 1; y <= (x == last ? x : x + 1); ++y) {
      other.at[axis] = y;
      if (!self(self, axis + 1)) return false;
    }
    return true;
  };
  return visit(visit, 0);
}

template <int D>
class NaiveQuadtree {
 public:
  using Key = Cell<D>;

  NaiveQuadtree(const Grid<D>& grid, std::vector<Shape<D>> shapes)
      : grid_(grid), shapes_(std::move(shapes)) {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < shapes_.size(); ++i) all.push_back(i);
    Crowd(Key(), all);
    // The least fixed point of the rule, by trying again until nothing changes.
    for (bool is_done = false; !is_done;) {
      is_done = true;
      const std::set<Key> before = split_;
      for (const Key& fine : before) {
        ForEachTouching(fine, [&](const Key& beside) {
          if (beside.level > 0 && split_.insert(beside.Parent()).second) is_done = false;
          return true;
        });
      }
    }
  }

  std::vector<Key> Leaves() const {
    std::vector<Key> leaves;
    if (!split_.contains(Key())) leaves.push_back(Key());
    for (const Key& cell : split_) {
      for (int which = 0; which < Key::kChildren; ++which) {
        if (!split_.contains(cell.Child(which))) leaves.push_back(cell.Child(which));
      }
    }
    std::sort(leaves.begin(), leaves.end());
    return leaves;
  }

 private:
  // Those of `among` that meet the cell.
  std::vector<std::size_t> In(const Key& cell, const std::vector<std::size_t>& among) const {
    std::vector<std::size_t> in;
    for (const std::size_t i : among) {
      if (shapes_[i].Meets(grid_.BoxOf(cell))) in.push_back(i);
    }
    return in;
  }
  bool HaveCommonPoint(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) const {
    for (const PointIndex point : shapes_[a.front()].points()) {
      const auto has = [&](std::size_t i) {
        return std::ranges::count(shapes_[i].points(), point) > 0;
      };
      if (std::ranges::all_of(a, has) && std::ranges::all_of(b, has)) return true;
    }
    return false;
  }

  // `near`: the features that meet the parent's block.
  void Crowd(const Key& cell, const std::vector<std::size_t>& near) {
    if (cell.level >= grid_.most_level()) return;
    const auto own = In(cell, near);
    if (own.empty()) return;
    std::vector<std::size_t> block;
    const Box<D> around = grid_.BlockOf(cell);
    for (const std::size_t i : near) {
      if (cell.level == 0 || shapes_[i].Meets(around)) block.push_back(i);
    }
    const bool is_calm = ForEachTouching(
        cell, [&](const Key& other) { return HaveCommonPoint(own, In(other, block)); });
    if (is_calm) return;
    split_.insert(cell);
    for (int which = 0; which < Key::kChildren; ++which) Crowd(cell.Child(which), block);
  }

  const Grid<D> grid_;
  const std::vector<Shape<D>> shapes_;
  std::set<Key> split_;
};

}  // namespace dynmesh::quadtree::testing

#endif  // DYNMESH_TESTS_CORE_QUADTREE_NAIVE_QUADTREE_H_
