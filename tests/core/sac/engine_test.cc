// The guarantees of the engine, one by one: order, reference counts, an operation's stored state,
// cut-off.
#include "core/sac/engine.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/core/sac/engine_fixture.h"

namespace dynmesh::sac::testing {
namespace {

// --- Order ----------------------------------------------------------------------------

TEST_F(EngineTest, NothingRequestedNothingDone) { EXPECT_EQ(Run(), ""); }

TEST_F(EngineTest, OperationsRunInTheOrderOfTime) {
  Request(5, 2);
  Request(3, 2);
  Request(9, 1);
  Request(4, 3);
  EXPECT_EQ(Run(), "run 9@1, run 3@2, run 5@2, run 4@3");
}

TEST_F(EngineTest, TiesOfPriorityAreBrokenByTheProgram) {
  p_.one_priority = true;
  for (const Item i : {4, 2, 5, 1, 3}) Request(i, 7);
  EXPECT_EQ(Run(), "run 1@7, run 2@7, run 3@7, run 4@7, run 5@7");
}

TEST_F(EngineTest, ARequestForTheSameEpochComesInItsTurn) {
  p_[1] = [](Context& c) { c.Request(kOnly, 3, c.epoch); };
  p_[3] = [](Context& c) { c.Request(kOnly, 5, c.epoch); };
  for (const Item i : {1, 2, 4, 6}) Request(i);
  EXPECT_EQ(Run(), "run 1@0, run 2@0, run 3@0, run 4@0, run 5@0, run 6@0");
}

TEST_F(EngineTest, WhatIsRequestedLaterStandsWhereItBelongs) {
  for (const Item i : {1, 3, 5}) Request(i, 4);
  Run();
  for (const Item i : {0, 2, 4, 6}) Request(i, 4);
  Request(9, 3);
  EXPECT_EQ(Run(), "run 9@3, run 0@4, run 2@4, run 4@4, run 6@4");
  std::vector<Stamp> stamps = {e_.stamp(p_.OperationOf(9))};
  for (Item i = 0; i <= 6; ++i) stamps.push_back(e_.stamp(p_.OperationOf(i)));
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    EXPECT_TRUE(e_.Precedes(stamps[i - 1], stamps[i]));
    EXPECT_TRUE(e_.Precedes(e_.beginning(), stamps[i]));
  }
}

TEST_F(EngineTest, AnItemMayHaveOperationsInManyEpochs) {
  for (const Epoch epoch : {8, 1, 5}) Request(2, epoch);
  EXPECT_EQ(Run(), "run 2@1, run 2@5, run 2@8");
  EXPECT_EQ(e_.operation_count(), 3u);
  Unrequest(2, 5);
  EXPECT_EQ(Run(), "");
  EXPECT_EQ(e_.operation_count(), 2u);
}

TEST_F(EngineTest, KindsOfOneItemInOneEpochAreOperationsOfTheirOwn) {
  std::vector<int> kinds;
  p_[2] = [&](Context& c) { kinds.push_back(c.kind); };
  for (const Kind kind : {3, 1, 2}) e_.Request(kind, 2, 5);
  Run();
  EXPECT_EQ(kinds, (std::vector<int>{1, 2, 3})) << "Before breaks the tie";
  EXPECT_EQ(e_.operation_count(), 3u);
  e_.Unrequest(2, 2, 5);
  Run();
  EXPECT_EQ(e_.operation_count(), 2u);
  for (OpId op = p_.OperationOf(2); op != kNoOp; op = e_.next_of_item(op)) {
    EXPECT_NE(e_.kind(op), 2);
  }
}

TEST_F(EngineTest, AnOperationSeesWhatIsEarlierThanItself) {
  Stamp birth = kNoStamp;
  bool sees = false;
  p_.on_publish = [&](Output, Stamp at) { birth = at; };
  p_[2] = Emits({7});
  Request(2);
  Run();
  for (const Item i : {1, 2, 3}) {
    p_[i] = [&](Context& c) { sees = c.Sees(birth) && c.Sees(e_.beginning()); };
    if (i == 2) {
      Touch(2);
    } else {
      Request(i);
    }
    Run();
    EXPECT_EQ(sees, i == 3) << i;
  }
}

#ifndef NDEBUG
TEST(EngineDeathTest, ARequestForAnEarlierEpochDies) {
  Program p;
  p[1] = [](Context& c) { c.Request(kOnly, 2, c.epoch - 1); };
  p.engine().Request(kOnly, 1, 5);
  EXPECT_DEATH(p.engine().Propagate(), "IsLater");
}
TEST(EngineDeathTest, ARequestForALesserPriorityInTheSameEpochDies) {
  Program p;
  p[2] = [](Context& c) { c.Request(kOnly, 1, c.epoch); };
  p.engine().Request(kOnly, 2, 5);
  EXPECT_DEATH(p.engine().Propagate(), "IsLater");
}
TEST(EngineDeathTest, ARequestForOneselfDies) {
  Program p;
  p[2] = [](Context& c) { c.Request(kOnly, 2, c.epoch); };
  p.engine().Request(kOnly, 2, 5);
  EXPECT_DEATH(p.engine().Propagate(), "IsLater");
}
TEST(EngineDeathTest, UnrequestingWhatWasNeverRequestedDies) {
  Program p;
  EXPECT_DEATH(p.engine().Unrequest(kOnly, 1, 0), "refs");
}
#endif

// --- Reference counts ---------------------------------------------------------------------

TEST_F(EngineTest, AnOperationLivesWhileSomeoneRequestsIt) {
  p_[1] = p_[2] = Requests({9}, 1);
  p_[9] = Emits({90});
  Request(1);
  Request(2);
  Request(9, 1);
  EXPECT_EQ(Run(), "run 1@0, run 2@0, run 9@1, +90");
  Unrequest(1);
  EXPECT_EQ(Run(), "");
  Unrequest(9, 1);
  EXPECT_EQ(Run(), "");
  Unrequest(2);
  EXPECT_EQ(Run(), "-90, free 90");
  EXPECT_EQ(e_.operation_count(), 0u);
  EXPECT_EQ(e_.counters().dropped, 3u);
}

TEST_F(EngineTest, TwoRequestsOfOneOperationCountTwice) {
  p_[1] = Requests({9, 9}, 1);
  Request(1);
  Run();
  p_[1] = Requests({9}, 1);
  Touch(1);
  EXPECT_EQ(Run(), "run 1@0");
  EXPECT_EQ(e_.operation_count(), 2u);
  p_[1] = {};
  Touch(1);
  Run();
  EXPECT_EQ(e_.operation_count(), 1u);
}

TEST_F(EngineTest, WhatIsRequestedAgainIsNotMadeAgain) {
  p_[1] = Requests({8}, 1);
  p_[8] = Requests({9}, 2);
  p_[9] = Emits({90});
  Request(1);
  Run();
  e_.ResetCounters();
  p_[1] = Requests({7, 8}, 1);
  Touch(1);
  EXPECT_EQ(Run(), "run 1@0, run 7@1");
  EXPECT_EQ(e_.counters().created, 1u);
  EXPECT_EQ(e_.counters().dropped, 0u);
}

// In either direction: the operation that releases may come before the one that acquires.
TEST_F(EngineTest, ASharedSubTraceIsHandedOver) {
  p_[8] = Requests({9}, 2);
  p_[9] = Emits({90});
  p_[1] = Requests({8}, 1);
  Request(1);
  Request(2);
  Run();
  for (const Item from : {1, 2, 1}) {
    const Item to = 3 - from;
    p_[from] = {};
    p_[to] = Requests({8}, 1);
    Touch(1);
    Touch(2);
    EXPECT_EQ(Run(), "run 1@0, run 2@0");
  }
  EXPECT_EQ(e_.counters().dropped, 0u);
}

TEST_F(EngineTest, UnrequestAndRequestInOneBatchIsNothing) {
  p_[1] = Emits({10});
  Request(1);
  Run();
  Unrequest(1);
  Request(1);
  EXPECT_EQ(Run(), "");
  EXPECT_EQ(e_.counters().dropped, 0u);
}

TEST_F(EngineTest, WhatWasNeverRunIsDroppedWithoutBeingRun) {
  Request(1);
  Unrequest(1);
  EXPECT_EQ(Run(), "");
  EXPECT_EQ(e_.operation_count(), 0u);
  Request(1);
  EXPECT_EQ(Run(), "run 1@0");
}

TEST_F(EngineTest, ALongChainIsDroppedWithoutRecursion) {
  const Item length = 50'000;
  for (Item i = 0; i + 1 < length; ++i) p_[i] = Requests({i + 1}, i + 1);
  Request(0);
  Run();
  EXPECT_EQ(e_.operation_count(), length);
  Unrequest(0);
  Run();
  EXPECT_EQ(e_.operation_count(), 0u);
}

// A point that encroaches on many segments requests every one of them.
TEST_F(EngineTest, AnOperationMayRequestAndReadVeryMany) {
  const Item many = 70'000;
  p_[0] = [&](Context& c) {
    for (Item i = 1; i <= many; ++i) c.Request(kOnly, i, 1);
    for (std::uint32_t i = 0; i < 3 * many; ++i) c.Read(i);
  };
  Request(0);
  Run();
  EXPECT_EQ(e_.operation_count(), many + 1u);
  EXPECT_EQ(e_.reads(p_.OperationOf(0)).size(), 3 * many);
  EXPECT_EQ(e_.reads(p_.OperationOf(0)).back(), 3 * many - 1);
  p_[0] = Requests({1}, 1);
  Touch(0);
  Run();
  EXPECT_EQ(e_.operation_count(), 2u);
}

// --- Stored state, and cut-off ----------------------------------------------------------------

TEST_F(EngineTest, ARerunFindsWhatTheLastRunLeft) {
  int runs = 0;
  p_[1] = [&](Context& c) {
    const std::vector<Output> outputs(c.old_outputs().begin(), c.old_outputs().end());
    const std::vector<std::uint32_t> reads(c.old_reads().begin(), c.old_reads().end());
    if (runs++ == 0) {
      EXPECT_TRUE(c.first_time());
      EXPECT_TRUE(outputs.empty() && reads.empty());
      EXPECT_EQ(c.payload(), 0);
    } else {
      EXPECT_FALSE(c.first_time());
      EXPECT_EQ(outputs, (std::vector<Output>{11, 12}));
      EXPECT_EQ(reads, (std::vector<std::uint32_t>{21, 22, 21}));
      EXPECT_EQ(c.payload(), 5);
    }
    c.payload() = 5;
    for (const Output o : {11, 12}) c.Emit(o);
    for (const std::uint32_t r : {21, 22, 21}) c.Read(r);
    for (const Place place : {4, 3, 4}) c.Subscribe(place);
  };
  Request(1);
  Run();
  Touch(1);
  EXPECT_EQ(Run(), "run 1@0");
  EXPECT_EQ(runs, 2);
  const OpId op = p_.OperationOf(1);
  EXPECT_EQ(std::vector<Place>(e_.places(op).begin(), e_.places(op).end()),
            (std::vector<Place>{3, 4}));
  EXPECT_EQ(e_.subscriptions().at(4).size(), 1u);
  // Dropped and requested again it has no stored state.
  Unrequest(1);
  Run();
  runs = 0;
  Request(1);
  Run();
}

TEST_F(EngineTest, OnlyWhatChangedIsPublishedAndWithdrawn) {
  p_[1] = Emits({1, 2, 3});
  Request(1);
  EXPECT_EQ(Run(), "run 1@0, +1, +2, +3");
  p_[1] = Emits({4, 3, 2, 5});
  Touch(1);
  EXPECT_EQ(Run(), "run 1@0, +4, +5, -1, free 1");
}

TEST_F(EngineTest, CountersTellWhatWasDone) {
  p_[1] = Requests({2}, 1);
  p_[2] = Emits({20});
  Request(1);
  Request(3);
  Run();
  EXPECT_EQ(e_.counters().executed, 3u);
  EXPECT_EQ(e_.counters().created, 3u);
  EXPECT_EQ(e_.counters().unchanged, 0u) << "nothing was run again";
  e_.ResetCounters();
  for (const Item i : {1, 2, 3}) Touch(i);
  Run();
  EXPECT_EQ(e_.counters().executed, 3u);
  EXPECT_EQ(e_.counters().created, 0u);
  EXPECT_EQ(e_.counters().unchanged, 3u);
  p_[2] = Emits({21});
  Touch(2);
  Run();
  EXPECT_EQ(e_.counters().executed, 4u);
  EXPECT_EQ(e_.counters().unchanged, 3u);
}

}  // namespace
}  // namespace dynmesh::sac::testing
