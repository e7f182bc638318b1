// EpochOrder against a std::set sorted by (epoch, priority, tie-break).
#include "core/sac/epoch_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "tests/core/sac/random_script.h"

namespace dynmesh::sac::epoch_order_test {
namespace {

using testing::NewSeed;
using testing::Random;

struct Operation {
  std::uint64_t priority = 0;
  std::uint32_t name = 0;
  Epoch epoch = 0;
  Stamp stamp = kNoStamp;
  OpId next_in_epoch = kNoOp;
};
using Operations = std::vector<Operation>;

struct Before {
  const Operations* ops;
  bool operator()(OpId a, OpId b) const {
    const Operation &x = (*ops)[a], &y = (*ops)[b];
    return x.priority != y.priority ? x.priority < y.priority : x.name < y.name;
  }
};

class Mirrored {
 public:
  OpId Insert(Epoch epoch, std::uint64_t priority) {
    const OpId id = static_cast<OpId>(ops_.size());
    ops_.push_back({priority, id, epoch});
    time_.Insert(epoch, id);
    told_.emplace(epoch, priority, id);
    return id;
  }
  void Remove(OpId id) {
    time_.Remove(ops_[id].epoch, id);
    told_.erase({ops_[id].epoch, ops_[id].priority, id});
  }
  void EraseStamp(OpId id) {
    time_.EraseStamp(ops_[id].stamp);
    ops_[id].stamp = kNoStamp;
  }
  OpId Any(Random& random) const {
    auto it = told_.lower_bound({0, random.Word(), random.Below(ops_.size())});
    // Epochs are few: begin anywhere among them.
    for (std::uint32_t skip = random.Below(20); skip > 0 && it != told_.end(); --skip) ++it;
    if (it == told_.end()) it = told_.begin();
    return std::get<2>(*it);
  }
  std::size_t size() const { return told_.size(); }
  std::size_t table_bytes() const { return time_.bytes() - time_.order().bytes(); }
  const OrderList& order() const { return time_.order(); }
  Stamp stamp(OpId id) const { return ops_[id].stamp; }

  void ExpectSame() const {
    std::string why;
    ASSERT_TRUE(time_.order().Check(&why)) << why;
    auto it = told_.begin();
    Stamp last = time_.order().first();
    time_.ForEach([&](Epoch epoch, OpId id) {
      ASSERT_NE(it, told_.end());
      ASSERT_EQ(std::tuple(epoch, ops_[id].priority, id), *it);
      ASSERT_TRUE(time_.order().Precedes(last, ops_[id].stamp));
      last = ops_[id].stamp;
      ++it;
    });
    ASSERT_EQ(it, told_.end());
    ASSERT_TRUE(time_.order().Precedes(last, time_.order().last()));
  }

