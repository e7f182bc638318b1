// OrderList against a std::list as its model, and its cost under insertion patterns that crowd the
// label space.
#include "core/sac/order_list.h"

#include <gtest/gtest.h>

#include <list>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/sac/random_script.h"

namespace dynmesh::sac::order_list_test {
namespace {

using testing::NewSeed;
using testing::Random;

// An OrderList beside the same list, spelled out.
class Mirrored {
 public:
  Mirrored() {
    Note(list_.first(), told_.insert(told_.end(), list_.first()));
    Note(list_.last(), told_.insert(told_.end(), list_.last()));
  }

  Stamp InsertAfter(Stamp s) {
    const Stamp n = list_.InsertAfter(s);
    Note(n, told_.insert(std::next(where_[s]), n));
    return n;
  }
  Stamp InsertBefore(Stamp s) {
    const Stamp n = list_.InsertBefore(s);
    Note(n, told_.insert(where_[s], n));
    return n;
  }
  void Erase(Stamp s) {
    list_.Erase(s);
    told_.erase(where_[s]);
    inner_[slot_[s]] = inner_.back();
    slot_[inner_.back()] = slot_[s];
    inner_.pop_back();
  }

  const OrderList& list() const { return list_; }
  std::size_t inner_count() const { return inner_.size(); }
  // Any but first() and last().
  Stamp AnyInner(Random& random) const { return inner_[random.Below(inner_.size())]; }
  Stamp Any(Random& random) const {
    const std::uint32_t i = random.Below(inner_.size() + 2);
    return i < 2 ? i : inner_[i - 2];
  }

  // The list has the told order: by Precedes, by Next and by Prev; and is sound.
  void ExpectSame() const {
    std::string why;
    ASSERT_TRUE(list_.Check(&why)) << why;
    ASSERT_EQ(list_.size(), told_.size());
    Stamp before = kNoStamp;
    for (const Stamp s : told_) {
      ASSERT_EQ(list_.Prev(s), before);
      if (before != kNoStamp) {
        ASSERT_EQ(list_.Next(before), s);
        ASSERT_TRUE(list_.Precedes(before, s));
        ASSERT_FALSE(list_.Precedes(s, before));
      }
      ASSERT_FALSE(list_.Precedes(s, s));
      before = s;
    }
    ASSERT_EQ(before, list_.last());
    ASSERT_EQ(list_.Next(before), kNoStamp);
  }

  // Any two compare as their places in the told order do.
  void ExpectSamePairs(Random& random, int pairs) const {
    std::vector<std::uint32_t> place(where_.size());
    std::uint32_t i = 0;
    for (const Stamp s : told_) place[s] = i++;
    while (pairs-- > 0) {
      const Stamp a = Any(random), b = Any(random);
      ASSERT_EQ(list_.Precedes(a, b), place[a] < place[b]) << a << " and " << b;
    }
  }

 private:
  void Note(Stamp s, std::list<Stamp>::iterator at) {
    if (s >= where_.size()) {
      where_.resize(s + 1);
      slot_.resize(s + 1);
    }
    where_[s] = at;
    if (s == list_.first() || s == list_.last()) return;
    slot_[s] = inner_.size();
    inner_.push_back(s);
  }

