// The operations of a trace, and what each of them remembers: its identity, its state, and in one
// block of words its outputs, requests, places and reads. Engine alone changes the table.
// Thread-compatible.
#ifndef DYNMESH_CORE_SAC_OPERATION_TABLE_H_
#define DYNMESH_CORE_SAC_OPERATION_TABLE_H_

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/large_vector.h"
#include "core/sac/block_pool.h"
#include "core/sac/epoch_order.h"
#include "core/sac/execution.h"
#include "core/sac/subscriptions.h"

namespace dynmesh::sac {

// `Payload`: what the program keeps for each operation.
template <class Payload>
class OperationTable {
 public:
  Kind kind(OpId id) const { return ops_[id].kind; }
  Item item(OpId id) const { return ops_[id].item; }
  Epoch epoch(OpId id) const { return ops_[id].epoch; }
  Stamp stamp(OpId id) const { return ops_[id].stamp; }
  // The next operation of the same item, of any kind and epoch; kNoOp after the last one.
  OpId next_of_item(OpId id) const { return ops_[id].next_of_item; }
  bool executed(OpId id) const { return ops_[id].flags & kExecuted; }
  bool stale(OpId id) const { return ops_[id].flags & kStale; }
  const Payload& payload(OpId id) const { return ops_[id].payload; }
  // These are valid until the engine runs or drops the operation.
  std::span<const Output> outputs(OpId id) const { return Part(ops_[id], 0, ops_[id].outputs); }
  std::span<const OpId> requests(OpId id) const {
    return Part(ops_[id], ops_[id].outputs, ops_[id].requests);
  }
  std::span<const Place> places(OpId id) const {
    const Operation& op = ops_[id];
    return Part(op, op.outputs + op.requests, op.places);
  }
  std::span<const std::uint32_t> reads(OpId id) const {
    const Operation& op = ops_[id];
    return Part(op, op.outputs + op.requests + op.places, op.reads);
  }
  std::size_t operation_count() const { return ops_.size() - free_ops_.size(); }
  // Every OpId is below this. Some are free: never used, or of a dropped operation.
  std::size_t slots() const { return ops_.size(); }

 protected:
  enum : std::uint8_t { kQueued = 1, kExecuted = 2, kStale = 4 };

  struct Operation {
    std::uint64_t priority = 0;
    Epoch epoch = 0;
    Stamp stamp = kNoStamp;  // assigned at its first execution
    Item item = 0;
    OpId next_of_item = kNoOp;
    OpId next_in_epoch = kNoOp;
    BlockPool::Block links;  // outputs, requests, places and reads, in this order
    std::uint32_t refs = 0;
    // Outputs and places are few, but a point may encroach on very many segments at once.
    std::uint64_t reads : 24 = 0, requests : 24 = 0, outputs : 16 = 0;
    std::uint16_t places = 0;
    Kind kind = 0;
    std::uint8_t flags = 0;
    Payload payload = {};
  };

  // `words`: expected per operation.
  void ReserveOperations(std::size_t operations, std::size_t words) {
    ops_.reserve(operations);
    pool_.Reserve(words * operations);
  }
  // A blank operation, in a free slot if there is one.
  OpId NewOperation() {
    if (free_ops_.empty()) {
      ops_.emplace_back();
      return static_cast<OpId>(ops_.size() - 1);
    }
    const OpId id = free_ops_.back();
    free_ops_.pop_back();
    ops_[id] = {};
    return id;
  }
  // Frees the block. The slot and what is left in it stay until FreeSlot.
  void ForgetRecord(Operation& op) {
    op.outputs = op.requests = op.places = op.reads = 0;
    pool_.Free(op.links);
  }
  void FreeSlot(OpId id) { free_ops_.push_back(id); }

  // Replaces the record by that of `done`, with the operations that it requested.
  void Record(Operation& op, const Execution& done, std::span<const OpId> requested);
  // The same place under another name. Returns false, with one place less, if `to` was named
  // already.
  bool RenamePlace(Operation& op, Place from, Place to);

  std::span<const std::uint32_t> Part(const Operation& op, std::uint32_t from,
                                      std::uint32_t count) const {
    return {pool_.data(op.links) + from, count};
  }
  void PrefetchOperation(OpId id) const {
    const char* const op = reinterpret_cast<const char*>(&ops_[id]);
    __builtin_prefetch(op);
    __builtin_prefetch(op + sizeof(Operation) - 1);
  }
  // Is less than `part` of the slots or of the pool in use? False while there are few.
  bool IsTableMostlyRoom(double part) const {
    constexpr std::size_t kFew = 64;
    const auto used = static_cast<double>(operation_count());
    return (ops_.size() > kFew && used < part * static_cast<double>(ops_.size())) ||
           pool_.IsMostlyRoom(part);
  }
  std::size_t table_bytes() const {
    return ops_.size() * sizeof(Operation) + pool_.bytes() + free_ops_.capacity() * sizeof(OpId);
  }

  LargeVector<Operation> ops_;
  std::vector<OpId> free_ops_;
  BlockPool pool_;
};

template <class Payload>
void OperationTable<Payload>::Record(Operation& op, const Execution& done,
                                     std::span<const OpId> requested) {
  op.outputs = done.outputs.size();
  op.requests = requested.size();
  op.places = static_cast<std::uint16_t>(done.places.size());
  op.reads = done.reads.size();
  pool_.Resize(op.links, op.outputs + op.requests + op.places + op.reads);
  std::uint32_t* to = pool_.data(op.links);
  to = std::copy(done.outputs.begin(), done.outputs.end(), to);
  to = std::copy(requested.begin(), requested.end(), to);
  to = std::copy(done.places.begin(), done.places.end(), to);
  std::copy(done.reads.begin(), done.reads.end(), to);
}

template <class Payload>
bool OperationTable<Payload>::RenamePlace(Operation& op, Place from, Place to) {
  std::uint32_t* const begin = pool_.data(op.links) + op.outputs + op.requests;
  std::uint32_t* const end = begin + op.places;
  std::uint32_t* const at = std::find(begin, end, from);
  const bool is_new = std::find(begin, end, to) == end;
  if (is_new) {
    *at = to;
  } else {
    std::copy(at + 1, end + op.reads, at);  // one place less: the reads move up
    --op.places;
  }
  std::sort(begin, begin + op.places);
  return is_new;
}

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_OPERATION_TABLE_H_
