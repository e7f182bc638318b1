// What checks the engine: its invariants, the hash of a trace, and whether the record of an
// operation is what the operation makes now. For tests and audits.
#ifndef DYNMESH_CORE_SAC_ENGINE_AUDIT_H_
#define DYNMESH_CORE_SAC_ENGINE_AUDIT_H_

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/sac/engine.h"

namespace dynmesh::sac {

// Checks every invariant. `hash_op(op) -> uint64` must hash by value what the operation remembers
// (payload, outputs, reads), `hash_item(kind, item) -> uint64` what it is. The result is the hash
// of the trace: the sum over all operations, with epochs, references and requests mixed in. Calls
// on_op(op, its summand) in the order of time.
template <class Program>
template <class HashItem, class HashOp, class OnOp>
std::uint64_t Engine<Program>::Audit(HashItem hash_item, HashOp hash_op, OnOp on_op,
                                     std::vector<std::string>* problems) const {
  auto mix = [](std::uint64_t h, std::uint64_t x) {  // of two words; golden traces depend on it
    h = (h ^ x) * 0x9e3779b97f4a7c15ULL;
    return h ^ (h >> 29);
  };
  auto complain = [&](OpId id, const char* what) {
    if (problems->size() < 20) {
      problems->push_back("operation " + std::to_string(id) + " (kind " +
                          std::to_string(ops_[id].kind) + ", epoch " +
                          std::to_string(ops_[id].epoch) + "): " + what);
    }
  };
  std::string why;
  if (!time_.order().Check(&why)) problems->push_back("order list: " + why);
  if (!queue_.empty()) problems->push_back("the queue is not empty");

  std::vector<std::uint32_t> refs(ops_.size(), 0);
  std::vector<std::uint64_t> subscribed(subscriptions_.places(), 0);
  std::uint64_t sum = 0;
  std::size_t count = 0;
  OpId last = kNoOp;
  time_.ForEach([&](Epoch epoch, OpId id) {
    ++count;
    const Operation& op = ops_[id];
    if (op.epoch != epoch) complain(id, "stands in another epoch's table");
    if (!(op.flags & kExecuted)) complain(id, "was never executed");
    if (op.flags & (kQueued | kStale)) complain(id, "is still queued");
    if (Find(op.kind, op.item, op.epoch) != id) complain(id, "is not found by its identity");
    if (last != kNoOp && !Precedes(ops_[last].stamp, op.stamp)) complain(id, "stamp out of order");
    if (last != kNoOp && !IsLater(id, last)) complain(id, "place in time is out of order");
    last = id;
    std::uint64_t h = mix(mix(hash_item(op.kind, op.item), op.epoch), hash_op(id));
    std::uint64_t requested = 0;
    for (const OpId r : requests(id)) {
      ++refs[r];
      if (!IsLater(r, id)) complain(r, "is not later than its requester");
      requested += mix(mix(hash_item(ops_[r].kind, ops_[r].item), ops_[r].epoch), ops_[r].kind);
    }
    const std::uint64_t summand = mix(mix(h, requested), mix(op.refs, op.kind));
    sum += summand;
    on_op(id, summand);
    for (const Place p : places(id)) {
      if (p >= subscribed.size()) {
        complain(id, "names a place without its subscription");
      } else {
        subscribed[p] += mix(1, id);
      }
    }
  });
  if (count != operation_count()) problems->push_back("an operation is in no epoch's table");
  time_.ForEach([&](Epoch, OpId id) {
    if (refs[id] > ops_[id].refs) complain(id, "has fewer references than requesters");
    if (ops_[id].refs == 0) complain(id, "lives without a request");
  });
  for (Place p = 0; p < subscribed.size(); ++p) {
    std::uint64_t listed = 0;
    std::size_t left = subscriptions_.attentive_at(p).size();
    for (const auto& [id, parts] : subscriptions_.at(p)) {
      listed += mix(1, id);
      if (IsAttentive(ops_[id]) != (left > 0)) complain(id, "is taken for attentive, or is not");
      if (left > 0) --left;
    }
    if (listed != subscribed[p]) {
      problems->push_back("place " + std::to_string(p) +
                          ": subscribers are not those that name it");
    }
  }
  return sum;
}

// The oracle of notifications. An operation with a change in what it read must have run again. So
// after a completed propagation each operation, executed once more, makes what its record says. A
// filter that misses a change shows here, at the first operation that it concerns.
//
// 1. The operation runs as if for the first time: not marked as executed, without reads, with an
//    empty payload. So a program that takes up a former result computes it anew.
// 2. It has its former outputs, so that it emits those again that are equal.
// 3. It reads the state as of its time. So what a program keeps for one propagation alone may be
//    empty, and what stands outside of time must be as it was when the operation ran last.
// 4. Compared are outputs and requests (kind, item, epoch), each in any order. What it keeps, the
//    program compares: same_reads(id, payload, reads), of the new run, is true if the record of
//    `id` agrees. Places are not compared: they depend on the present cells.
// 5. What it makes beyond its former outputs is released at once. The record, with its payload, is
//    as before. Program::Execute may have other effects, as counters.
//
// REQUIRES: nothing waits, `id` was executed. *why, if given: what differs, if anything does.
template <class Program>
template <class SameReads>
bool Engine<Program>::Reproduces(OpId id, SameReads same_reads, std::string* why) {
  assert(queue_.empty() && executed(id));
  made_.Clear();
  const Operation record = ops_[id];
  ops_[id].flags &= static_cast<std::uint8_t>(~kExecuted);
  ops_[id].reads = 0;
  ops_[id].payload = {};
  Context context(*this, id);
  program_.Execute(context);
  const auto payload = std::exchange(ops_[id].payload, record.payload);
  ops_[id].reads = record.reads;
  ops_[id].flags = record.flags;

  const auto sorted = [](auto words) {
    std::vector<std::uint32_t> list(words.begin(), words.end());
    std::sort(list.begin(), list.end());
    return list;
  };
  const std::vector<Output> was = sorted(outputs(id)), is = sorted(std::span(made_.outputs));
  requested_.clear();
  for (const Execution::Requested& r : made_.requests)
    requested_.push_back(Find(r.kind, r.item, r.epoch));
  const std::vector<OpId> had = sorted(Part(record, record.outputs, record.requests));
  const char* differs = nullptr;
  if (was != is) {
    differs = "outputs";
  } else if (had != sorted(std::span(requested_))) {
    differs = "requests";
  } else if (!same_reads(id, payload, std::span<const std::uint32_t>(made_.reads))) {
    differs = "reads";
  }
  for (const Output o : is) {
    if (!std::ranges::binary_search(was, o)) program_.Release(o);
  }
  if (differs != nullptr && why != nullptr) *why = differs;
  return differs == nullptr;
}

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_ENGINE_AUDIT_H_
