// Where a new operation belongs in the order of time: within its epoch by random
// priority, epochs by their number. Finds the neighbour after which its stamp is
// to be placed, in O(1) expected: priorities are uniform, so a table of slots by
// their leading bits, each a short sorted chain, is an ordered set.
#ifndef DYNMESH_CORE_SAC_EPOCH_ORDER_H_
#define DYNMESH_CORE_SAC_EPOCH_ORDER_H_

#include <bit>
#include <cstdint>
#include <map>
#include <vector>

#include "core/sac/order_list.h"
#include "core/sac/work_queue.h"

namespace dynmesh::sac {

using OpId = std::uint32_t;
inline constexpr OpId kNoOp = ~OpId{0};

// Operations: ops[id] has fields priority, stamp and next_in_epoch (owned here).
template <class Operations, class Before>
class EpochOrder {
 public:
  EpochOrder(Operations& ops, Before before) : ops_(ops), before_(before) {}

  // Gives ops[id] its stamp. REQUIRES: it has none.
  void Insert(Epoch epoch, OpId id) {
    Table& table = TableOf(epoch);
    if (table.count >= table.slots.size()) Rehash(table, table.slots.size() * 4);
    const std::uint64_t slot = SlotOf(table, ops_[id].priority);
    OpId before = kNoOp, after = table.slots[slot];
    while (after != kNoOp && before_(after, id)) {
      before = after;
      after = ops_[after].next_in_epoch;
    }
    ops_[id].next_in_epoch = after;
    (before == kNoOp ? table.slots[slot] : ops_[before].next_in_epoch) = id;
    ++table.count;
    const Stamp neighbour = before != kNoOp ? ops_[before].stamp : LastBefore(table, slot);
    ops_[id].stamp = order_.InsertAfter(neighbour);
  }

  // Takes ops[id] out; its stamp stays in the order until EraseStamp.
  void Remove(Epoch epoch, OpId id) {
    Table& table = TableOf(epoch);
    OpId* link = &table.slots[SlotOf(table, ops_[id].priority)];
    while (*link != id) link = &ops_[*link].next_in_epoch;
    *link = ops_[id].next_in_epoch;
    --table.count;
    // Insert walks past empty slots: few there must be.
    const std::size_t slots = table.slots.size();
    if (slots > 64 && table.count < slots / 16) Rehash(table, slots / 4);
  }
  void EraseStamp(Stamp s) { order_.Erase(s); }

  void Reserve(std::size_t operations) { order_.Reserve(operations); }
  const OrderList& order() const { return order_; }
  std::size_t epochs() const { return tables_.size(); }

  // Calls f(epoch, id) in the order of time.
  template <class F>
  void ForEach(F f) const {
    for (const auto& [epoch, table] : tables_) {
      for (OpId id : table.slots) {
        for (; id != kNoOp; id = ops_[id].next_in_epoch) f(epoch, id);
      }
    }
  }

  std::size_t bytes() const {
    std::size_t sum = order_.bytes();
    for (const auto& [epoch, table] : tables_) sum += table.slots.capacity() * sizeof(OpId) + 128;
    return sum;
  }

 private:
  struct Table {
    Stamp head = kNoStamp;  // before all operations of the epoch
    std::vector<OpId> slots;
    std::size_t count = 0;
  };

  Table& TableOf(Epoch epoch) {
    if (last_ != nullptr && last_epoch_ == epoch) return *last_;
    auto [it, fresh] = tables_.try_emplace(epoch);
    if (fresh) {
      it->second.slots.assign(1, kNoOp);
      const auto next = std::next(it);
      it->second.head =
          order_.InsertBefore(next == tables_.end() ? order_.last() : next->second.head);
    }
    last_epoch_ = epoch;
    last_ = &it->second;
    return it->second;
  }
  static std::uint64_t SlotOf(const Table& table, std::uint64_t priority) {
    const int bits = std::countr_zero(table.slots.size());
    return bits == 0 ? 0 : priority >> (64 - bits);
  }
  Stamp LastBefore(const Table& table, std::uint64_t slot) const {
    while (slot > 0) {
      OpId id = table.slots[--slot];
      if (id == kNoOp) continue;
      while (ops_[id].next_in_epoch != kNoOp) id = ops_[id].next_in_epoch;
      return ops_[id].stamp;
    }
    return table.head;
  }
  void Rehash(Table& table, std::size_t slots) {
    std::vector<OpId> old(slots, kNoOp);
    old.swap(table.slots);
    OpId* tail = nullptr;
    std::uint64_t tail_slot = 0;
    for (OpId id : old) {
      while (id != kNoOp) {
        const OpId next = ops_[id].next_in_epoch;
        ops_[id].next_in_epoch = kNoOp;
        const std::uint64_t slot = SlotOf(table, ops_[id].priority);
        if (tail == nullptr || slot != tail_slot) tail = &table.slots[slot];
        *tail = id;
        tail = &ops_[id].next_in_epoch;
        tail_slot = slot;
        id = next;
      }
    }
  }

  Operations& ops_;
  Before before_;
  OrderList order_;
  std::map<Epoch, Table> tables_;
  Epoch last_epoch_ = 0;
  Table* last_ = nullptr;
};

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_EPOCH_ORDER_H_
