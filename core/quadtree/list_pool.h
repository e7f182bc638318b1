// Lists by index, for records that rarely have one. Thread-compatible.
#ifndef DYNMESH_CORE_QUADTREE_LIST_POOL_H_
#define DYNMESH_CORE_QUADTREE_LIST_POOL_H_

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/quadtree/cell.h"

namespace dynmesh::quadtree {

class ListPool {
 public:
  using List = std::vector<std::uint32_t>;

  std::uint32_t Add(List list) {
    if (free_.empty()) {
      lists_.push_back(std::move(list));
      return static_cast<std::uint32_t>(lists_.size() - 1);
    }
    const std::uint32_t i = free_.back();
    free_.pop_back();
    lists_[i] = std::move(list);
    return i;
  }
  // *i is kNone afterwards; the empty list if it is so before.
  List Take(std::uint32_t* i) {
    if (*i == kNone) return {};
    free_.push_back(*i);
    return std::exchange(lists_[std::exchange(*i, kNone)], {});
  }
  List& operator[](std::uint32_t i) { return lists_[i]; }
  const List& operator[](std::uint32_t i) const { return lists_[i]; }

  // Without what the lists hold.
  std::size_t bytes() const {
    return lists_.capacity() * sizeof(List) + free_.capacity() * sizeof(std::uint32_t);
  }

 private:
  std::vector<List> lists_;
  std::vector<std::uint32_t> free_;
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_LIST_POOL_H_
