// The engine with a whole program: dynamic equals from scratch equals by definition, traced and
// untraced; the work of an edit; and the findings of an audit.
#include "tests/core/sac/leader_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/core/sac/leader_script.h"

namespace dynmesh::sac::testing {
namespace {

struct Shape {
  const char* name;
  Line line;
  std::size_t points;  // about so many
  Weight weights;      // below this: few values, many ties
  std::size_t fold_at = ~std::size_t{0} >> 32;
};
const Shape kShapes[] = {
    {"sparse", {8, 6}, 20, 1000},
    {"dense", {5, 4}, 24, 1000},
    {"equal weights", {6, 5}, 30, 1},
    {"two weights", {6, 5}, 30, 2},
    {"ties of priority", {6, 5, 3}, 30, 50},
    {"one priority", {5, 4, 1}, 20, 50},
    {"tiny", {3, 3}, 4, 3},
    {"few", {6, 6}, 3, 5},
    {"one level", {6, 1}, 40, 1000},
    {"folding", {9, 5}, 40, 1000, 12},
};

TEST(LeaderProgram, FromScratchEqualsTheDefinition) {
  const std::uint64_t seed = NewSeed();
  for (const Shape& shape : kShapes) {
    SCOPED_TRACE(shape.name);
    for (int run = 0; run < 60; ++run) {
      Random random(seed + run);
      const std::size_t n =
          random.Below(std::min<std::size_t>(2 * shape.points, shape.line.side()));
      const Input input = RandomInput(shape.line, n, shape.weights, random);
      const auto expected = LeadersByDefinition(input, shape.line);
      Traced traced(shape.line, shape.fold_at);
      AddAll(input, &traced);
      traced.Propagate();
      ASSERT_EQ(traced.Rows(), expected);
      SoundTrace(traced);
      Untraced untraced(shape.line, shape.fold_at);
      for (const auto& [x, weight] : input) untraced.Add(x, weight);
      untraced.Propagate();
      ASSERT_EQ(untraced.Rows(), expected);
      ASSERT_EQ(untraced.engine().executed(), traced.engine().counters().executed);
    }
  }
}

TEST(LeaderProgram, TheTraceDoesNotDependOnTheOrderOfInputNorOnThePlaces) {
  Random random(NewSeed());
  const Line line{9, 6};
  const Input input = RandomInput(line, 100, 1000, random);
  const std::uint64_t expected = TraceFromScratch(line, input);
  std::vector<Position> order;
  for (const auto& [x, weight] : input) order.push_back(x);
  for (int run = 0; run < 10; ++run) {
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.Below(i)]);
    Traced program(line);
    for (int folds = run % 5; folds > 0; --folds) ASSERT_TRUE(program.Fold());
    if (run % 5 == 4) {
      EXPECT_FALSE(program.Fold()) << "the root has no parent";
    }
    for (const Position x : order) program.Add(x, input.at(x));
    program.Propagate();
    EXPECT_EQ(SoundTrace(program), expected);
    // And places may move under a finished trace.
    if (program.Fold()) {
      EXPECT_EQ(SoundTrace(program), expected);
    }
  }
}

TEST(LeaderProgram, DynamicEqualsFromScratchAfterEveryEdit) {
  const std::uint64_t seed = NewSeed();
  for (const Shape& shape : kShapes) {
    SCOPED_TRACE(shape.name);
    for (int script = 0; script < 6; ++script) {
      Random random(seed + script);
      Traced program(shape.line, shape.fold_at);
      Input input;
      for (int step = 0; step < 120; ++step) {
        // Up, and down to nothing at the end.
        const std::size_t aim = step < 80 ? shape.points : 1;
        Apply(RandomBatch(shape.line, input, aim, shape.weights, random), &program, &input);
        ASSERT_TRUE(program.Propagate());
        ExpectAsFromScratch(program, shape.line, input);
        if (::testing::Test::HasFailure()) {
          FAIL() << "seed " << seed << " script " << script << " step " << step;
        }
      }
      while (!input.empty()) Apply({{input.begin()->first, false}}, &program, &input);
      program.Propagate();
      EXPECT_EQ(program.engine().operation_count(), 0u);
      EXPECT_TRUE(program.Rows().empty());
      if (shape.fold_at < 1000) {
        EXPECT_GT(program.folds(), 0);
      }
    }
  }
}

TEST(LeaderProgram, FoldingBetweenEditsChangesNothing) {
  Random random(NewSeed());
  const Line line{9, 4};
  Traced program(line);
  Input input;
  for (int step = 0; step < 150; ++step) {
    if (step % 25 == 24) program.Fold();
    Apply(RandomBatch(line, input, 60, 100, random), &program, &input);
    program.Propagate();
    ASSERT_NO_FATAL_FAILURE(ExpectAsFromScratch(program, line, input)) << step;
  }
  EXPECT_EQ(program.folds(), 6);
}

