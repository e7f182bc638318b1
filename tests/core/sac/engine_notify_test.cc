// The guarantees of the engine, one by one: windows of notification, moved subscriptions, deferred
// release, interruption.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/sac/engine.h"
#include "tests/core/sac/engine_fixture.h"

namespace dynmesh::sac::testing {
namespace {

// --- Notification -------------------------------------------------------------------------

class EngineNotifyTest : public EngineTest {
 protected:
  // Operations 0 to 9 subscribe to place 1.
  EngineNotifyTest() {
    for (Item i = 0; i < 10; ++i) {
      p_[i] = [](Context& c) { c.Subscribe(1); };
      Request(i);
    }
    Run();
  }
  Stamp At(Item i) { return e_.stamp(p_.OperationOf(i)); }
  static bool All(OpId) { return true; }
};

TEST_F(EngineNotifyTest, ReachesThoseAfterAndUpToTheEnd) {
  e_.Notify(1, At(3), At(6), All);
  EXPECT_EQ(Run(), "run 4@0, run 5@0, run 6@0");
  e_.Notify(1, At(7), kNoStamp, All);
  EXPECT_EQ(Run(), "run 8@0, run 9@0");
  e_.Notify(1, e_.beginning(), At(1), All);
  EXPECT_EQ(Run(), "run 0@0, run 1@0");
  e_.Notify(1, At(9), kNoStamp, All);
  e_.Notify(2, e_.beginning(), kNoStamp, All);
  EXPECT_EQ(Run(), "");
}

TEST_F(EngineNotifyTest, TheFilterIsAskedOnceAboutThoseInTime) {
  std::vector<Item> asked;
  const auto odd = [&](OpId op) {
    asked.push_back(e_.item(op));
    return e_.item(op) % 2 == 1;
  };
  e_.Notify(1, At(3), At(7), odd);
  e_.Notify(1, At(3), At(7), odd);  // not those that are stale already
  std::sort(asked.begin(), asked.end());
  EXPECT_EQ(asked, (std::vector<Item>{4, 4, 5, 6, 6, 7}));
  EXPECT_EQ(Run(), "run 5@0, run 7@0");
}

// The operations that were attentive at their last execution.
TEST_F(EngineNotifyTest, OnlyTheAttentiveAreAsked) {
  for (const Item i : {2, 4, 5, 7, 8})
    p_[i] = [](Context& c) {
      c.Subscribe(1);
      c.payload() = 1;
    };
  for (const Item i : {2, 4, 5, 7, 8}) Touch(i);
  Run();
  std::vector<Item> asked;
  const auto all = [&](OpId op) {
    asked.push_back(e_.item(op));
    return true;
  };
  const auto before = e_.counters().notified;
  e_.NotifyAttentive(1, At(3), At(7), all);
  EXPECT_EQ(e_.counters().notified, before + 5);
  std::sort(asked.begin(), asked.end());
  EXPECT_EQ(asked, (std::vector<Item>{4, 5, 7}));
  p_[5] = [](Context& c) {
    c.Subscribe(1);
    c.payload() = 0;
  };
  EXPECT_EQ(Run(), "run 4@0, run 5@0, run 7@0");
  EXPECT_TRUE(Problems(p_).empty());
  Unrequest(4);
  Run();
  e_.NotifyAttentive(1, e_.beginning(), kNoStamp, all);
  EXPECT_EQ(Run(), "run 2@0, run 7@0, run 8@0");
  EXPECT_TRUE(Problems(p_).empty());
}

TEST_F(EngineNotifyTest, OneOperationIsToldIfItIsInTime) {
  for (const Item i : {2, 3, 6, 7}) {
    e_.NotifyOperation(p_.OperationOf(i), At(2), At(6), All);
  }
  e_.NotifyOperation(p_.OperationOf(4), At(2), At(6), [](OpId) { return false; });
  EXPECT_EQ(Run(), "run 3@0, run 6@0");
}

// A subscriber to some parts of a place is notified iff (subscribed & parts) == parts.
TEST_F(EngineNotifyTest, ReachesThoseWhoSubscribeToAllPartsOfTheChange) {
  p_[3] = [](Context& c) { c.Subscribe(1, 0b0011); };
  p_[4] = [](Context& c) { c.Subscribe(1, 0b0110); };
  // At once or one by one.
  p_[5] = [](Context& c) {
    for (const Parts parts : {0b0001, 0b1000, 0b0001}) c.Subscribe(1, parts);
  };
  for (const Item i : {3, 4, 5}) Touch(i);
  Run();
  const auto reached = [&](Parts parts) {
    e_.Notify(1, parts, At(2), At(6), All);
    return Run();
  };
  EXPECT_EQ(reached(0b0010), "run 3@0, run 4@0, run 6@0");
  EXPECT_EQ(reached(0b0110), "run 4@0, run 6@0");
  EXPECT_EQ(reached(0b1001), "run 5@0, run 6@0");
  EXPECT_EQ(reached(0b10000), "run 6@0");
  EXPECT_EQ(reached(0), "run 3@0, run 4@0, run 5@0, run 6@0");
  // Other parts of the same place.
  p_[3] = [](Context& c) { c.Subscribe(1, 0b0100); };
  Touch(3);
  Run();
  EXPECT_EQ(reached(0b0001), "run 5@0, run 6@0");
  EXPECT_EQ(reached(0b0100), "run 3@0, run 4@0, run 6@0");
}

TEST_F(EngineNotifyTest, SeveralNotificationsMakeOneRun) {
  e_.Notify(1, At(4), At(5), All);
  e_.Notify(1, At(3), At(5), All);
  Touch(5);
  EXPECT_EQ(Run(), "run 4@0, run 5@0");
}

TEST_F(EngineNotifyTest, WhoUnsubscribedIsNotReached) {
  p_[4] = [](Context& c) { c.Subscribe(2); };
  Touch(4);
  Run();
  e_.Notify(1, At(3), At(5), All);
  EXPECT_EQ(Run(), "run 5@0");
  e_.Notify(2, e_.beginning(), kNoStamp, All);
  EXPECT_EQ(Run(), "run 4@0");
  Unrequest(4);
  Run();
  e_.Notify(2, e_.beginning(), kNoStamp, All);
  EXPECT_EQ(Run(), "");
}

TEST_F(EngineNotifyTest, AChangeAtOnesOwnTimeReachesTheLaterOnly) {
  p_[4] = [](Context& c) {
    c.Subscribe(1);
    c.Emit(40);
  };
  p_.on_publish = p_.on_withdraw = [&](Output, Stamp at) { e_.Notify(1, at, kNoStamp, All); };
  Touch(4);
  EXPECT_EQ(Run(), "run 4@0, +40, run 5@0, run 6@0, run 7@0, run 8@0, run 9@0");
  Touch(4);
  EXPECT_EQ(Run(), "run 4@0") << "equal outputs stop the propagation";
  Unrequest(4);
  EXPECT_EQ(Run(), "-40, run 5@0, run 6@0, run 7@0, run 8@0, run 9@0, free 40");
}

TEST_F(EngineNotifyTest, AChainIsNotifiedFromATimeOn) {
  for (const Epoch epoch : {1, 2, 3}) Request(4, epoch);
  Run();
  Stamp second = kNoStamp;
  for (OpId op = p_.OperationOf(4); op != kNoOp; op = e_.next_of_item(op)) {
    if (e_.epoch(op) == 1) second = e_.stamp(op);
  }
  e_.NotifyChain(p_.OperationOf(4), second);
  EXPECT_EQ(Run(), "run 4@2, run 4@3");
}

TEST_F(EngineNotifyTest, NothingCanBeStaleAfterTheLastOperation) {
  EXPECT_TRUE(e_.AnyAfter(e_.beginning()));
  EXPECT_TRUE(e_.AnyAfter(At(8)));
  EXPECT_FALSE(e_.AnyAfter(At(9)));
  Request(3, 5);
  Run();
  EXPECT_TRUE(e_.AnyAfter(At(9)));
  // After any removals, no remaining subscriber is forgotten.
  Unrequest(3, 5);
  Run();
  for (Item i = 0; i < 9; ++i) EXPECT_TRUE(e_.AnyAfter(At(i)));
}

TEST(EngineAnyAfter, NothingCanBeStaleBeforeTheFirstRun) {
  Program p;
  EXPECT_FALSE(p.engine().AnyAfter(p.engine().beginning()));
}

TEST_F(EngineNotifyTest, PlacesThatBecomeOneKeepTheirSubscribers) {
  p_[4] = [](Context& c) {
    for (const Place place : {1, 2, 5}) c.Subscribe(place);
    for (const std::uint32_t r : {77, 78, 79}) c.Read(r);
  };
  Touch(4);
  Run();
  for (const Place from : {1, 2}) {
    for (const OpId op : e_.subscriptions().Take(from)) e_.ReplacePlace(op, from, 9);
  }
  const OpId four = p_.OperationOf(4);
  EXPECT_EQ(std::vector<Place>(e_.places(four).begin(), e_.places(four).end()),
            (std::vector<Place>{5, 9}));
  EXPECT_EQ(std::vector<Place>(e_.reads(four).begin(), e_.reads(four).end()),
            (std::vector<Place>{77, 78, 79}));
  EXPECT_TRUE(Problems(p_).empty());
  e_.Notify(9, At(2), At(5), All);
  EXPECT_EQ(Run(), "run 3@0, run 4@0, run 5@0");  // and they subscribe to 1 again
  e_.Notify(9, e_.beginning(), kNoStamp, All);
  EXPECT_EQ(Run(), "run 0@0, run 1@0, run 2@0, run 6@0, run 7@0, run 8@0, run 9@0");
}

// --- Deferred release and interruption --------------------------------------------------------

TEST_F(EngineTest, NothingIsReleasedBeforeTheEndOfAPropagation) {
  p_[1] = Emits({10});
  p_[2] = Emits({20});
  Request(1);
  Request(2);
  Request(3);
  Run();
  p_[1] = Emits({11});
  for (const Item i : {1, 3}) Touch(i);
  Unrequest(2);
  EXPECT_EQ(RunUntil(2), "run 1@0, +11, -10, -20");
  EXPECT_EQ(RunUntil(0), "");
  EXPECT_EQ(Run(), "run 3@0, free 10, free 20");
}

TEST_F(EngineTest, StampsAndOperationsAreReusedOnlyAfterTheEnd) {
  for (const Item i : {1, 2}) Request(i);
  Run();
  const OpId one = p_.OperationOf(1);
  const Stamp stamp = e_.stamp(one);
  Unrequest(1);
  Touch(2);
  RunUntil(1);  // dropped
  Request(3);
  EXPECT_NE(p_.OperationOf(3), one);
  EXPECT_EQ(Run(), "run 2@0, run 3@0");
  EXPECT_NE(e_.stamp(p_.OperationOf(3)), stamp);
  Request(4);
  Run();
  EXPECT_EQ(p_.OperationOf(4), one);
}

// The inverse of an edit after a drop: the operation is made again beside its former version.
TEST_F(EngineTest, WhatWasDroppedMayComeBackBeforeTheEnd) {
  p_[1] = [](Context& c) {
    c.Emit(10);
    c.Subscribe(4);
  };
  Request(1);
  Request(2);
  Run();
  Unrequest(1);
  Touch(2);
  EXPECT_EQ(RunUntil(1), "-10");
  Request(1);
  // The word is published again before it is released: the program must not take the release for
  // the end of the word.
  // release of a word that it has published again for its end.
  EXPECT_EQ(Run(), "run 1@0, +10, run 2@0, free 10");
  EXPECT_EQ(e_.operation_count(), 2u);
  EXPECT_EQ(e_.subscriptions().at(4).size(), 1u);
}

TEST_F(EngineTest, InterruptionIsAskedBeforeEachOperation) {
  for (Item i = 0; i < 5; ++i) Request(i);
  int asked = 0;
  EXPECT_TRUE(e_.Propagate([&] {
    ++asked;
    return false;
  }));
  EXPECT_EQ(asked, 5);
  EXPECT_TRUE(e_.Propagate([] { return true; })) << "nothing to be interrupted";
}

TEST_F(EngineTest, MemoryIsReusedFromEditToEdit) {
  std::size_t bytes = 0;
  for (int round = 0; round < 200; ++round) {
    for (Item i = 0; i < 300; ++i) {
      p_[i] = [=](Context& c) {
        for (Item k = 0; k < (i + round) % 40; ++k) c.Read(k);
        c.Subscribe(i % 7);
        c.Request(kOnly, 1000 + i % 20, 1);
      };
      Request(i);
    }
    Run();
    for (Item i = 0; i < 300; ++i) Unrequest(i);
    Run();
    ASSERT_EQ(e_.operation_count(), 0u);
    if (round == 50) bytes = e_.bytes();
  }
  EXPECT_EQ(e_.bytes(), bytes);
}

}  // namespace
}  // namespace dynmesh::sac::testing