  OrderList list_;
  std::list<Stamp> told_;
  std::vector<std::list<Stamp>::iterator> where_;  // by stamp
  std::vector<Stamp> inner_;
  std::vector<std::size_t> slot_;  // by stamp: where it stands in inner_
};

TEST(OrderList, BeginsWithFirstBeforeLast) {
  const OrderList list;
  EXPECT_EQ(list.size(), 2u);
  EXPECT_TRUE(list.Precedes(list.first(), list.last()));
  EXPECT_FALSE(list.Precedes(list.last(), list.first()));
  EXPECT_EQ(list.Next(list.first()), list.last());
  EXPECT_EQ(list.Prev(list.last()), list.first());
  EXPECT_EQ(list.Prev(list.first()), kNoStamp);
  EXPECT_EQ(list.Next(list.last()), kNoStamp);
}

TEST(OrderList, AgreesWithAListAfterEveryStepOfASmallScript) {
  const std::uint64_t seed = NewSeed();
  for (int script = 0; script < 40; ++script) {
    Random random(seed + script);
    // Few elements, or some groups full of them, that are split, emptied and reused.
    const std::size_t limit = script % 2 == 0 ? 12 : 300;
    Mirrored m;
    for (int step = 0; step < 400; ++step) {
      const bool full = m.inner_count() >= limit;
      if (m.inner_count() > 0 && (full || random.OneIn(3))) {
        m.Erase(m.AnyInner(random));
      } else if (random.OneIn(2)) {
        m.InsertAfter(random.OneIn(4) ? m.list().first() : m.list().Prev(m.list().last()));
      } else {
        m.InsertBefore(m.inner_count() > 0 ? m.AnyInner(random) : m.list().last());
      }
      m.ExpectSame();
      if (::testing::Test::HasFatalFailure()) FAIL() << "script " << script << " step " << step;
    }
  }
}

TEST(OrderList, AgreesWithAListUnderRandomScripts) {
  Random random(NewSeed());
  Mirrored m;
  for (int step = 0; step < 200'000; ++step) {
    // Grows, shrinks to little, grows again.
    const bool shrinking = step % 50'000 > 35'000;
    if (m.inner_count() > 0 && random.Below(10) < (shrinking ? 9 : 3)) {
      m.Erase(m.AnyInner(random));
    } else {
      Stamp s = m.Any(random);
      if (s == m.list().last() || (s != m.list().first() && random.OneIn(2))) {
        m.InsertBefore(s);
      } else {
        m.InsertAfter(s);
      }
    }
    if (step % 10'000 == 0) {
      m.ExpectSame();
      m.ExpectSamePairs(random, 1000);
    }
  }
  m.ExpectSame();
}

// The next insertion position of a hostile client.
enum class Spot { kAfterHead, kBeforeLast, kSameSpot, kZigZag, kNewest, kBursts };

Stamp InsertAtSpot(Mirrored& m, Spot spot, int step, Stamp* memory, Random& random) {
  switch (spot) {
    case Spot::kAfterHead:
      return m.InsertAfter(m.list().first());
    case Spot::kBeforeLast:
      return m.InsertBefore(m.list().last());
    case Spot::kSameSpot:  // between two that were there early
      if (step == 0) *memory = m.InsertAfter(m.list().first());
      return m.InsertAfter(*memory);
    case Spot::kZigZag: {  // ever closer to one limit from both sides
      const Stamp s =
          step % 2 == 0 ? m.InsertAfter(*memory) : m.InsertBefore(m.list().Next(*memory));
      if (step % 2 == 0) *memory = s;
      return s;
    }
    case Spot::kNewest:
      return *memory = m.InsertAfter(*memory);
    case Spot::kBursts:
      if (step % 1000 == 0) *memory = m.inner_count() > 0 ? m.AnyInner(random) : m.list().first();
      return m.InsertAfter(*memory);
  }
  return kNoStamp;
}

TEST(OrderList, PrecedesSurvivesRelabel) {
  Random random(NewSeed());
  for (const Spot spot : {Spot::kAfterHead, Spot::kBeforeLast, Spot::kSameSpot, Spot::kZigZag,
                          Spot::kNewest, Spot::kBursts}) {
    SCOPED_TRACE(static_cast<int>(spot));
    Mirrored m;
    Stamp memory = m.list().first();
    std::uint64_t relabelled = 0;
    int relabels_seen = 0;
    for (int step = 0; step < 30'000; ++step) {
      const Stamp s = InsertAtSpot(m, spot, step, &memory, random);
      ASSERT_TRUE(m.list().Precedes(m.list().Prev(s), s));
      ASSERT_TRUE(m.list().Precedes(s, m.list().Next(s)));
      if (m.list().relabelled_groups() != relabelled) {  // labels have just moved
        relabelled = m.list().relabelled_groups();
        if (++relabels_seen % 4 == 0) m.ExpectSamePairs(random, 20);
      }
      if (step % 5000 == 0) m.ExpectSame();
    }
    m.ExpectSame();
    m.ExpectSamePairs(random, 10'000);
    if (spot == Spot::kAfterHead || spot == Spot::kSameSpot || spot == Spot::kZigZag) {
      EXPECT_GT(relabels_seen, 0) << "the pattern does not crowd the labels: a weak test";
    }
  }
}

TEST(OrderList, AppendingNeverRelabels) {
  OrderList list;
  for (int i = 0; i < 1'000'000; ++i) list.InsertBefore(list.last());
  EXPECT_EQ(list.relabelled_groups(), 0u);
  std::string why;
  EXPECT_TRUE(list.Check(&why)) << why;
  EXPECT_LT(list.bytes(), 50u * list.size());  // 17 B a stamp, but vectors have spare room
}

TEST(OrderList, RelabelsLittlePerInsertionAtOneSpot) {
  for (const int before : {0, 10'000, 500'000}) {
    OrderList list;
    for (int i = 0; i < before; ++i) list.InsertBefore(list.last());
    Stamp spot = list.first();
    for (int i = 0; i < 100 && i < before; ++i) spot = list.Next(spot);
    const int inserted = 300'000;
    for (int i = 0; i < inserted; ++i) list.InsertAfter(spot);
    EXPECT_LT(list.relabelled_groups(), static_cast<std::uint64_t>(inserted)) << before;
    std::string why;
    EXPECT_TRUE(list.Check(&why)) << why;
  }
}

// Beyond the size at which every range of labels around a spot is too full by the
// measure that serves small lists.
TEST(OrderList, MillionsFitAtOneSpot) {
  OrderList list;
  const int inserted = 3'600'000;
  for (int i = 0; i < inserted; ++i) list.InsertAfter(list.first());
  std::string why;
  ASSERT_TRUE(list.Check(&why)) << why;
  // The last inserted stands first.
  for (Stamp s = 2; s < inserted + 1; ++s) ASSERT_TRUE(list.Precedes(s + 1, s));
  EXPECT_LT(list.relabelled_groups(), static_cast<std::uint64_t>(2 * inserted));
}

// An epoch that is new in the middle of a long run: all its stamps go to one spot.
TEST(OrderList, ALongAppendedListTakesABurstInTheMiddle) {
  OrderList list;
  Stamp middle = list.first();
  const int appended = 5'000'000;
  for (int i = 0; i < appended; ++i) {
    const Stamp s = list.InsertBefore(list.last());
    if (i == appended / 2) middle = s;
  }
  Stamp newest = middle;
  const Stamp after = list.Next(middle);
  for (int i = 0; i < 60'000; ++i) {
    newest = list.InsertAfter(newest);
    ASSERT_TRUE(list.Precedes(newest, after)) << i;
  }
  std::string why;
  EXPECT_TRUE(list.Check(&why)) << why;
}

TEST(OrderList, ErasedStampsAreReusedAndNothingIsLost) {
  Random random(NewSeed());
  Mirrored m;
  for (int i = 0; i < 5000; ++i) m.InsertBefore(m.list().last());
  const std::size_t bytes = m.list().bytes();
  for (int round = 0; round < 20; ++round) {
    while (m.inner_count() > 40) m.Erase(m.AnyInner(random));
    m.ExpectSame();
    while (m.inner_count() < 5000) m.InsertBefore(m.list().last());
    m.ExpectSame();
  }
  EXPECT_LE(m.list().bytes(), 2 * bytes);
}

TEST(OrderList, CanBeEmptiedAndUsedAgain) {
  Mirrored m;
  std::vector<Stamp> stamps;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 1000; ++i) stamps.push_back(m.InsertAfter(m.list().first()));
    for (const Stamp s : stamps) m.Erase(s);
    stamps.clear();
    m.ExpectSame();
    EXPECT_EQ(m.list().size(), 2u);
  }
}

}  // namespace
}  // namespace dynmesh::sac::order_list_test
