// What the order-maintenance list costs, and what it saves: Precedes beside comparing the
// structural keys (epoch, priority, coordinates) that it stands for, and appending,
// inserting and erasing, per element.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "core/sac/epoch_order.h"
#include "core/sac/order_list.h"

namespace dynmesh::sac {
namespace {

constexpr int kFew = 100'000, kMany = 1'000'000;

// Where an operation stands in time, spelled out.
template <int kDimension>
struct Key {
  std::uint64_t epoch;
  std::uint64_t priority;
  double coordinates[kDimension];

  friend bool operator<(const Key& a, const Key& b) {
    if (a.epoch != b.epoch) return a.epoch < b.epoch;
    if (a.priority != b.priority) return a.priority < b.priority;
    for (int i = 0; i < kDimension; ++i) {
      if (a.coordinates[i] != b.coordinates[i]) return a.coordinates[i] < b.coordinates[i];
    }
    return false;
  }
};
// Keys are stored among an operation's other data.
template <int kDimension>
struct Operation {
  Key<kDimension> key;
  std::uint32_t others[12];
};

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// Pairs of random elements: ids have no locality, because of the hash order.
Pairs RandomPairs(std::size_t elements) {
  std::mt19937_64 random(1);
  Pairs pairs(1 << 16);
  for (auto& [a, b] : pairs) {
    a = static_cast<std::uint32_t>(random() % elements);
    b = static_cast<std::uint32_t>(random() % elements);
  }
  return pairs;
}

// A list of `n` elements with stamps out of order, as after many edits.
OrderList ShuffledList(std::size_t n) {
  OrderList list;
  std::mt19937_64 random(2);
  for (std::size_t i = 2; i < n; ++i) {
    const Stamp s = static_cast<Stamp>(random() % i);
    list.InsertAfter(s == list.last() ? list.first() : s);
  }
  return list;
}

void BM_PrecedesByStamp(benchmark::State& state) {
  const OrderList list = ShuffledList(state.range(0));
  const Pairs pairs = RandomPairs(state.range(0));
  for (auto _ : state) {
    int count = 0;
    for (const auto& [a, b] : pairs) count += list.Precedes(a, b);
    benchmark::DoNotOptimize(count);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(pairs.size()));
}
BENCHMARK(BM_PrecedesByStamp)->Arg(kFew)->Arg(kMany);

// Epochs as in a mesher: most elements in a few epochs, and a tail of small ones.
template <class Record, class KeyOf>
void FillKeys(std::vector<Record>& records, KeyOf key_of) {
  std::mt19937_64 random(3);
  std::geometric_distribution<std::uint64_t> epoch(0.2);
  for (Record& r : records) {
    auto& key = key_of(r);
    key.epoch = epoch(random);
    key.priority = random();
    for (double& x : key.coordinates) x = static_cast<double>(random() % 1'000'003);
  }
}

template <int kDimension>
void BM_PrecedesByKey(benchmark::State& state) {
  std::vector<Key<kDimension>> keys(state.range(0));
  FillKeys(
      keys, [](auto& key) -> auto& { return key; });
  const Pairs pairs = RandomPairs(state.range(0));
  for (auto _ : state) {
    int count = 0;
    for (const auto& [a, b] : pairs) count += keys[a] < keys[b];
    benchmark::DoNotOptimize(count);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(pairs.size()));
}
BENCHMARK(BM_PrecedesByKey<2>)->Arg(kFew)->Arg(kMany);
BENCHMARK(BM_PrecedesByKey<3>)->Arg(kFew)->Arg(kMany);

template <int kDimension>
void BM_PrecedesByKeyInOperation(benchmark::State& state) {
  std::vector<Operation<kDimension>> ops(state.range(0));
  FillKeys(
      ops, [](auto& op) -> auto& { return op.key; });
  const Pairs pairs = RandomPairs(state.range(0));
  for (auto _ : state) {
    int count = 0;
    for (const auto& [a, b] : pairs) count += ops[a].key < ops[b].key;
    benchmark::DoNotOptimize(count);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(pairs.size()));
}
BENCHMARK(BM_PrecedesByKeyInOperation<2>)->Arg(kFew)->Arg(kMany);
BENCHMARK(BM_PrecedesByKeyInOperation<3>)->Arg(kFew)->Arg(kMany);

// --- Change ---------------------------------------------------------------------------------

void BM_Append(benchmark::State& state) {
  for (auto _ : state) {
    OrderList list;
    for (std::int64_t i = 0; i < state.range(0); ++i) list.InsertBefore(list.last());
    benchmark::DoNotOptimize(list.size());
    state.counters["bytes"] =
        static_cast<double>(list.bytes()) / static_cast<double>(state.range(0));
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_Append)->Arg(kFew)->Arg(kMany)->Unit(benchmark::kMillisecond);

void BM_InsertAtRandom(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(ShuffledList(state.range(0)).size());
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_InsertAtRandom)->Arg(kFew)->Arg(kMany)->Unit(benchmark::kMillisecond);

// The worst case: each at the same position, in a list made by appending.
void BM_InsertAtOneSpot(benchmark::State& state) {
  for (auto _ : state) {
    state.PauseTiming();
    OrderList list;
    Stamp spot = list.first();
    for (std::int64_t i = 0; i < state.range(0); ++i) {
      const Stamp s = list.InsertBefore(list.last());
      if (i == state.range(0) / 2) spot = s;
    }
    state.ResumeTiming();
    for (std::int64_t i = 0; i < state.range(0); ++i) list.InsertAfter(spot);
    state.counters["relabelled"] =
        static_cast<double>(list.relabelled_groups()) / static_cast<double>(state.range(0));
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_InsertAtOneSpot)->Arg(kFew)->Arg(kMany)->Unit(benchmark::kMillisecond);

// The usual work of edits: a few elements are erased, a few inserted, anywhere.
void BM_EraseAndInsert(benchmark::State& state) {
  OrderList list = ShuffledList(state.range(0));
  const Pairs pairs = RandomPairs(state.range(0));
  std::size_t at = 0;
  for (auto _ : state) {
    const Stamp gone = pairs[at].first, beside = pairs[at].second;
    at = (at + 1) % pairs.size();
    if (gone < 2 || gone == beside || beside == list.last()) continue;
    list.Erase(gone);
    benchmark::DoNotOptimize(list.InsertAfter(beside));  // the stamp just erased, again
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_EraseAndInsert)->Arg(kFew)->Arg(kMany);

// --- Finding the place: operations come by epoch and random priority ------------------------

struct Timed {
  std::uint64_t priority = 0;
  Stamp stamp = kNoStamp;
  OpId next_in_epoch = kNoOp;
};
struct ByPriority {
  const std::vector<Timed>* ops;
  bool operator()(OpId a, OpId b) const { return (*ops)[a].priority < (*ops)[b].priority; }
};

// In the order of time, as in a run from scratch, or in any order, as edits make them.
void BM_EpochOrderInsert(benchmark::State& state) {
  const std::size_t n = state.range(0);
  const bool in_order = state.range(1) != 0;
  std::mt19937_64 random(4);
  for (auto _ : state) {
    state.PauseTiming();
    std::vector<Timed> ops(n);
    for (Timed& op : ops) op.priority = random();
    if (in_order) {
      std::sort(ops.begin(), ops.end(),
                [](const Timed& a, const Timed& b) { return a.priority < b.priority; });
    }
    EpochOrder<std::vector<Timed>, ByPriority> time(ops, ByPriority{&ops});
    state.ResumeTiming();
    for (OpId id = 0; id < n; ++id) time.Insert(1, id);
    benchmark::DoNotOptimize(time.order().size());
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_EpochOrderInsert)
    ->ArgsProduct({{kFew, kMany}, {1, 0}})
    ->ArgNames({"n", "in_order"})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dynmesh::sac

BENCHMARK_MAIN();
