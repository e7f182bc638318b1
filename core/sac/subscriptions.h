// Who subscribes to which place. Lists are unordered, and differ between histories
// that end in the same trace: nothing may depend on their order. Thread-compatible.
#ifndef DYNMESH_CORE_SAC_SUBSCRIPTIONS_H_
#define DYNMESH_CORE_SAC_SUBSCRIPTIONS_H_

#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/huge_pages.h"
#include "core/sac/block_pool.h"

namespace dynmesh::sac {

using Place = std::uint32_t;  // dense, chosen by the program

class Subscriptions {
 public:
  std::span<const std::uint32_t> at(Place place) const {
    if (place >= lists_.size()) return {};
    return {pool_.data(lists_[place].block), lists_[place].count};
  }

  void Add(Place place, std::uint32_t op) {
    if (place >= lists_.size()) lists_.resize(place + place / 4 + 16);
    List& list = lists_[place];
    if (list.count == list.block.capacity)
      pool_.Resize(list.block, list.count + 1 + list.count / 4);
    pool_.data(list.block)[list.count++] = op;
  }

  // REQUIRES: op subscribes to place.
  void Remove(Place place, std::uint32_t op) {
    List& list = lists_[place];
    std::uint32_t* ops = pool_.data(list.block);
    std::uint32_t i = 0;
    while (ops[i] != op) ++i;
    assert(i < list.count);
    ops[i] = ops[--list.count];
    if (list.count == 0) pool_.Free(list.block);
  }

  // Empties a place and returns who was there (their own records still name it).
  std::vector<std::uint32_t> Take(Place place) {
    const auto ops = at(place);
    std::vector<std::uint32_t> result(ops.begin(), ops.end());
    if (place < lists_.size()) {
      pool_.Free(lists_[place].block);
      lists_[place].count = 0;
    }
    return result;
  }

  // Room for so many subscriptions.
  void Reserve(std::size_t count) {
    lists_.reserve(count / 4);
    pool_.Reserve(count * 5 / 4);
  }
  std::size_t places() const { return lists_.size(); }
  std::size_t bytes() const { return lists_.size() * sizeof(List) + pool_.bytes(); }

 private:
  struct List {
    BlockPool::Block block;
    std::uint32_t count = 0;
  };
  LargeVector<List> lists_;
  BlockPool pool_;
};

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_SUBSCRIPTIONS_H_
