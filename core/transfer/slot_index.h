// Numbers slots in the order of first use: a small hash table with open addressing, for walks over
// a patch, which query it for every face. One thread.
#ifndef DYNMESH_CORE_TRANSFER_SLOT_INDEX_H_
#define DYNMESH_CORE_TRANSFER_SLOT_INDEX_H_

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "dynmesh/slot_mesh.h"

namespace dynmesh::transfer {

class SlotIndex {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  SlotIndex() = default;
  // Has room for `expected` slots; takes more.
  explicit SlotIndex(std::size_t expected) : entries_(std::bit_ceil(2 * expected + 64)) {
    SetShift();
  }

  std::size_t size() const { return size_; }

  // The number of `slot`, and whether it is new; a new one gets size() before the call.
  std::pair<std::uint32_t, bool> Add(Slot slot) {
    if (2 * (size_ + 1) > entries_.size()) Grow();
    Entry& entry = Find(slot);
    if (entry.slot == slot) return {entry.number, false};
    entry = {slot, static_cast<std::uint32_t>(size_++)};
    return {entry.number, true};
  }

  // kNone if it was never added.
  std::uint32_t operator[](Slot slot) const {
    if (entries_.empty()) return kNone;
    const Entry& entry = const_cast<SlotIndex*>(this)->Find(slot);
    return entry.slot == slot ? entry.number : kNone;
  }

 private:
  struct Entry {
    Slot slot = kNoSlot;
    std::uint32_t number = kNone;
  };
  // The entry of `slot`, or the free entry for it.
  Entry& Find(Slot slot) {
    const std::size_t mask = entries_.size() - 1;
    std::size_t at =
        (static_cast<std::uint32_t>(slot) * std::uint64_t{0x9e3779b97f4a7c15}) >> shift_;
    while (entries_[at].slot != slot && entries_[at].slot != kNoSlot) at = (at + 1) & mask;
    return entries_[at];
  }
  void Grow() {
    std::vector<Entry> old(entries_.empty() ? 64 : 2 * entries_.size());
    old.swap(entries_);
    SetShift();
    for (const Entry& entry : old) {
      if (entry.slot != kNoSlot) Find(entry.slot) = entry;
    }
  }
  void SetShift() { shift_ = 64 - std::countr_zero(entries_.size()); }

  std::vector<Entry> entries_;
  std::size_t size_ = 0;
  int shift_ = 64;
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_SLOT_INDEX_H_
