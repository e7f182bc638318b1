// Which operations a propagation has run, and which of them made each other one stale. For people
// and tests: the engine records nothing of it. The log looks at the operations between two steps,
// so a propagation that is not logged costs nothing more.
//
//   PropagationLog log(engine);       // before the input changes
//   ...                               // change the input
//   engine.Propagate([&log] { log.Look(); return false; });
//   log.Look();                       // what the last operation did
//
// Thread-compatible. O(slots of the engine) a look.
#ifndef DYNMESH_CORE_SAC_PROPAGATION_LOG_H_
#define DYNMESH_CORE_SAC_PROPAGATION_LOG_H_

#include <cstdint>
#include <vector>

#include "core/sac/engine.h"

namespace dynmesh::sac {

// `op` had been executed and became stale. The change that first did so is of operation `by`, which
// ran, or was dropped, just before; kNoOp: it came from outside of the trace, as input does.
struct MadeStale {
  OpId op = kNoOp;
  OpId by = kNoOp;
  friend bool operator==(const MadeStale&, const MadeStale&) = default;
};

template <class Engine>
class PropagationLog {
 public:
  // REQUIRES: nothing waits in the engine, which outlives the log.
  explicit PropagationLog(const Engine& engine) : engine_(engine), counters_(engine.counters()) {
    Resize();
  }

  // Call before each operation and after the last one, at most one operation apart.
  void Look();

  // In the order in which they became so. No operation is listed twice.
  const std::vector<MadeStale>& made_stale() const { return made_stale_; }
  // In the order in which they ran, those that are new included.
  const std::vector<OpId>& ran() const { return ran_; }

 private:
  struct State {
    bool executed = false, stale = false, has_outputs = false;
  };
  State StateOf(OpId id) const {
    return {engine_.executed(id), engine_.stale(id), !engine_.outputs(id).empty()};
  }
  void Resize() {
    for (auto id = static_cast<OpId>(states_.size()); id < engine_.slots(); ++id) {
      states_.push_back(StateOf(id));
    }
  }
  OpId WhichRan() const;
  OpId WhichWasDropped() const;

  const Engine& engine_;
  Counters counters_;
  std::vector<State> states_;  // by operation, as of the last look
  std::vector<MadeStale> made_stale_;
  std::vector<OpId> ran_;
};

template <class Engine>
void PropagationLog<Engine>::Look() {
  const Counters now = engine_.counters();
  OpId by = kNoOp;
  if (now.executed > counters_.executed) {
    by = WhichRan();
    ran_.push_back(by);
  } else if (now.dropped > counters_.dropped) {
    by = WhichWasDropped();
  }
  counters_ = now;
  for (OpId id = 0; id < states_.size(); ++id) {
    const State is = StateOf(id);
    if (is.executed && is.stale && !states_[id].stale) made_stale_.push_back({id, by});
    states_[id] = is;
  }
  Resize();
}

// A new operation is stale until it runs.
template <class Engine>
OpId PropagationLog<Engine>::WhichRan() const {
  for (OpId id = 0; id < states_.size(); ++id) {
    const bool was_waiting = states_[id].stale || !states_[id].executed;
    if (was_waiting && engine_.executed(id) && !engine_.stale(id)) return id;
  }
  return kNoOp;
}

// One without outputs changed nothing and is not looked for.
template <class Engine>
OpId PropagationLog<Engine>::WhichWasDropped() const {
  for (OpId id = 0; id < states_.size(); ++id) {
    if (states_[id].has_outputs && engine_.outputs(id).empty()) return id;
  }
  return kNoOp;
}

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_PROPAGATION_LOG_H_
