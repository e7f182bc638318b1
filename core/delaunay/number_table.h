// Numbers keys 0, 1, 2, ... in the order of their arrival: a set for searches through a mesh,
// reused from search to search. Clear is free and keeps the memory, so a search no larger than an
// earlier one allocates nothing. Thread-compatible. Each operation O(1) expected.
#ifndef DYNMESH_CORE_DELAUNAY_NUMBER_TABLE_H_
#define DYNMESH_CORE_DELAUNAY_NUMBER_TABLE_H_

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace dynmesh::delaunay {

// Key: an array of std::uint32_t.
template <std::size_t N>
class NumberTable {
 public:
  using Key = std::array<std::uint32_t, N>;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  void Clear() {
    keys_.clear();
    if (++stamp_ != 0) return;
    for (Slot& s : slots_) s.stamp = 0;  // the stamps have wrapped around
    stamp_ = 1;
  }

  // In order of their numbers.
  std::span<const Key> keys() const { return keys_; }

  std::uint32_t Find(const Key& key) const {
    if (slots_.empty()) return kNone;
    const Slot& slot = slots_[Probe(key)];
    return slot.stamp == stamp_ ? slot.number : kNone;
  }

  // The number of key; a new key gets the next number.
  std::uint32_t Number(const Key& key) {
    if (2 * (keys_.size() + 1) > slots_.size()) Grow();
    Slot& slot = slots_[Probe(key)];
    if (slot.stamp != stamp_) {
      slot = {stamp_, static_cast<std::uint32_t>(keys_.size())};
      keys_.push_back(key);
    }
    return slot.number;
  }

  std::size_t bytes() const {
    return keys_.capacity() * sizeof(Key) + slots_.capacity() * sizeof(Slot);
  }

 private:
  // In use if its stamp is the table's.
  struct Slot {
    std::uint32_t stamp, number;
  };

  // The library compares arrays by a call, which costs more than everything else here.
  static bool Same(const Key& a, const Key& b) {
    std::uint32_t differs = 0;
    for (std::size_t i = 0; i < N; ++i) differs |= a[i] ^ b[i];
    return differs == 0;
  }

  // The slot of key, or the one where it would be put.
  std::size_t Probe(const Key& key) const {
    std::uint64_t hash = 0;
    for (const std::uint32_t k : key) hash = (hash ^ k) * 0x9e3779b97f4a7c15ULL;
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = hash >> (64 - std::countr_one(mask));
    while (slots_[at].stamp == stamp_ && !Same(keys_[slots_[at].number], key)) at = (at + 1) & mask;
    return at;
  }

  void Grow() {
    slots_.assign(slots_.empty() ? 64 : 2 * slots_.size(), {0, 0});
    stamp_ = 1;
    for (std::uint32_t i = 0; i < keys_.size(); ++i) slots_[Probe(keys_[i])] = {stamp_, i};
  }

  std::vector<Key> keys_;
  std::vector<Slot> slots_;  // a power of two, at least twice as many as keys
  std::uint32_t stamp_ = 1;
};

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_CORE_DELAUNAY_NUMBER_TABLE_H_
