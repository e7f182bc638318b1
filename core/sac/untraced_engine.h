// Runs the same programs without a trace: operations run once, in the same order. Only pending
// requests are remembered. engine.h says what a program is. Thread-compatible.
#ifndef DYNMESH_CORE_SAC_UNTRACED_ENGINE_H_
#define DYNMESH_CORE_SAC_UNTRACED_ENGINE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/sac/engine.h"
#include "core/sac/prefetch.h"
#include "core/sac/work_queue.h"

namespace dynmesh::sac {

template <class Program>
class UntracedEngine {
 public:
  static constexpr bool kTraced = false;
  class Context;

  explicit UntracedEngine(Program& program) : program_(program), queue_(BeforeInQueue{&program}) {}
  UntracedEngine(const UntracedEngine&) = delete;
  UntracedEngine& operator=(const UntracedEngine&) = delete;

  OpId overflowed() const { return kNoOp; }  // there are no limits: nothing is kept

  Stamp beginning() const { return 0; }
  bool Precedes(Stamp a, Stamp b) const { return a < b; }
  bool AnyAfter(Stamp) const { return false; }

  void Request(Kind kind, Item item, Epoch epoch) {
    queue_.Push(epoch, {program_.Priority(kind, item), item, kind});
  }

  // False if `interrupt` stopped it. Epochs >= `until` are left for another call.
  template <class Interrupt>
  bool Propagate(Interrupt interrupt, Epoch until = kForever) {
    while (!queue_.empty() && (until == kForever || queue_.first_epoch() < until)) {
      if (interrupt()) return false;
      const auto [epoch, entry] = queue_.Pop();
      PrefetchAhead(program_, queue_, [](const Entry& e) -> const Entry& { return e; });
      // Several requests for one operation run it once.
      if (epoch == last_epoch_ && entry.item == last_.item && entry.kind == last_.kind) continue;
      last_epoch_ = epoch;
      last_ = entry;
      ++executed_;
      ++now_;
      outputs_.clear();
      Context context(*this, entry.kind, entry.item, epoch, now_);
      program_.Execute(context);
      for (const Output o : outputs_) program_.Publish(o, now_);
    }
    return true;
  }

  std::uint64_t executed() const { return executed_; }
  std::size_t waiting() const { return queue_.size(); }

 private:
  struct Entry {
    std::uint64_t priority;
    Item item;
    Kind kind;
  };
  struct BeforeInQueue {
    const Program* program;
    bool operator()(const Entry& a, const Entry& b) const {
      return program->Before(a.kind, a.item, b.kind, b.item);
    }
  };

  Program& program_;
  WorkQueue<Entry, BeforeInQueue> queue_;
  std::vector<Output> outputs_;
  Entry last_{0, ~Item{0}, 0};  // the last operation that ran, if any
  Epoch last_epoch_ = ~Epoch{0};
  Stamp now_ = 0;
  std::uint64_t executed_ = 0;
};

template <class Program>
class UntracedEngine<Program>::Context {
 public:
  Context(UntracedEngine& engine, Kind k, Item i, Epoch e, Stamp n)
      : kind(k), item(i), epoch(e), now(n), engine_(engine) {}

  const Kind kind;
  const Item item;
  const Epoch epoch;
  const Stamp now;

  bool Sees(Stamp) const { return true; }
  void Emit(Output output) { engine_.outputs_.push_back(output); }
  void Request(Kind k, Item i, Epoch e) { engine_.Request(k, i, e); }
  void Subscribe(Place) {}
  void Read(std::uint32_t) {}
  std::span<const Output> old_outputs() const { return {}; }
  std::span<const std::uint32_t> old_reads() const { return {}; }
  typename PayloadOf<Program>::Type& payload() { return payload_; }
  bool first_time() const { return true; }

 private:
  UntracedEngine& engine_;
  typename PayloadOf<Program>::Type payload_ = {};
};

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_UNTRACED_ENGINE_H_