TEST(LeaderProgram, ALongScriptLeavesNothingBehind) {
  Random random(NewSeed());
  const Line line{10, 6};
  Traced program(line);
  Input input = RandomInput(line, 150, 1000, random);
  AddAll(input, &program);
  program.Propagate();
  std::size_t bytes = 0, records = 0;
  for (int step = 0; step < 6000; ++step) {
    Apply(RandomBatch(line, input, 150, 1000, random), &program, &input);
    program.Propagate();
    if (step == 2000) {
      bytes = program.engine().bytes();
      records = program.record_limit();
    }
  }
  ExpectAsFromScratch(program, line, input);
  EXPECT_LE(program.engine().bytes(), bytes * 3 / 2);
  EXPECT_LE(program.record_limit(), records * 3 / 2);
}

// --- The work of an edit ------------------------------------------------------------------

struct Work {
  double executed, notified;
  std::uint64_t most;
};
Work WorkPerEdit(int log_side, std::uint64_t seed) {
  Random random(seed);
  const Line line{log_side, 6};
  const std::size_t points = line.side() / 4;
  Traced program(line);
  Input input = RandomInput(line, points, 1'000'000, random);
  AddAll(input, &program);
  program.Propagate();
  const int edits = 600;
  std::uint64_t executed = 0, notified = 0, most = 0;
  for (int i = 0; i < edits; ++i) {
    const Position x = random.Below(line.side());
    const bool there = input.contains(x);
    Apply({{x, !there, random.Below(1'000'000)}}, &program, &input);
    program.engine().ResetCounters();
    program.Propagate();
    executed += program.engine().counters().executed;
    notified += program.engine().counters().notified;
    most = std::max(most, program.engine().counters().executed);
  }
  EXPECT_EQ(program.Rows(), LeadersByDefinition(input, line));
  return {double(executed) / edits, double(notified) / edits, most};
}

TEST(LeaderProgram, TheWorkOfAnEditDoesNotGrowWithTheInput) {
  const std::uint64_t seed = NewSeed();
  const Work small = WorkPerEdit(9, seed);   // 128 points
  const Work large = WorkPerEdit(15, seed);  // 8,192
  std::printf("executed per edit %.1f and %.1f, at most %llu and %llu; looked at %.1f and %.1f\n",
              small.executed, large.executed, static_cast<unsigned long long>(small.most),
              static_cast<unsigned long long>(large.most), small.notified, large.notified);
  EXPECT_LT(large.executed, 1.5 * small.executed + 2);
  EXPECT_LT(large.notified, 1.5 * small.notified + 10);
  EXPECT_GT(large.executed, 1);
}

// Edits of `input` after which followers have other values that still are the lesser ones: their
// leaders need not run again. Returns how many there were.
int ExpectThatEqualOutputsStopThePropagation(const Line& line, Input input) {
  Traced program(line);
  AddAll(input, &program);
  program.Propagate();
  // A follower beside a greater one gets another value, that still is the lesser.
  const std::vector<LeaderRow> rows = program.Rows();
  int tried = 0;
  for (const LeaderRow& r : rows) {
    for (const LeaderRow& other : rows) {
      if (!r.is_link || r.level != 0 || r.leader == r.x) continue;
      if (!other.is_link || other.level != 0 || other.leader != r.leader) continue;
      if (other.x == r.leader || r.value + 1 >= other.value) continue;
      ++tried;
      program.engine().ResetCounters();
      Apply({{r.x, true, r.value + 1}}, &program, &input);
      program.Propagate();
      // It runs again, and its leader need not be notified.
      EXPECT_EQ(program.engine().counters().executed, 1u);
      EXPECT_EQ(program.engine().counters().created, 0u);
      EXPECT_EQ(program.engine().counters().dropped, 0u);
      ExpectAsFromScratch(program, line, input);
    }
  }
  return tried;
}

TEST(LeaderProgram, EqualOutputsStopThePropagation) {
  Random random(NewSeed());
  const Line line{7, 5};
  int tried = 0;
  // One random input in 500 has no such follower.
  for (int inputs = 0; tried == 0 && inputs < 10; ++inputs) {
    tried = ExpectThatEqualOutputsStopThePropagation(
        line, RandomInput(line, line.side() * 7 / 8, 1000, random));
  }
  EXPECT_GT(tried, 0);
}

TEST(LeaderProgram, AnEditThatIsUndoneBeforeThePropagationMakesNoNewOperations) {
  Random random(NewSeed());
  const Line line{8, 6};
  Input input = RandomInput(line, 60, 100, random);
  Traced program(line);
  AddAll(input, &program);
  program.Propagate();
  const std::uint64_t before = SoundTrace(program);
  program.engine().ResetCounters();
  program.Propagate();
  EXPECT_EQ(program.engine().counters().executed, 0u) << "nothing was stale";
  const Position x = input.begin()->first;
  const Weight weight = input.begin()->second;
  program.SetWeight(x, weight + 50);
  program.SetWeight(x, weight);
  program.Propagate();
  EXPECT_EQ(program.engine().counters().executed, program.engine().counters().unchanged);
  EXPECT_EQ(program.engine().counters().created, 0u);
  EXPECT_EQ(SoundTrace(program), before);
}

