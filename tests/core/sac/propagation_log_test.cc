// What the log of a propagation says, against what a program was seen to do.
#include "core/sac/propagation_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "core/sac/engine_audit.h"
#include "tests/core/sac/engine_fixture.h"
#include "tests/core/sac/leader_script.h"

namespace dynmesh::sac::testing::propagation_log_test {
namespace {

class PropagationLogTest : public EngineTest {
 protected:
  using Log = PropagationLog<Engine<Program>>;
  // Item 1 makes output 7, item 2 runs later and reads place 3, where outputs of item 1 matter.
  PropagationLogTest() {
    p_[1] = Emits({7});
    p_[2] = [](Context& c) { c.Subscribe(3); };
    p_.on_publish = p_.on_withdraw = [this](Output, Stamp at) {
      e_.Notify(3, at, kNoStamp, [](OpId) { return true; });
    };
    Request(1, 0);
    Request(2, 1);
    Run();
  }
  void Propagate(Log& log) {
    EXPECT_TRUE(e_.Propagate([&log] {
      log.Look();
      return false;
    }));
    log.Look();
  }
  MadeStale Stale(Item op, Item by) { return {p_.OperationOf(op), p_.OperationOf(by)}; }
  MadeStale StaleByInput(Item op) { return {p_.OperationOf(op), kNoOp}; }
};

TEST_F(PropagationLogTest, NamesTheInputAndThenTheOperationWithAnotherOutput) {
  Log log(e_);
  p_[1] = Emits({8});
  Touch(1);
  Propagate(log);
  EXPECT_EQ(log.made_stale(), (std::vector{StaleByInput(1), Stale(2, 1)}));
  EXPECT_EQ(log.ran(), (std::vector{p_.OperationOf(1), p_.OperationOf(2)}));
}

TEST_F(PropagationLogTest, AnOperationThatRunsToTheSameOutputsIsNoCause) {
  Log log(e_);
  Touch(1);
  Propagate(log);
  EXPECT_EQ(log.made_stale(), std::vector{StaleByInput(1)});
  EXPECT_EQ(log.ran(), std::vector{p_.OperationOf(1)});
}

TEST_F(PropagationLogTest, ADroppedOperationIsACause) {
  Log log(e_);
  const MadeStale expected = Stale(2, 1);
  Unrequest(1, 0);
  Propagate(log);
  EXPECT_EQ(log.made_stale(), std::vector{expected});
  EXPECT_EQ(log.ran(), std::vector{p_.OperationOf(2)});
}

TEST_F(PropagationLogTest, ANewOperationIsACause) {
  Log log(e_);
  p_[4] = Emits({9});
  Request(4, 0);
  Propagate(log);
  EXPECT_EQ(log.made_stale(), std::vector{Stale(2, 4)});
  EXPECT_EQ(log.ran(), (std::vector{p_.OperationOf(4), p_.OperationOf(2)}));
}

// The operations present, with their outputs.
std::map<OpId, std::vector<Output>> Present(const Traced& program) {
  std::map<OpId, std::vector<Output>> present;
  std::vector<std::string> problems;
  const auto nothing = [](auto...) { return std::uint64_t{0}; };
  program.engine().Audit(
      nothing, nothing,
      [&](OpId op, std::uint64_t) {
        const auto outputs = program.engine().outputs(op);
        present[op] = {outputs.begin(), outputs.end()};
      },
      &problems);
  return present;
}

TEST(PropagationLog, EachOperationThatRanAgainHasACauseThatChanged) {
  const Line line{8, 6};
  Random random(NewSeed());
  Traced program(line);
  Input input = RandomInput(line, 40, 50, random);
  AddAll(input, &program);
  ASSERT_TRUE(program.Propagate());
  std::size_t causes = 0;
  for (int edit = 0; edit < 300; ++edit) {
    const auto before = Present(program);
    const Counters counted = program.engine().counters();
    PropagationLog log(program.engine());
    Apply(RandomBatch(line, input, 40, 50, random), &program, &input);
    ASSERT_TRUE(program.Propagate([&log] {
      log.Look();
      return false;
    }));
    log.Look();
    const auto after = Present(program);
    const auto& ran = log.ran();
    ASSERT_EQ(ran.size(), program.engine().counters().executed - counted.executed);
    ASSERT_EQ(std::ranges::count(ran, kNoOp), 0);
    const auto stale_in_log = [&](OpId op) {
      return std::ranges::count(log.made_stale(), op, &MadeStale::op);
    };
    for (const OpId op : ran) {
      ASSERT_TRUE(after.contains(op));
      ASSERT_EQ(stale_in_log(op), before.contains(op) ? 1 : 0);
    }
    for (const auto& [op, by] : log.made_stale()) {
      ASSERT_TRUE(before.contains(op));
      const auto its_run = std::ranges::find(ran, op);
      ASSERT_NE(its_run != ran.end(), !after.contains(op)) << "it ran, or it is gone";
      if (by == kNoOp) continue;
      ++causes;
      if (!after.contains(by)) continue;  // it was dropped
      ASSERT_NE(std::find(ran.begin(), its_run, by), its_run) << "the cause ran before";
      if (before.contains(by)) {
        ASSERT_NE(before.at(by), after.at(by)) << "the cause changed";
      }
    }
  }
  EXPECT_GT(causes, 300u);
}

}  // namespace
}  // namespace dynmesh::sac::testing::propagation_log_test
