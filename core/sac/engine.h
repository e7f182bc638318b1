// The self-adjusting engine. It runs a program and records what each operation read and made (the
// *trace*). After a change of input it re-runs only the operations with changed reads.
//
// A *program* is a set of procedures over *items* (opaque indices). An operation is a triple (kind,
// item, epoch). Its time is (epoch, priority, tie-break of the program), a function of the triple
// alone: neither the requester nor the time of the request changes it. An operation reads the state
// as of its time, emits *outputs* (opaque words: objects it makes, states it sets) and requests
// later operations. An operation exists while it is requested.
//
// An operation depends on a *region*, not on a list of reads: it subscribes to a few places. A
// change at a place notifies those subscribers of the place that are later than the change and pass
// the program's own filter.
//
// A run from scratch is change propagation from the empty trace. Invariants, all checked by
// Audit() (engine_audit.h):
//   1. requests and notifications go only to later times;
//   2. refs(o) = number of requests for o by live operations and the environment;
//      o exists iff refs(o) > 0, or it is queued to be dropped;
//   3. the subscribers of a place are the operations that name it, once each;
//   4. after Propagate nothing is queued, and every live operation has been executed.
// Why the result equals that of a run from scratch, by induction over time: when o is popped, all
// earlier operations are final. If o's region changed, o was notified and runs again. Else its
// stored outputs are what it would compute again.
//
// The engine knows no geometry. Thread-compatible. REQUIRES of a program: program.h.
//
// Callback graph, with the names of the mesher in brackets.
//
//      caller (LiveMesh)
//         | changes of input, Propagate
//         v
//    +-----------------+   Request, Unrequest, Propagate       +------------------------+
//    | Program         | ------------------------------------> | Engine                 |
//    | (Refinement)    |   Notify..., ReplacePlace, reads, ... | queue, records, time   |
//    |                 | <------------------------------------ |                        |
//    +-----------------+   Execute, Publish, Withdraw,         +------------------------+
//       |          ^       Release, affected, Priority, ...        | Add, Set, Remove, at
//       | Insert,  | visit(place, parts),                          v
//       v Remove   | on_merge                                  +------------------------+
//    +-----------------+                                       | Subscriptions          |
//    | index of places |   Take: called by the program's       | place -> operations    |
//    | (SpatialTree)   |   on_merge, which moves subscribers   |                        |
//    +-----------------+                                       +------------------------+
//
//   1. Input changes, between propagations.
//      Program (AddPoint, RemovePoint, ...)
//        -> Engine::Request, Unrequest -> Program::OperationsOf, Priority; queue the operation
//        -> index: Insert, Remove; then notify (4) as of beginning()
//   2. Propagate: the same loop from scratch and after a change.
//      Engine: pop the earliest operation (ties: Program::Before)
//        stale    -> Program::Execute(Context)  reads program state, fills the Context's lists
//                 -> commit (3)
//        refs = 0 -> drop: Program::Withdraw of each output -> notify (4); release its requests
//      at the end -> Program::Release, once for each Withdraw
//      From scratch subscriptions are only collected until the end (Subscriptions::BeginLoad),
//      and notifications are skipped: nothing later has been executed (AnyAfter).
//   3. Commit of an operation.
//      create requested operations; Subscriptions::Remove, Set, Add;
//      new outputs  -> Program::Publish  -> index: Insert; notify (4)
//      lost outputs -> Program::Withdraw -> index: Remove; notify (4)
//                        merge of leaves -> Subscriptions::Take, Engine::ReplacePlace
//      release the requests of the previous execution; refs = 0 -> queue
//   4. Notify.
//      Program (Notifier::OfVertex, ...) -> index: visit places
//        -> Engine::Notify(place, parts, after, until, affected) -> Subscriptions::at
//          -> affected(op) (ReadFilter::VertexMatters, ...) -> Engine::kind, item, payload, reads
//          true -> op is stale and queued; it is later than the change, so (2) pops it later
//   5. Undo. The engine has no rollback: the caller applies the inverse change of input (1) and
//      propagates again (2). This holds after an interrupted propagation, too.
#ifndef DYNMESH_CORE_SAC_ENGINE_H_
#define DYNMESH_CORE_SAC_ENGINE_H_

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/sac/block_pool.h"
#include "core/sac/epoch_order.h"
#include "core/sac/execution.h"
#include "core/sac/operation_table.h"
#include "core/sac/order_list.h"
#include "core/sac/prefetch.h"
#include "core/sac/program.h"
#include "core/sac/subscriptions.h"
#include "core/sac/work_queue.h"

