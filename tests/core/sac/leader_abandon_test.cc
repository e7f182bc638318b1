// Propagations that stop half-way: the inverse edit restores the former trace; other edits, or
// none, lead to the same result as without the stop.
#include <gtest/gtest.h>

#include <vector>

#include "tests/core/sac/leader_script.h"

namespace dynmesh::sac::testing {
namespace {

// Stops before the operation number `count` (from 0).
auto After(int count) {
  return [count]() mutable { return count-- == 0; };
}

struct Setting {
  const char* name;
  Line line;
  std::size_t points;
  Weight weights;
  std::size_t fold_at = ~std::size_t{0} >> 32;
};
const Setting kSettings[] = {
    {"small", {5, 4}, 10, 100},      {"dense", {4, 3}, 12, 100},
    {"two weights", {5, 4}, 14, 2},  {"ties of priority", {5, 4, 2}, 12, 20},
    {"folding", {7, 4}, 20, 100, 8},
};

// At every operation k of the propagation of random batches: stop, undo, compare.
TEST(LeaderAbandon, TheInverseEditBringsTheFormerTraceBack) {
  const std::uint64_t seed = NewSeed();
  std::size_t abandoned = 0;
  for (const Setting& s : kSettings) {
    SCOPED_TRACE(s.name);
    for (int script = 0; script < 4; ++script) {
      Random random(seed + script);
      Traced program(s.line, s.fold_at);
      Input input = RandomInput(s.line, s.points, s.weights, random);
      AddAll(input, &program);
      program.Propagate();
      std::uint64_t former = SoundTrace(program);
      for (int step = 0; step < 30; ++step) {
        const Batch batch = RandomBatch(s.line, input, s.points, s.weights, random);
        for (int k = 0;; ++k) {
          const Batch inverse = Apply(batch, &program, &input);
          if (program.Propagate(After(k))) break;
          ++abandoned;
          Apply(inverse, &program, &input);
          ASSERT_TRUE(program.Propagate());
          ASSERT_EQ(SoundTrace(program), former)
              << "seed " << seed << " script " << script << " step " << step << " k " << k;
          ASSERT_EQ(program.Rows(), LeadersByDefinition(input, s.line));
        }
        former = SoundTrace(program);
        ASSERT_EQ(former, TraceFromScratch(s.line, input));
      }
    }
  }
  EXPECT_GT(abandoned, 1000u);
}

// The undo is interrupted too, at every operation, and then resumed.
TEST(LeaderAbandon, TheWayBackMayBeInterrupted) {
  Random random(NewSeed());
  const Line line{5, 4};
  Traced program(line);
  Input input = RandomInput(line, 10, 10, random);
  AddAll(input, &program);
  program.Propagate();
  for (int step = 0; step < 6; ++step) {
    const std::uint64_t former = SoundTrace(program);
    const Batch batch = RandomBatch(line, input, 10, 10, random);
    bool done = false;
    for (int k = 0; !done; ++k) {
      for (int back = 0;; ++back) {
        const Batch inverse = Apply(batch, &program, &input);
        done = program.Propagate(After(k));
        Apply(inverse, &program, &input);
        const bool whole = program.Propagate(After(back));
        if (!whole) {
          // Forth and back once more, without ever finishing in between.
          Apply(batch, &program, &input);
          program.Propagate(After(back / 2));
          Apply(inverse, &program, &input);
          ASSERT_TRUE(program.Propagate());
        }
        ASSERT_EQ(SoundTrace(program), former) << "step " << step << " k " << k << " " << back;
        if (whole) break;
      }
    }
    Apply(batch, &program, &input);
    program.Propagate();
    ASSERT_NO_FATAL_FAILURE(ExpectAsFromScratch(program, line, input));
  }
}

// Any edits between any number of unfinished propagations: the last input counts.
TEST(LeaderAbandon, EditsMayComeBetweenUnfinishedPropagations) {
  const std::uint64_t seed = NewSeed();
  for (const Setting& s : kSettings) {
    SCOPED_TRACE(s.name);
    for (int script = 0; script < 10; ++script) {
      Random random(seed + script);
      Traced program(s.line, s.fold_at);
      Input input;
      for (int step = 0; step < 60; ++step) {
        Apply(RandomBatch(s.line, input, s.points, s.weights, random), &program, &input);
        if (!random.OneIn(4)) {
          program.Propagate(After(static_cast<int>(random.Below(25))));
          continue;
        }
        ASSERT_TRUE(program.Propagate());
        ExpectAsFromScratch(program, s.line, input);
        if (::testing::Test::HasFailure()) {
          FAIL() << "seed " << seed << " script " << script << " step " << step;
        }
      }
    }
  }
}

TEST(LeaderAbandon, GoingOnAfterEveryOperationEqualsNotStopping) {
  Random random(NewSeed());
  const Line line{7, 5};
  Traced program(line);
  Input input;
  for (int step = 0; step < 40; ++step) {
    Apply(RandomBatch(line, input, 30, 100, random), &program, &input);
    int stops = 0;
    while (!program.Propagate(After(1))) ++stops;
    ASSERT_LT(stops, 10'000);
    ASSERT_NO_FATAL_FAILURE(ExpectAsFromScratch(program, line, input));
  }
}

TEST(LeaderAbandon, AnUntracedRunMayBeInterruptedAndGoneOnWith) {
  Random random(NewSeed());
  const Line line{7, 5};
  for (int run = 0; run < 50; ++run) {
    const Input input = RandomInput(line, 40, 100, random);
    Untraced program(line);
    for (const auto& [x, weight] : input) program.Add(x, weight);
    while (!program.Propagate(After(1))) continue;
    ASSERT_EQ(program.Rows(), LeadersByDefinition(input, line));
    Untraced at_once(line);
    for (const auto& [x, weight] : input) at_once.Add(x, weight);
    at_once.Propagate();
    ASSERT_EQ(program.engine().executed(), at_once.engine().executed());
  }
}

}  // namespace
}  // namespace dynmesh::sac::testing
