// The untraced engine runs what the traced one runs, in the same order, once.
#include "core/sac/untraced_engine.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/core/sac/random_script.h"
#include "tests/core/sac/scripted_program.h"

namespace dynmesh::sac {
namespace {

using testing::NewSeed;
using testing::ScriptedProgram;

// A tangle of requests, a function of the seed, and an output each.
template <template <class> class E>
void Fill(std::uint64_t seed, ScriptedProgram<E>* p) {
  for (Item i = 0; i < 60; ++i) {
    (*p)[i] = [=](typename ScriptedProgram<E>::Context& c) {
      c.Emit(100 * i + static_cast<Output>(c.epoch));
      testing::Random random(seed + 1000 * i + c.epoch);
      for (int k = 0; k < 3 && c.epoch < 6; ++k) {
        const Item next = random.Below(60);
        c.Request(0, next, next > c.item && random.OneIn(2) ? c.epoch : c.epoch + 1);
      }
    };
  }
  for (Item i = 0; i < 60; i += 7) p->engine().Request(0, i, i % 3);
}

TEST(UntracedEngine, RunsWhatTheTracedEngineRuns) {
  const std::uint64_t seed = NewSeed();
  for (int run = 0; run < 30; ++run) {
    ScriptedProgram<Engine> traced;
    Fill(seed + run, &traced);
    traced.engine().Propagate();
    ScriptedProgram<UntracedEngine> untraced;
    Fill(seed + run, &untraced);
    EXPECT_TRUE(untraced.engine().Propagate([] { return false; }));
    EXPECT_EQ(untraced.TakeLog(), traced.TakeLog());
    EXPECT_EQ(untraced.engine().executed(), traced.engine().counters().executed);
  }
}

TEST(UntracedEngine, SeveralRequestsAreOneOperation) {
  ScriptedProgram<UntracedEngine> p;
  for (int i = 0; i < 3; ++i) {
    for (const Item item : {4, 2}) p.engine().Request(0, item, 1);
    p.engine().Request(1, 2, 1);  // another kind is another operation
  }
  EXPECT_TRUE(p.engine().Propagate([] { return false; }));
  EXPECT_EQ(p.TakeLog(), "run 2@1, run 2@1, run 4@1");
}

TEST(UntracedEngine, AnInterruptedRunGoesOnWhereItStopped) {
  const std::uint64_t seed = NewSeed();
  ScriptedProgram<UntracedEngine> at_once, in_steps;
  Fill(seed, &at_once);
  Fill(seed, &in_steps);
  EXPECT_TRUE(at_once.engine().Propagate([] { return false; }));
  int steps = 0;
  bool stop = false;
  while (!in_steps.engine().Propagate([&] { return stop = !stop, !stop; })) ++steps;
  EXPECT_GT(steps, 50);
  EXPECT_EQ(in_steps.TakeLog(), at_once.TakeLog());
}

}  // namespace
}  // namespace dynmesh::sac