namespace dynmesh::sac {

template <class Program>
class Engine : public OperationTable<typename PayloadOf<Program>::Type> {
 public:
  using Table = OperationTable<typename PayloadOf<Program>::Type>;
  static constexpr bool kTraced = true;
  class Context;
  using Table::executed, Table::operation_count, Table::outputs, Table::places, Table::requests;

  explicit Engine(Program& program)
      : program_(program), time_(Table::ops_, BeforeInEpoch{this}), queue_(BeforeInQueue{this}) {}
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  // The time before every operation: that of the input.
  Stamp beginning() const { return time_.order().first(); }
  bool Precedes(Stamp a, Stamp b) const { return time_.order().Precedes(a, b); }

  // Requests of the environment: the operations that the input needs.
  void Request(Kind kind, Item item, Epoch epoch) { ++ops_[FindOrCreate(kind, item, epoch)].refs; }
  void Unrequest(Kind kind, Item item, Epoch epoch) { DropReference(Find(kind, item, epoch)); }

  // Re-runs stale operations until there are none. `interrupt()` is called before each operation.
  // If it returns true, the propagation stops and returns false. Another Propagate, possibly after
  // further changes of input, continues from that state. The same happens if an operation exceeds
  // its limits or there are too many operations: see overflowed(). Epochs >= `until` are left for
  // another call, which must follow: nothing is released before it. Between the two calls the
  // environment may request operations of these epochs.
  template <class Interrupt = NoInterrupt>
  bool Propagate(Interrupt interrupt = {}, Epoch until = kForever) {
    queue_.Rewind();
    overflowed_ = kNoOp;
    if (IsFromScratch()) subscriptions_.BeginLoad();  // no subscriber is later than what follows
    while (!queue_.empty() && (until == kForever || queue_.first_epoch() < until)) {
      if (interrupt() || overflowed_ != kNoOp) {
        subscriptions_.EndLoad();
        return false;
      }
      const auto [epoch, entry] = queue_.Pop();
      if (const QueueEntry* soon = queue_.Ahead(8)) __builtin_prefetch(&ops_[soon->op], 1);
      PrefetchAhead(program_, queue_,
                    [&](const QueueEntry& e) -> const Operation& { return ops_[e.op]; });
      Operation& op = ops_[entry.op];
      const bool stale = op.flags & kStale;
      op.flags &= ~(kQueued | kStale);
      if (op.refs == 0) {
        Drop(entry.op);
      } else if (stale) {
        Execute(entry.op);
      }
    }
    subscriptions_.EndLoad();
    if (until == kForever) ReleaseWithdrawn();
    return true;
  }
  // The operation at which limits stopped the last propagation; kNoOp if none did.
  OpId overflowed() const { return overflowed_; }
  void set_limits(const EngineLimits& limits) { limits_ = limits; }

  // --- Notification -------------------------------------------------------------

