// A scripted program under the engine, and commands to drive it. The test fails unless the engine
// is sound at the end.
#ifndef DYNMESH_TESTS_CORE_SAC_ENGINE_FIXTURE_H_
#define DYNMESH_TESTS_CORE_SAC_ENGINE_FIXTURE_H_

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/sac/engine_audit.h"
#include "tests/core/sac/scripted_program.h"

namespace dynmesh::sac::testing {

using Program = ScriptedProgram<Engine>;
using Context = Program::Context;

inline constexpr Kind kOnly = 0;

inline std::vector<std::string> Problems(Program& p) {
  std::vector<std::string> problems;
  p.engine().Audit([](Kind, Item item) { return std::uint64_t{item}; },
                   [](OpId) { return std::uint64_t{0}; }, [](OpId, std::uint64_t) {}, &problems);
  return problems;
}

class EngineTest : public ::testing::Test {
 protected:
  ~EngineTest() override {
    const std::vector<std::string> problems = Problems(p_);
    EXPECT_TRUE(problems.empty()) << problems.front();
  }
  void Request(Item item, Epoch epoch = 0) { e_.Request(kOnly, item, epoch); }
  void Unrequest(Item item, Epoch epoch = 0) { e_.Unrequest(kOnly, item, epoch); }
  // Makes the operations of an item stale, as a change of input does.
  void Touch(Item item) { e_.NotifyChain(p_.OperationOf(item), e_.beginning()); }
  // Propagates, and returns what happened.
  std::string Run() {
    EXPECT_TRUE(e_.Propagate([] { return false; }));
    return p_.TakeLog();
  }
  std::string RunUntil(int operations) {
    EXPECT_FALSE(e_.Propagate([&] { return operations-- == 0; }));
    return p_.TakeLog();
  }
  static Program::Body Requests(std::vector<Item> items, Epoch epoch) {
    return [=](Context& c) {
      for (const Item i : items) c.Request(kOnly, i, epoch);
    };
  }
  static Program::Body Emits(std::vector<Output> outputs) {
    return [=](Context& c) {
      for (const Output o : outputs) c.Emit(o);
    };
  }

  Program p_;
  Engine<Program>& e_ = p_.engine();
};
}  // namespace dynmesh::sac::testing

#endif  // DYNMESH_TESTS_CORE_SAC_ENGINE_FIXTURE_H_
