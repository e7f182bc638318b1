// Blocks of 32-bit words in one contiguous array: what an operation remembers is a
// short list of ids whose length changes now and then. Blocks come in a few
// sizes, freed ones are kept per size. No allocation per operation but the
// array's own growth.
//
// References into the pool are indices; pointers die at the next Resize.
// Thread-compatible.
#ifndef DYNMESH_CORE_SAC_BLOCK_POOL_H_
#define DYNMESH_CORE_SAC_BLOCK_POOL_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/base/huge_pages.h"

namespace dynmesh::sac {

class BlockPool {
 public:
  struct Block {
    std::uint32_t offset = 0;
    std::uint32_t capacity = 0;  // in words, 0: no block
  };

  std::uint32_t* data(Block b) { return words_.data() + b.offset; }
  const std::uint32_t* data(Block b) const { return words_.data() + b.offset; }

  // Makes room for `size` words; old content is kept up to the lesser capacity.
  // A block much larger than needed is exchanged for a smaller one.
  void Resize(Block& b, std::uint32_t size) {
    const std::uint32_t wanted = RoundUp(size);
    if (wanted == b.capacity || (size <= b.capacity && b.capacity <= 2 * wanted)) return;
    Block n = Allocate(wanted);
    std::copy_n(words_.begin() + b.offset, std::min(b.capacity, wanted), words_.begin() + n.offset);
    Free(b);
    b = n;
  }

  void Free(Block& b) {
    if (b.capacity != 0) free_[ClassOf(b.capacity)].push_back(b.offset);
    b = {};
  }

  void Reserve(std::size_t words) { words_.reserve(words); }
  std::size_t bytes() const {
    std::size_t sum = words_.size() * sizeof(std::uint32_t);
    for (const auto& list : free_) sum += list.capacity() * sizeof(std::uint32_t);
    return sum;
  }

 private:
  // Capacities: 0, 2, 4, 6, ... 64, then powers of two.
  static std::uint32_t RoundUp(std::uint32_t size) {
    return size <= 64 ? (size + 1) & ~std::uint32_t{1} : std::bit_ceil(size);
  }
  static int ClassOf(std::uint32_t capacity) {
    return capacity <= 64 ? static_cast<int>(capacity / 2) : 33 + std::bit_width(capacity) - 8;
  }
  Block Allocate(std::uint32_t capacity) {
    if (capacity == 0) return {};
    auto& list = free_[ClassOf(capacity)];
    if (!list.empty()) {
      const std::uint32_t offset = list.back();
      list.pop_back();
      return {offset, capacity};
    }
    const auto offset = static_cast<std::uint32_t>(words_.size());
    words_.resize(words_.size() + capacity);
    return {offset, capacity};
  }

  LargeVector<std::uint32_t> words_;
  std::array<std::vector<std::uint32_t>, 33 + 25> free_;
};

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_BLOCK_POOL_H_