  // Marks stale each subscriber of `place` with a time in (after, until] for which affected(op)
  // holds. until = kNoStamp: no upper bound. Reaches a subscriber only if (subscribed parts &
  // parts) == parts.
  template <class Affected>
  void Notify(Place place, Parts parts, Stamp after, Stamp until, Affected affected) {
    const std::span<const OpId> asked = subscriptions_.SubscribersOfAll(place, parts);
    counters_.notified += asked.size();
    // After an edit far away no subscriber is in a cache. So they are prefetched in two steps: each
    // step reads the address that the step before has fetched.
    constexpr std::size_t kFar = 24, kNear = 12;
    for (std::size_t i = 0; i < std::min(kFar, asked.size()); ++i) PrefetchOperation(asked[i]);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      if (i + kFar < asked.size()) PrefetchOperation(asked[i + kFar]);
      if (i + kNear < asked.size()) PrefetchReads(ops_[asked[i + kNear]]);
      Tell(asked[i], after, until, affected);
    }
  }
  // The same for all subscribers of the place, whatever parts they subscribe to.
  template <class Affected>
  void Notify(Place place, Stamp after, Stamp until, Affected affected) {
    Notify(place, Parts{0}, after, until, affected);
  }
  // The same of a change that holds from the beginning: all executed operations are later.
  template <class Affected>
  void NotifyFromBeginning(Place place, Affected affected) {
    const auto asked = subscriptions_.at(place);
    counters_.notified += asked.size();
    constexpr std::size_t kFar = 16;
    for (std::size_t i = 0; i < std::min(kFar, asked.size()); ++i) PrefetchOperation(asked[i].op);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      if (i + kFar < asked.size()) PrefetchOperation(asked[i + kFar].op);
      const OpId id = asked[i].op;
      if (!(ops_[id].flags & kStale) && affected(id)) MarkStale(id);
    }
  }
  // True if no operation has been executed yet. Then operations run in the order of time, once
  // each.
  bool IsFromScratch() const { return frontier_ == beginning(); }
  // The same for attentive subscribers alone, whatever parts they subscribe to. O(their number).
  template <class Affected>
  void NotifyAttentive(Place place, Stamp after, Stamp until, Affected affected) {
    const auto asked = subscriptions_.attentive_at(place);
    counters_.notified += asked.size();
    for (const auto& [op, parts] : asked) Tell(op, after, until, affected);
  }
  // Marks operation `id` stale if its time is in (after, until] and affected(id) holds.
  template <class Affected>
  void NotifyOperation(OpId id, Stamp after, Stamp until, Affected affected) {
    ++counters_.notified;
    Tell(id, after, until, affected);
  }
  // True if a change at time `after` may make an operation stale.
  bool AnyAfter(Stamp after) const { return Precedes(after, frontier_); }
  // Marks stale every executed operation of the chain at `head` later than `after`.
  void NotifyChain(OpId head, Stamp after) {
    for (OpId id = head; id != kNoOp; id = ops_[id].next_of_item) {
      const Operation& op = ops_[id];
      if (!(op.flags & kStale) && Precedes(after, op.stamp)) MarkStale(id);
    }
  }
  // For moving subscriptions when the program's places are rebuilt.
  Subscriptions& subscriptions() { return subscriptions_; }
  const Subscriptions& subscriptions() const { return subscriptions_; }
  // Operation `id` names `to` in place of `from`, and subscribes to all parts of it. The caller
  // removes its subscription at `from`.
  void ReplacePlace(OpId id, Place from, Place to);

  // --- Memory -----------------------------------------------------------------------

  // Dropped operations leave free slots and free blocks. True if less than `part` of the slots, of
  // the records' pool or of the subscriptions' pool is in use. O(1).
  bool IsMostlyRoom(double part) const {
    return this->IsTableMostlyRoom(part) || subscriptions_.pool().IsMostlyRoom(part);
  }
  // Operations queued: stale, or to be dropped.
  std::size_t waiting() const { return queue_.size(); }
  std::size_t waiting_in(Epoch epoch) const { return queue_.SizeIn(epoch); }
  const Counters& counters() const { return counters_; }
  void ResetCounters() { counters_ = {}; }
  // The steps taken so far to find the operations' positions in time (epoch_order.h).
  std::uint64_t order_steps() const { return time_.steps(); }
  // Reserves room for so many operations with so many words each. Unused room costs no memory.
  void Reserve(std::size_t operations, std::size_t words) {
    this->ReserveOperations(operations, words);
    subscriptions_.Reserve(4 * operations);
    time_.Reserve(operations);
  }
  std::size_t bytes() const {
    return this->table_bytes() + time_.bytes() + subscriptions_.bytes() + queue_.bytes();
  }

  // --- For tests and audits: engine_audit.h says what these do ------------------------

  template <class HashItem, class HashOp, class OnOp>
  std::uint64_t Audit(HashItem hash_item, HashOp hash_op, OnOp on_op,
                      std::vector<std::string>* problems) const;
  template <class SameReads>
  bool Reproduces(OpId id, SameReads same_reads, std::string* why);

 private:
  using Table::free_ops_, Table::ops_, Table::pool_;
  using Table::kExecuted, Table::kQueued, Table::kStale;
  using Table::Part, Table::PrefetchOperation;
  using typename Table::Operation;

  // Prefetches what Notify reads beside the operation.
  void PrefetchReads(const Operation& op) const {
    time_.order().Prefetch(op.stamp);
    if constexpr (requires { program_.Prefetch(op.kind, op.item, 0); }) {
      program_.Prefetch(op.kind, op.item, 0);
    }
  }
  struct QueueEntry {
    std::uint64_t priority;
    OpId op;
  };
  struct BeforeInQueue {
    const Engine* engine;
    bool operator()(const QueueEntry& a, const QueueEntry& b) const {
      const Operation &x = engine->ops_[a.op], &y = engine->ops_[b.op];
      return engine->program_.Before(x.kind, x.item, y.kind, y.item);
    }
  };
  struct BeforeInEpoch {
    const Engine* engine;
    bool operator()(OpId a, OpId b) const {
      const Operation &x = engine->ops_[a], &y = engine->ops_[b];
      if (x.priority != y.priority) return x.priority < y.priority;
      return engine->program_.Before(x.kind, x.item, y.kind, y.item);
    }
  };

  OpId Find(Kind kind, Item item, Epoch epoch) const {
    OpId id = program_.OperationsOf(kind, item);
    while (id != kNoOp && (ops_[id].kind != kind || ops_[id].epoch != epoch)) {
      id = ops_[id].next_of_item;
    }
    return id;
  }

  OpId FindOrCreate(Kind kind, Item item, Epoch epoch) {
    OpId id = Find(kind, item, epoch);
    if (id != kNoOp) return id;
    id = this->NewOperation();
    Operation& op = ops_[id];
    op.priority = program_.Priority(kind, item);
    op.epoch = epoch;
    op.item = item;
    op.kind = kind;
    OpId& head = program_.OperationsOf(kind, item);
    op.next_of_item = head;
    head = id;
    ++counters_.created;
    MarkStale(id);
    return id;
  }

  void Enqueue(OpId id) {
    Operation& op = ops_[id];
    if (op.flags & kQueued) return;
    op.flags |= kQueued;
    queue_.Push(op.epoch, {op.priority, id});
  }
  void MarkStale(OpId id) {
    ops_[id].flags |= kStale;
    Enqueue(id);
  }
  template <class Affected>
  void Tell(OpId id, Stamp after, Stamp until, Affected affected) {
    const Operation& op = ops_[id];
    if (op.flags & kStale || !Precedes(after, op.stamp)) return;
    if (until != kNoStamp && Precedes(until, op.stamp)) return;
    if (affected(id)) MarkStale(id);
  }

  void DropReference(OpId id) {
    assert(id != kNoOp && ops_[id].refs > 0);
    if (--ops_[id].refs == 0) Enqueue(id);
  }

  bool IsAttentive(const Operation& op) const {
    if constexpr (requires { program_.IsAttentive(op.kind, op.payload); }) {
      return program_.IsAttentive(op.kind, op.payload);
    }
    return false;
  }
  void Execute(OpId id);
  void Forgo(OpId id);
  void Commit(OpId id);
  void Drop(OpId id);
  void ReleaseWithdrawn();
  bool IsLater(OpId id, OpId than) const;

  Program& program_;
  EpochOrder<LargeVector<Operation>, BeforeInEpoch> time_;
  WorkQueue<QueueEntry, BeforeInQueue> queue_;
  Subscriptions subscriptions_;
  EngineLimits limits_;
  OpId overflowed_ = kNoOp;
  Stamp frontier_ = 0;  // no executed operation is later
  Counters counters_;

  Execution made_;  // by the operation that runs
  std::vector<OpId> requested_;
  std::vector<std::uint32_t> scratch_;

  // Nothing is freed or reused before the end of a propagation.
  std::vector<Output> withdrawn_;
  std::vector<OpId> dropped_;
};

