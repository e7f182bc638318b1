// A program with operations scripted by a test. It records every call of the engine. For tests of
// the engine's guarantees one by one.
#ifndef DYNMESH_TESTS_CORE_SAC_SCRIPTED_PROGRAM_H_
#define DYNMESH_TESTS_CORE_SAC_SCRIPTED_PROGRAM_H_

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/sac/engine.h"
#include "core/sac/untraced_engine.h"

namespace dynmesh::sac {
namespace testing {
template <template <class> class EngineTemplate>
class ScriptedProgram;
}

template <template <class> class EngineTemplate>
struct PayloadOf<testing::ScriptedProgram<EngineTemplate>> {
  using Type = int;
};

namespace testing {

// Items are numbers below 2^18; their number is their priority and breaks ties.
template <template <class> class EngineTemplate>
class ScriptedProgram {
 public:
  using Engine = EngineTemplate<ScriptedProgram>;
  using Context = typename Engine::Context;
  using Body = std::function<void(Context&)>;

  ScriptedProgram() : engine_(*this) {}

  // The behaviour of this item's operations from now on. By default nothing.
  Body& operator[](Item item) { return bodies_[item]; }
  // Further effects when an output is published or withdrawn.
  std::function<void(Output, Stamp)> on_publish, on_withdraw;
  bool one_priority = false;

  Engine& engine() { return engine_; }
  // What happened since the last call, as in "run 3@1, +7, -8, free 8".
  std::string TakeLog() { return std::exchange(log_, {}); }
  OpId OperationOf(Item item) { return operations_[item]; }

  std::uint64_t Priority(Kind, Item item) const {
    return one_priority ? 0 : static_cast<std::uint64_t>(item) << 46;
  }
  bool Before(Kind kind_a, Item a, Kind kind_b, Item b) const {
    return kind_a != kind_b ? kind_a < kind_b : a < b;
  }
  OpId& OperationsOf(Kind, Item item) { return operations_.try_emplace(item, kNoOp).first->second; }
  static bool IsAttentive(Kind, int payload) { return payload == 1; }
  void Execute(Context& context) {
    Log("run " + std::to_string(context.item) + "@" + std::to_string(context.epoch));
    const auto it = bodies_.find(context.item);
    if (it != bodies_.end() && it->second) it->second(context);
  }
  void Publish(Output output, Stamp at) {
    Log("+" + std::to_string(output));
    if (on_publish) on_publish(output, at);
  }
  void Withdraw(Output output, Stamp at) {
    Log("-" + std::to_string(output));
    if (on_withdraw) on_withdraw(output, at);
  }
  void Release(Output output) { Log("free " + std::to_string(output)); }

 private:
  void Log(const std::string& what) { log_ += (log_.empty() ? "" : ", ") + what; }

  std::map<Item, Body> bodies_;
  std::map<Item, OpId> operations_;
  std::string log_;
  Engine engine_;
};

}  // namespace testing
}  // namespace dynmesh::sac

#endif  // DYNMESH_TESTS_CORE_SAC_SCRIPTED_PROGRAM_H_
