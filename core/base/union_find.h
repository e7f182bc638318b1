// Disjoint sets of 0 .. n - 1. Thread-compatible.
#ifndef DYNMESH_CORE_BASE_UNION_FIND_H_
#define DYNMESH_CORE_BASE_UNION_FIND_H_

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace dynmesh {

class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  // The least member of i's set. O(lg n) amortised.
  std::size_t Find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Unite(std::size_t i, std::size_t j) {
    i = Find(i), j = Find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_UNION_FIND_H_