template <class Program>
void Engine<Program>::Execute(OpId id) {
  ++counters_.executed;
  if (ops_[id].stamp == kNoStamp) time_.Insert(ops_[id].epoch, id);
  made_.Clear();
  Context context(*this, id);
  program_.Execute(context);
  made_.JoinSubscriptions();
  if (made_.Exceeds(limits_) || ops_.size() > limits_.operations) return Forgo(id);
  Commit(id);
  if (Precedes(frontier_, ops_[id].stamp)) frontier_ = ops_[id].stamp;
}

// Forgets the lists of the execution, as if it had not run. The operation stays stale, so its
// previous record is not used. But it may have made objects, so later operations are no run from
// scratch.
template <class Program>
void Engine<Program>::Forgo(OpId id) {
  overflowed_ = id;
  const auto old = outputs(id);
  for (const Output o : made_.outputs) {
    if (std::ranges::find(old, o) == old.end()) withdrawn_.push_back(o);
  }
  MarkStale(id);
  if (Precedes(frontier_, ops_[id].stamp)) frontier_ = ops_[id].stamp;
}

// New requests and outputs are acquired before old ones are released. Else sub-traces that both
// share would be dropped and made again.
template <class Program>
void Engine<Program>::Commit(OpId id) {
  requested_.clear();
  for (const Execution::Requested& r : made_.requests) {
    const OpId requested = FindOrCreate(r.kind, r.item, r.epoch);
    assert(IsLater(requested, id));
    ++ops_[requested].refs;
    requested_.push_back(requested);
  }

  Operation& op = ops_[id];
  const bool again = op.flags & kExecuted;
  op.flags |= kExecuted;
  const std::uint32_t old_outputs = op.outputs, old_requests = op.requests, old_places = op.places;
  const auto old = Part(op, 0, old_outputs + old_requests + old_places);
  scratch_.assign(old.begin(), old.end());

  this->Record(op, made_, requested_);

  const auto was_outputs = std::span(scratch_).subspan(0, old_outputs);
  const auto was_requests = std::span(scratch_).subspan(old_outputs, old_requests);
  const auto was_places = std::span(scratch_).subspan(old_outputs + old_requests, old_places);
  const Stamp at = op.stamp;
  if (again && std::ranges::equal(was_outputs, made_.outputs) &&
      std::ranges::equal(was_requests, requested_)) {
    ++counters_.unchanged;
  }
  for (const Place p : was_places) {
    if (!std::ranges::binary_search(made_.places, p)) subscriptions_.Remove(p, id);
  }
  const bool attentive = IsAttentive(op);
  for (const auto& [place, parts] : made_.subscriptions) {
    if (std::ranges::binary_search(was_places, place)) {
      subscriptions_.Set(place, id, parts, attentive);
    } else {
      subscriptions_.Add(place, id, parts, attentive);
    }
  }
  for (const Output o : made_.outputs) {
    if (std::ranges::find(was_outputs, o) == was_outputs.end()) program_.Publish(o, at);
  }
  for (const Output o : was_outputs) {
    if (std::ranges::find(made_.outputs, o) != made_.outputs.end()) continue;
    program_.Withdraw(o, at);
    withdrawn_.push_back(o);
  }
  for (const OpId r : was_requests) DropReference(r);
}

