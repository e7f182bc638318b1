// WorkQueue against a std::multiset of everything that waits.
#include "core/sac/work_queue.h"

#include <gtest/gtest.h>

#include <set>
#include <tuple>
#include <vector>

#include "tests/core/sac/random_script.h"

namespace dynmesh::sac::work_queue_test {
namespace {

using testing::NewSeed;
using testing::Random;

struct Entry {
  std::uint64_t priority;
  std::uint32_t name;
};
struct ByName {
  bool operator()(const Entry& a, const Entry& b) const { return a.name < b.name; }
};
using Queue = WorkQueue<Entry, ByName>;
using Told = std::multiset<std::tuple<Epoch, std::uint64_t, std::uint32_t>>;

void ExpectPop(Queue& queue, Told& told) {
  ASSERT_EQ(queue.size(), told.size());
  const auto [epoch, entry] = queue.Pop();
  ASSERT_EQ(std::tuple(epoch, entry.priority, entry.name), *told.begin());
  told.erase(told.begin());
  ASSERT_EQ(queue.empty(), told.empty());
}
void Push(Queue& queue, Told& told, Epoch epoch, Entry entry) {
  queue.Push(epoch, entry);
  told.emplace(epoch, entry.priority, entry.name);
}

TEST(WorkQueue, TiesOfThePriorityAreBrokenByLess) {
  Queue queue{ByName()};
  for (const std::uint32_t name : {3, 1, 4, 0, 2}) queue.Push(5, {7, name});
  EXPECT_EQ(queue.Pop().second.name, 0u);
  queue.Push(5, {7, 1});  // late, and equal to one that waits
  for (const std::uint32_t name : {1, 1, 2, 3, 4}) EXPECT_EQ(queue.Pop().second.name, name);
  EXPECT_TRUE(queue.empty());
}

TEST(WorkQueue, TakesWhatArrivesForTheOpenEpoch) {
  Queue queue{ByName()};
  Told told;
  for (std::uint32_t i = 0; i < 10; ++i) Push(queue, told, 1, {10 * i, i});
  for (std::uint32_t i = 0; i < 5; ++i) ExpectPop(queue, told);
  for (std::uint32_t i = 0; i < 10; ++i) Push(queue, told, 1, {47 + 9 * i, i});
  while (!told.empty()) ExpectPop(queue, told);
  Push(queue, told, 1, {3, 3});  // the epoch is still open, but empty
  Push(queue, told, 2, {1, 1});
  while (!told.empty()) ExpectPop(queue, told);
}

TEST(WorkQueue, AnEarlierEpochInterruptsTheOpenOne) {
  Queue queue{ByName()};
  Told told;
  for (std::uint32_t i = 0; i < 10; ++i) Push(queue, told, 9, {i, i});
  ExpectPop(queue, told);
  Push(queue, told, 9, {100, 1});
  Push(queue, told, 3, {5, 5});
  while (!told.empty()) ExpectPop(queue, told);
}

TEST(WorkQueue, RewindLosesNothing) {
  Queue queue{ByName()};
  queue.Rewind();
  Told told;
  for (std::uint32_t i = 0; i < 10; ++i) Push(queue, told, 9, {i % 3, i});
  queue.Rewind();
  ExpectPop(queue, told);
  Push(queue, told, 9, {1, 50});
  queue.Rewind();
  queue.Rewind();
  Push(queue, told, 9, {0, 60});
  while (!told.empty()) ExpectPop(queue, told);
  queue.Rewind();
  EXPECT_TRUE(queue.empty());
}

// The usual pattern of an algorithm: requests are at or after what was popped; now and then time
// goes back. Epochs collide in caches that use a remainder.
TEST(WorkQueue, AgreesWithASetUnderRandomScripts) {
  const std::uint64_t seed = NewSeed();
  for (int script = 0; script < 30; ++script) {
    Random random(seed + script);
    const bool anywhere = script % 3 == 0;  // pushes to any epoch at any time
    const std::uint64_t priorities = script % 2 == 0 ? 4 : 1'000'000;
    const Epoch stride = script % 5 == 0 ? 61 : script % 5 == 1 ? Epoch{1} << 56 : 1;
    Queue queue{ByName()};
    Told told;
    Epoch now = 0;
    for (int step = 0; step < 20'000; ++step) {
      const bool draining = step % 4000 > 3000;
      if (!told.empty() && random.Below(10) < (draining ? 8 : 4)) {
        now = std::get<0>(*told.begin());
        ExpectPop(queue, told);
      } else {
        const Epoch from = anywhere ? 0 : now;
        const Epoch epoch =
            random.OneIn(2) ? from : from + stride * random.Below(anywhere ? 200 : 5);
        Push(queue, told, epoch, {random.Below(priorities), random.Below(100)});
      }
      if (random.OneIn(1000)) {
        queue.Rewind();
        now = 0;
      }
      if (now > (Epoch{1} << 62)) now = 0;
      if (::testing::Test::HasFatalFailure()) FAIL() << "script " << script << " step " << step;
    }
    while (!told.empty()) ExpectPop(queue, told);
  }
}

}  // namespace
}  // namespace dynmesh::sac::work_queue_test
