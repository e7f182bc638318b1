// The positions of operations in time: epochs by their number, operations within an epoch by random
// priority. For a new operation it finds the neighbour after which its stamp is placed.
//
// O(1) expected where priorities are uniform: an epoch is a table of slots, indexed by the leading
// bits of the priority, each slot a short sorted chain. An operation that arrives in the order of
// time, as in a run from scratch, is placed after the latest one.
//
// Priorities are a public function of the input, so a client can choose input with clustered
// priorities. If a chain or a run of empty slots in an epoch is longer than chance explains, the
// epoch becomes a search tree, until it is empty. Then every operation costs O(lg n), whatever the
// priorities.
#ifndef DYNMESH_CORE_SAC_EPOCH_ORDER_H_
#define DYNMESH_CORE_SAC_EPOCH_ORDER_H_

#include <bit>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <vector>

#include "absl/container/btree_set.h"
#include "core/sac/order_list.h"
#include "core/sac/work_queue.h"

namespace dynmesh::sac {

using OpId = std::uint32_t;
inline constexpr OpId kNoOp = ~OpId{0};

// ops[id] has fields priority, stamp and next_in_epoch; the last one is written here.
template <class Operations, class Before>
class EpochOrder {
 public:
  EpochOrder(Operations& ops, Before before) : ops_(ops), before_(before) {}

  // Assigns ops[id] its stamp. REQUIRES: it has none.
  void Insert(Epoch epoch, OpId id) {
    Table& table = TableOf(epoch);
    const Stamp neighbour =
        table.tree != nullptr ? InsertIntoTree(table, id) : InsertIntoSlots(table, id);
    ops_[id].stamp = order_.InsertAfter(neighbour);
  }

  // Removes ops[id] from its epoch. Its stamp stays in the order until EraseStamp.
  void Remove(Epoch epoch, OpId id) {
    Table& table = TableOf(epoch);
    if (table.tree != nullptr) return RemoveFromTree(table, id);
    std::size_t passed = 0;
    OpId* link = &table.slots[SlotOf(table, ops_[id].priority)];
    for (; *link != id; ++passed) link = &ops_[*link].next_in_epoch;
    *link = ops_[id].next_in_epoch;
    --table.count;
    if (table.latest == id) table.latest = kNoOp;
    steps_ += passed;
    if (passed > kMostInChain) return MakeTree(table);
    // Insert walks past empty slots, so they must be few.
    const std::size_t slots = table.slots.size();
    if (slots > 64 && table.count < slots / 16) Rehash(table, slots / 4);
  }
  void EraseStamp(Stamp s) { order_.Erase(s); }

  void Reserve(std::size_t operations) { order_.Reserve(operations); }
  const OrderList& order() const { return order_; }
  // Operations and empty slots passed so far while searching positions.
  std::uint64_t steps() const { return steps_; }

  // Calls f(epoch, id) in the order of time.
  template <class F>
  void ForEach(F f) const {
    for (const auto& [epoch, table] : tables_) {
      for (OpId id : table.slots) {
        for (; id != kNoOp; id = ops_[id].next_in_epoch) f(epoch, id);
      }
      if (table.tree == nullptr) continue;
      for (const OpId id : *table.tree) f(epoch, id);
    }
  }

  std::size_t bytes() const {
    std::size_t sum = order_.bytes();
    for (const auto& [epoch, table] : tables_) {
      sum += table.slots.capacity() * sizeof(OpId) + 128;
      if (table.tree != nullptr) sum += table.tree->size() * (2 * sizeof(OpId));
    }
    return sum;
  }

 private:
  // Let an epoch have n slots and between n / 16 and n operations in them. Chance makes a longer
  // chain with probability n 10^-36, a longer run of empty slots with n 10^-27.
  static constexpr std::size_t kMostInChain = 32, kMostEmpty = 1024;

  // A multiset: if one batch removes an item and adds an equal one, their operations are equal.
  using Tree = absl::btree_multiset<OpId, Before>;
  struct Table {
    Stamp head = kNoStamp;  // before all operations of the epoch
    std::vector<OpId> slots;
    std::size_t count = 0;       // in slots
    OpId latest = kNoOp;         // the operation inserted last into the slots, while it is there
    std::unique_ptr<Tree> tree;  // null, or it holds the whole epoch and there are no slots
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
  // InsertIntoSlots and InsertIntoTree return the stamp after which that of ops[id] is placed.
  Stamp InsertIntoSlots(Table& table, OpId id) {
    if (table.count >= table.slots.size()) Rehash(table, table.slots.size() * 4);
    std::uint64_t slot = SlotOf(table, ops_[id].priority);
    const OpId latest = table.latest;
    const bool follows = latest != kNoOp && before_(latest, id);
    const std::uint64_t latest_slot = follows ? SlotOf(table, ops_[latest].priority) : 0;
    OpId before = kNoOp, after = table.slots[slot];
    if (follows && latest_slot == slot) before = latest, after = ops_[latest].next_in_epoch;
    std::size_t passed = 0, empty = 0;
    for (; after != kNoOp && before_(after, id); ++passed) {
      before = after;
      after = ops_[after].next_in_epoch;
    }
    ops_[id].next_in_epoch = after;
    (before == kNoOp ? table.slots[slot] : ops_[before].next_in_epoch) = id;
    ++table.count;
    table.latest = id;
    // If it is the first in its slot, its predecessor is the last one of an earlier slot.
    for (; before == kNoOp && slot > 0; ++empty) {
      after = --slot == latest_slot && follows ? latest : table.slots[slot];
      for (; after != kNoOp; ++passed) {
        before = after;
        after = ops_[after].next_in_epoch;
      }
    }
    steps_ += passed + empty;
    if (passed > kMostInChain || empty > kMostEmpty) MakeTree(table);
    return before == kNoOp ? table.head : ops_[before].stamp;
  }
  Stamp InsertIntoTree(Table& table, OpId id) {
    const auto at = table.tree->insert(id);
    return at == table.tree->begin() ? table.head : ops_[*std::prev(at)].stamp;
  }

  void RemoveFromTree(Table& table, OpId id) {
    auto at = table.tree->lower_bound(id);
    while (*at != id) ++at;
    table.tree->erase(at);
    if (!table.tree->empty()) return;
    table.tree = nullptr;
    table.slots.assign(1, kNoOp);
  }

  void MakeTree(Table& table) {
    table.tree = std::make_unique<Tree>(before_);
    for (OpId id : table.slots) {
      for (; id != kNoOp; id = ops_[id].next_in_epoch) table.tree->insert(table.tree->end(), id);
    }
    table.slots = std::vector<OpId>();
    table.count = 0;
    table.latest = kNoOp;
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
  std::uint64_t steps_ = 0;
  Epoch last_epoch_ = 0;
  Table* last_ = nullptr;
};

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_EPOCH_ORDER_H_
