// Blocks of 32-bit words in one contiguous array. What an operation remembers is a short list of
// ids; its length changes now and then. Blocks come in a few sizes; freed blocks are kept per
// size. The only allocation is the array's own growth.
//
// References into the pool are indices; pointers are invalidated by the next Resize.
// Thread-compatible.
#ifndef DYNMESH_CORE_SAC_BLOCK_POOL_H_
#define DYNMESH_CORE_SAC_BLOCK_POOL_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/base/large_vector.h"

namespace dynmesh::sac {

class BlockPool {
 public:
  // Position and size class of a block, in eight bytes. Offsets have 58 bits: memory runs out
  // first.
  class Block {
   public:
    Block() = default;
    Block(std::uint64_t offset, int size_class)
        : low_(static_cast<std::uint32_t>(offset)),
          high_(static_cast<std::uint32_t>(offset >> 32)),
          size_class_(static_cast<std::uint32_t>(size_class)) {}

    std::uint64_t offset() const { return std::uint64_t{high_} << 32 | low_; }
    int size_class() const { return static_cast<int>(size_class_); }
    // In words; 0: no block.
    std::uint64_t capacity() const { return CapacityOf(size_class()); }

   private:
    std::uint32_t low_ = 0, high_ : 26 = 0, size_class_ : 6 = 0;
  };

  std::uint32_t* data(Block b) { return words_.data() + b.offset(); }
  const std::uint32_t* data(Block b) const { return words_.data() + b.offset(); }

  // Makes room for `size` words. The old content is kept, up to the smaller of the two capacities.
  // A block much larger than needed is exchanged for a smaller one. REQUIRES: size <= 2^37.
  void Resize(Block& b, std::uint64_t size) {
    const std::uint64_t wanted = RoundUp(size), capacity = b.capacity();
    if (wanted == capacity || (size <= capacity && capacity <= 2 * wanted)) return;
    const Block n = Allocate(wanted);
    std::copy_n(data(b), std::min(capacity, wanted), data(n));
    Free(b);
    b = n;
  }

  void Free(Block& b) {
    if (b.size_class() != 0) free_[static_cast<std::size_t>(b.size_class())].push_back(b.offset());
    b = {};
  }

  void Reserve(std::size_t words) { words_.reserve(words); }
  // Is less than `part` of the memory in use? False for a small pool.
  bool IsMostlyRoom(double part) const {
    constexpr std::size_t kFewBytes = 64 << 10;
    const std::size_t used = bytes() - free_bytes();
    return bytes() > kFewBytes && static_cast<double>(used) < part * static_cast<double>(bytes());
  }
  // The part of bytes() that belongs to no block.
  std::size_t free_bytes() const {
    std::size_t sum = 0;
    for (std::size_t c = 0; c < free_.size(); ++c) {
      sum += free_[c].size() * CapacityOf(static_cast<int>(c)) * sizeof(std::uint32_t) +
             free_[c].capacity() * sizeof(free_[c][0]);
    }
    return sum;
  }
  std::size_t bytes() const {
    std::size_t sum = words_.size() * sizeof(std::uint32_t);
    for (const auto& list : free_) sum += list.capacity() * sizeof(list[0]);
    return sum;
  }

 private:
  // Capacities: 0, 2, 4, 6, ... 64, then powers of two.
  static std::uint64_t RoundUp(std::uint64_t size) {
    return size <= 64 ? (size + 1) & ~std::uint64_t{1} : std::bit_ceil(size);
  }
  static int ClassOf(std::uint64_t capacity) {
    return capacity <= 64 ? static_cast<int>(capacity / 2) : 25 + std::bit_width(capacity);
  }
  static std::uint64_t CapacityOf(int size_class) {
    return size_class <= 32 ? static_cast<std::uint64_t>(2 * size_class)
                            : std::uint64_t{1} << (size_class - 26);
  }
  Block Allocate(std::uint64_t capacity) {
    if (capacity == 0) return {};
    const int size_class = ClassOf(capacity);
    auto& list = free_[static_cast<std::size_t>(size_class)];
    if (!list.empty()) {
      const std::uint64_t offset = list.back();
      list.pop_back();
      return {offset, size_class};
    }
    const std::uint64_t offset = words_.size();
    words_.resize(offset + capacity);
    return {offset, size_class};
  }

  LargeVector<std::uint32_t> words_;
  std::array<std::vector<std::uint64_t>, 64> free_;  // by size class
};

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_BLOCK_POOL_H_