template <class Program>
void Engine<Program>::Drop(OpId id) {
  ++counters_.dropped;
  const auto out = outputs(id);
  scratch_.assign(out.begin(), out.end());
  const Stamp at = ops_[id].stamp;
  for (const Output o : scratch_) {
    program_.Withdraw(o, at);
    withdrawn_.push_back(o);
  }
  Operation& op = ops_[id];
  for (const OpId r : requests(id)) DropReference(r);
  for (const Place p : places(id)) subscriptions_.Remove(p, id);
  OpId* link = &program_.OperationsOf(op.kind, op.item);
  while (*link != id) link = &ops_[*link].next_of_item;
  *link = op.next_of_item;
  if (op.stamp != kNoStamp) time_.Remove(op.epoch, id);
  this->ForgetRecord(op);
  dropped_.push_back(id);
}

template <class Program>
void Engine<Program>::ReleaseWithdrawn() {
  for (const Output o : withdrawn_) program_.Release(o);
  withdrawn_.clear();
  for (const OpId id : dropped_) {
    if (ops_[id].stamp != kNoStamp) {
      // Conservative: the true frontier is unknown here, but nothing is later than last().
      if (ops_[id].stamp == frontier_) frontier_ = time_.order().last();
      time_.EraseStamp(ops_[id].stamp);
    }
    ops_[id].stamp = kNoStamp;
    this->FreeSlot(id);
  }
  dropped_.clear();
}

template <class Program>
bool Engine<Program>::IsLater(OpId id, OpId than) const {
  const Operation &a = ops_[id], &b = ops_[than];
  if (a.epoch != b.epoch) return a.epoch > b.epoch;
  return BeforeInEpoch{this}(than, id);
}

// May run while an operation is being committed: uses no shared scratch.
template <class Program>
void Engine<Program>::ReplacePlace(OpId id, Place from, Place to) {
  Operation& op = ops_[id];
  if (this->RenamePlace(op, from, to)) {
    subscriptions_.Add(to, id, kAllParts, IsAttentive(op));
  } else {
    subscriptions_.Set(to, id, kAllParts, IsAttentive(op));
  }
}

}  // namespace dynmesh::sac

#include "core/sac/context.h"  // IWYU pragma: export

#endif  // DYNMESH_CORE_SAC_ENGINE_H_