 private:
  Operations ops_;
  EpochOrder<Operations, Before> time_{ops_, Before{&ops_}};
  std::set<std::tuple<Epoch, std::uint64_t, OpId>> told_;
};

TEST(EpochOrder, StampsStandInTheOrderOfTime) {
  Mirrored m;
  const OpId late = m.Insert(7, 1);
  const OpId early = m.Insert(3, ~std::uint64_t{0});
  const OpId between = m.Insert(5, 12);
  const OpId first = m.Insert(3, 0);
  EXPECT_TRUE(m.order().Precedes(m.stamp(first), m.stamp(early)));
  EXPECT_TRUE(m.order().Precedes(m.stamp(early), m.stamp(between)));
  EXPECT_TRUE(m.order().Precedes(m.stamp(between), m.stamp(late)));
  m.ExpectSame();
}

TEST(EpochOrder, OrderEqualsSortedOrderUnderRandomScripts) {
  const std::uint64_t seed = NewSeed();
  for (int script = 0; script < 12; ++script) {
    Random random(seed + script);
    const std::uint64_t epochs = script % 3 == 0 ? 1 : script % 3 == 1 ? 5 : 300;
    const bool ties = script % 4 == 3;  // few distinct priorities
    const bool clustered = script % 4 == 1;
    Mirrored m;
    std::vector<OpId> removed;  // their stamps are still in the order
    for (int step = 0; step < 8000; ++step) {
      const bool shrinking = step % 4000 > 2800;
      if (m.size() > 0 && random.Below(10) < (shrinking ? 9 : 3)) {
        const OpId id = m.Any(random);
        m.Remove(id);
        removed.push_back(id);
      } else {
        const std::uint64_t any = random.Word();
        m.Insert(random.Below(epochs) * 1000, ties        ? std::uint64_t{random.Below(6)} << 61
                                              : clustered ? any >> (any % 2 == 0 ? 8 : 60)
                                                          : any);
      }
      if (random.OneIn(50)) {
        for (const OpId id : removed) m.EraseStamp(id);
        removed.clear();
      }
      if (step % 400 == 0) m.ExpectSame();
      if (::testing::Test::HasFatalFailure()) FAIL() << "script " << script << " step " << step;
    }
    m.ExpectSame();
  }
}

// As when an item goes and an equal one comes in one batch of edits.
TEST(EpochOrder, EqualOperationsMayStandSideBySide) {
  struct Equal {
    const Operations* ops;
    bool operator()(OpId a, OpId b) const { return (*ops)[a].priority < (*ops)[b].priority; }
  };
  Operations ops(30);
  EpochOrder<Operations, Equal> time(ops, Equal{&ops});
  for (OpId id = 0; id < 30; ++id) {
    ops[id].priority = std::uint64_t{id % 3} << 62;
    time.Insert(1, id);
  }
  for (OpId id = 0; id < 30; id += 2) time.Remove(1, id);
  std::set<OpId> left;
  std::uint64_t last = 0;
  time.ForEach([&](Epoch, OpId id) {
    EXPECT_LE(last, ops[id].priority);
    last = ops[id].priority;
    left.insert(id);
  });
  EXPECT_EQ(left.size(), 15u);
  for (const OpId id : left) EXPECT_EQ(id % 2, 1u);
}

// Otherwise a new stamp in an emptied epoch would have to walk past the slots of all removed ones.
TEST(EpochOrder, AnEpochThatEmptiesGivesItsTableBack) {
  Random random(NewSeed());
  Mirrored m;
  std::vector<OpId> ids;
  for (int i = 0; i < 50'000; ++i) ids.push_back(m.Insert(4, random.Word()));
  EXPECT_GE(m.table_bytes(), 50'000 * sizeof(OpId));
  while (ids.size() > 10) {
    m.Remove(ids.back());
    m.EraseStamp(ids.back());
    ids.pop_back();
  }
  EXPECT_LT(m.table_bytes(), 1000u);
  for (int i = 0; i < 1000; ++i) m.Insert(4, random.Word());
  m.ExpectSame();
}

// The effect on priorities of a client that knows the hash of positions.
struct Attack {
  const char* name;
  std::function<std::uint64_t(std::uint64_t i, std::uint64_t n, std::uint64_t any)> priority;
};
const Attack kAttacks[] = {
    {"all leading bits agree", [](auto, auto, auto any) { return any >> 32; }},
    {"all are equal", [](auto, auto, auto) { return std::uint64_t{7} << 40; }},
    {"ascending in one slot", [](auto i, auto, auto) { return i; }},
    {"descending in one slot", [](auto i, auto n, auto) { return n - i; }},
    {"two clusters, the farther one descending",
     [](auto i, auto n, auto any) { return i < n / 2 ? any >> 20 : ~std::uint64_t{0} - i; }},
    {"a bit less in common each", [](auto i, auto, auto any) { return any >> (i % 60); }},
};

struct Counting {
  const Operations* ops;
  std::uint64_t* compared;
  bool operator()(OpId a, OpId b) const {
    ++*compared;
    return Before{ops}(a, b);
  }
};

// Comparisons, and operations and slots visited, of n that are removed and added in any order.
double StepsOf(const Attack& attack, std::uint64_t n, Random& random) {
  std::uint64_t compared = 0;
  Operations ops(n);
  EpochOrder<Operations, Counting> time(ops, Counting{&ops, &compared});
  std::vector<OpId> ids;
  for (OpId id = 0; id < n; ++id) {
    ops[id] = {attack.priority(id, n, random.Word()), id, 1};
    time.Insert(1, id);
    ids.push_back(id);
    std::swap(ids.back(), ids[random.Below(ids.size())]);
  }
  for (const OpId id : ids) {
    time.Remove(1, id);
    time.EraseStamp(ops[id].stamp);
  }
  return static_cast<double>(compared + time.steps());
}

TEST(EpochOrder, NoChoiceOfPrioritiesCostsMoreThanASearchEach) {
  Random random(NewSeed());
  for (const Attack& attack : kAttacks) {
    for (const std::uint64_t n : {5'000, 10'000, 20'000}) {
      const double each = StepsOf(attack, n, random) / static_cast<double>(n);
      // Coming and going; a tree with its assertions compares three times as often.
      EXPECT_LT(each, 10 * std::log2(n)) << attack.name << ", " << n;
    }
  }
}

// With random priorities the position is looked up, not searched.
TEST(EpochOrder, UniformPrioritiesTakeAFewStepsEach) {
  Random random(NewSeed());
  const Attack none = {"uniform", [](auto, auto, auto any) { return any; }};
  for (const std::uint64_t n : {5'000, 20'000, 200'000}) {
    EXPECT_LT(StepsOf(none, n, random) / static_cast<double>(n), 10) << n;
  }
}

// In a run from scratch, or a propagation that fills a nearly empty epoch: until the last stamps
// are inserted, most slots are empty and chains in the others are long.
TEST(EpochOrder, WhatComesInTheOrderOfTimeTakesAFewStepsEach) {
  Random random(NewSeed());
  for (const int before : {0, 20}) {
    for (const std::size_t n : {5'000, 200'000}) {
      std::uint64_t compared = 0;
      Operations ops(n);
      EpochOrder<Operations, Counting> time(ops, Counting{&ops, &compared});
      std::vector<OpId> ids;
      for (OpId id = 0; id < n; ++id) {
        ops[id] = {random.Word(), id, 1};
        ids.push_back(id);
      }
      std::sort(ids.begin() + before, ids.end(), Before{&ops});
      for (const OpId id : ids) time.Insert(1, id);
      EXPECT_LT(static_cast<double>(compared + time.steps()) / static_cast<double>(n), 6)
          << n << " after " << before;
      for (std::size_t i = 1; i < n; ++i) {
        if (i > static_cast<std::size_t>(before)) {
          ASSERT_TRUE(time.order().Precedes(ops[ids[i - 1]].stamp, ops[ids[i]].stamp));
        }
      }
    }
  }
}

TEST(EpochOrder, AnEpochThatWasCrowdedIsATableAgainWhenItWasEmpty) {
  Random random(NewSeed());
  Mirrored m;
  for (int round = 0; round < 2; ++round) {
    const std::size_t bytes = m.table_bytes();
    std::vector<OpId> ids;
    for (int i = 0; i < 1000; ++i) ids.push_back(m.Insert(4, random.Word() >> 32));
    m.ExpectSame();
    for (const OpId id : ids) {
      m.Remove(id);
      m.EraseStamp(id);
    }
    EXPECT_LT(m.table_bytes(), bytes + 200);
    for (int i = 0; i < 1000; ++i) m.Insert(8 + round, random.Word());
    m.ExpectSame();
  }
}

}  // namespace
}  // namespace dynmesh::sac::epoch_order_test