// --- Audit ----------------------------------------------------------------------------------

class LeaderAudit : public ::testing::Test {
 protected:
  LeaderAudit() {
    for (Position x = 1; x < line_.side(); x += 3) program_.Add(x, x * 7 % 50);
    program_.Propagate();
    sound_ = Audited();
    EXPECT_TRUE(problems_.empty());
  }
  std::uint64_t Audited() {
    problems_.clear();
    return program_.Audit(&problems_);
  }
  bool Complains(const std::string& about) const {
    return std::any_of(problems_.begin(), problems_.end(),
                       [&](const std::string& p) { return p.find(about) != std::string::npos; });
  }
  // Some executed operation that subscribes somewhere.
  OpId AnyOperation() { return program_.OperationsAt(1); }

  const Line line_{7, 5};
  Traced program_{line_};
  std::uint64_t sound_ = 0;
  std::vector<std::string> problems_;
};

TEST_F(LeaderAudit, FindsAMissingSubscription) {
  const Place place = program_.engine().places(AnyOperation())[0];
  program_.engine().subscriptions().Remove(place, AnyOperation());
  Audited();
  EXPECT_TRUE(Complains("subscribers are not those that name it"));
}

TEST_F(LeaderAudit, FindsASubscriptionNobodyNames) {
  const auto named = program_.engine().places(AnyOperation());
  Place place = 1;
  while (std::find(named.begin(), named.end(), place) != named.end()) ++place;
  program_.engine().subscriptions().Add(place, AnyOperation());
  Audited();
  EXPECT_TRUE(Complains("subscribers are not those that name it"));
}

TEST_F(LeaderAudit, FindsAPlaceReplacedWithoutItsSubscription) {
  // The old subscription is the caller's to take, and was not taken.
  const Place place = program_.engine().places(AnyOperation())[0];
  program_.engine().ReplacePlace(AnyOperation(), place, 1);
  Audited();
  EXPECT_TRUE(Complains("subscribers are not those that name it"));
}

TEST_F(LeaderAudit, FindsAnOperationThatItsItemHasLost) {
  program_.OperationsAt(1) = kNoOp;
  Audited();
  EXPECT_TRUE(Complains("is not found by its identity"));
}

TEST_F(LeaderAudit, FindsAnItemThatMovedWithItsOperationsInPlace) {
  // Priorities are remembered, but ties are broken by position: make all equal.
  const Line line{4, 2, 1};
  Traced program(line);
  for (Position x = 0; x < 8; ++x) program.Add(x, 1);
  program.Propagate();
  std::vector<std::string> problems;
  program.Audit(&problems);
  EXPECT_TRUE(problems.empty());
  for (Position x = 0; x < 8; ++x) program.PositionAt(x) = 15 - x;
  program.Audit(&problems);
  EXPECT_FALSE(problems.empty());
}

TEST_F(LeaderAudit, FindsWorkThatIsStillQueued) {
  program_.SetWeight(1, 99);
  Audited();
  EXPECT_TRUE(Complains("the queue is not empty"));
  EXPECT_TRUE(Complains("is still queued"));
}

TEST_F(LeaderAudit, FindsAnOperationThatWasNeverExecuted) {
  program_.Add(0, 1);
  Audited();
  EXPECT_TRUE(Complains("an operation is in no epoch's table"));
}

TEST_F(LeaderAudit, FindsAnOperationNobodyRequestsAnyMore) {
  program_.engine().Unrequest(kJoin, program_.engine().item(AnyOperation()), 0);
  Audited();
  EXPECT_TRUE(Complains("lives without a request"));
}

TEST_F(LeaderAudit, FindsTooFewReferences) {
  // What an operation has requested is released in the environment's name.
  for (OpId op = AnyOperation(); op != kNoOp; op = program_.engine().next_of_item(op)) {
    if (program_.engine().epoch(op) == 0) continue;
    const auto& engine = program_.engine();
    program_.engine().Unrequest(engine.kind(op), engine.item(op), engine.epoch(op));
    Audited();
    EXPECT_TRUE(Complains("fewer references than requesters"));
    return;
  }
  FAIL() << "the first point has no operation but its first";
}

TEST_F(LeaderAudit, TheHashTellsAReferenceTooMany) {
  const Item item = program_.engine().item(AnyOperation());
  program_.engine().Request(kJoin, item, 0);
  EXPECT_NE(Audited(), sound_);
  EXPECT_TRUE(problems_.empty()) << "the environment may request what it likes";
  program_.engine().Unrequest(kJoin, item, 0);
  EXPECT_EQ(Audited(), sound_);
}

TEST_F(LeaderAudit, TheHashTellsAnOutputThatIsNotWhatWasMade) {
  const std::uint32_t link = program_.AnyPresentLink();
  ++program_.ValueOf(link);
  EXPECT_NE(Audited(), sound_);
  --program_.ValueOf(link);
  EXPECT_EQ(Audited(), sound_);
}

}  // namespace
}  // namespace dynmesh::sac::testing
