#include "client/python/module/shared_mesh.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <new>
#include <set>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "client/python/module/held_column.h"
#include "core/base/mutex.h"

namespace dynmesh::python {
namespace {

constexpr int kThreads = 8;
#ifdef DYNMESH_FEW_EDITS  // under a sanitizer the same takes many times as long
constexpr int kEdits = 200;
#else
constexpr int kEdits = 1000;
#endif

std::unique_ptr<SharedMesh> MakeMesh(int dimension = 2) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  auto mesh = SharedMesh::Create(options);
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return *std::move(mesh);
}

// The edit `i` of thread `t`: its own point goes around in its own part of the square.
EditBatch EditOf(int t, int i) {
  const auto id = static_cast<FeatureId>(t + 1);
  const double x = 0.1 + 0.1 * t + 0.0001 * (i % 37), y = 0.1 + 0.8 * (i % 11) / 11;
  if (i == 0) return {dynmesh::Edit::Add(Feature::Point(id, x, y))};
  return {dynmesh::Edit::Move(id, x, y)};
}

template <class T>
std::vector<T> ValuesOf(const HeldColumn<T>& column) {
  return {column.data(), column.data() + column.size()};
}
template <class T>
std::vector<T> ValuesOf(const SlotColumn<T>& column) {
  return {column.data(), column.data() + column.size()};
}

// All columns of one revision, as held and as the replica has them.
template <class F>
void ForEachColumn(SharedMesh& mesh, F f) {
  const SlotMesh& replica = mesh.replica();
  f(mesh.points(), replica.points()), f(mesh.ids(), replica.ids());
  f(mesh.owners(), replica.owners());
  f(mesh.containing_dimensions(), replica.containing_dimensions());
  f(mesh.cells(), replica.cells()), f(mesh.neighbours(), replica.neighbours());
  f(mesh.regions(), replica.regions()), f(mesh.subsegments(), replica.subsegments());
  f(mesh.subsegment_owners(), replica.subsegment_owners());
  f(mesh.subfacets(), replica.subfacets()), f(mesh.subfacet_owners(), replica.subfacet_owners());
}

void ExpectColumnsAreTheReplicas(SharedMesh& mesh) {
  const MutexLock lock(mesh.mutex());
  int column = 0;
  ForEachColumn(mesh, [&](const auto& held, const auto& now) {
    EXPECT_EQ(ValuesOf(held), ValuesOf(now)) << "column " << column;
    ++column;
  });
}

TEST(SharedMesh, EditsOfManyThreadsMakeTheMeshOfTheSameEditsInSeries) {
  const auto shared = MakeMesh();
  std::atomic<bool> is_over = false;
  std::atomic<int> reads = 0;
  std::vector<std::thread> readers;
  // Readers of each kind. What they read is of one revision.
  readers.emplace_back([&] {
    while (!is_over) {
      HeldColumn<double> points;
      HeldColumn<VertexId> ids;
      HeldColumn<Slot> cells;
      {
        const MutexLock lock(shared->mutex());
        points = shared->points(), ids = shared->ids(), cells = shared->cells();
      }
      ASSERT_EQ(points.size(), 2 * ids.size());
      for (std::size_t i = 0; i < ids.size(); ++i) {
        if (ids.data()[i] == 0) continue;
        ASSERT_EQ(ids.data()[i], VertexIdAt(points.data() + 2 * i, 2));
      }
      for (std::size_t i = 0; i < cells.size(); ++i) {
        if (cells.data()[i] == kNoSlot) continue;
        ASSERT_NE(ids.data()[static_cast<std::size_t>(cells.data()[i])], 0u);
      }
      ++reads;
    }
  });
  readers.emplace_back([&] {
    std::uint64_t last = 0;
    while (!is_over) {
      const MeshNumbers numbers = shared->numbers();
      ASSERT_GE(numbers.revision, last);
      last = numbers.revision;
      const CompactColumns compact = shared->TakeCompact();
      ASSERT_EQ(compact.points.size(), 2 * compact.numbering.vertex_slots.size());
      ASSERT_FALSE(shared->TakePatch().patch.to_revision < last);
      ++reads;
    }
  });
  readers.emplace_back([&] {
    while (!is_over) {
      const auto slots = shared->Locate(std::vector<double>{0.31, 0.47, 100, 100});
      ASSERT_TRUE(slots.ok()) << slots.status();
      ASSERT_TRUE((*slots)[0] >= 0 && (*slots)[1] == kNoSlot);
      const auto features = shared->Features();
      ASSERT_TRUE(features.ok() && features->size() <= kThreads);
      ASSERT_TRUE(shared->Validate(EditOf(kThreads, 0)).ok());
      ++reads;
    }
  });
  std::vector<std::thread> writers;
  std::mutex mutex;
  std::map<std::uint64_t, std::tuple<int, int>> edit_of;  // by the revision that it made
  for (int t = 0; t < kThreads; ++t) {
    writers.emplace_back([&, t] {
      for (int i = 0; i < kEdits; ++i) {
        const auto diff = shared->Edit(EditOf(t, i), {});
        ASSERT_TRUE(diff.ok()) << diff.status();
        const std::lock_guard lock(mutex);
        ASSERT_TRUE(edit_of.emplace(diff->to_revision, std::tuple(t, i)).second);
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  // Each reader came to its turn at least once.
  while (reads < 3) std::this_thread::yield();
  is_over = true;
  for (std::thread& reader : readers) reader.join();

  const MeshNumbers numbers = shared->numbers();
  EXPECT_EQ(numbers.revision, static_cast<std::uint64_t>(kThreads * kEdits));
  ASSERT_EQ(edit_of.size(), numbers.revision);
  const auto series = MakeMesh();
  for (const auto& [revision, edit] : edit_of) {
    const auto diff = series->Edit(EditOf(std::get<0>(edit), std::get<1>(edit)), {});
    ASSERT_TRUE(diff.ok()) << diff.status();
  }
  EXPECT_EQ(series->numbers().hash, numbers.hash);
  ExpectColumnsAreTheReplicas(*shared);
  const auto report = shared->Audit();
  ASSERT_TRUE(report.ok());
  EXPECT_TRUE(report->problems.empty());
}

class HeldColumns : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Dimensions, HeldColumns, testing::Values(2, 3));

// Polygons, segments and points come, move and go.
EditBatch RandomBatch(std::uint64_t& state, int dimension, std::set<FeatureId>& live) {
  const auto draw = [&](std::uint64_t n) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (state >> 33) % n;
  };
  const auto place = [&] { return 0.05 + 0.9 * static_cast<double>(draw(1000)) / 1000; };
  const FeatureId id = 1 + draw(12);
  const double z = dimension == 3 ? place() : 0;
  if (!live.contains(id)) {
    live.insert(id);
    return {dynmesh::Edit::Add(Feature::Point(id, place(), place(), z))};
  }
  if (draw(3) == 0) {
    live.erase(id);
    return {dynmesh::Edit::Remove(id)};
  }
  return {dynmesh::Edit::Move(id, place(), place(), z)};
}

TEST_P(HeldColumns, StayAsTheyWereAndNewOnesAreUpToDate) {
  const auto mesh = MakeMesh(GetParam());
  const double z = GetParam() == 3 ? 0.5 : 0;
  // A polygon whose edges the points below run into: owners, regions and subsegments change, too.
  EditBatch first;
  const double corners[4][2] = {{0.201, 0.203}, {0.803, 0.207}, {0.797, 0.801}, {0.209, 0.799}};
  for (int k = 0; k < 4; ++k) {
    first.push_back(dynmesh::Edit::Add(
        Feature::Point(static_cast<FeatureId>(100 + k), corners[k][0], corners[k][1], z)));
  }
  ASSERT_TRUE(mesh->Edit(first, {}).ok());
  std::uint64_t state = 11;
  std::set<FeatureId> live;
  std::vector<std::vector<std::vector<std::uint8_t>>> seen;  // bytes of columns, when taken
  std::vector<std::vector<std::function<std::vector<std::uint8_t>()>>> held;
  const int steps = GetParam() == 2 ? 300 : 60;
  for (int step = 0; step < steps; ++step) {
    (void)mesh->Edit(RandomBatch(state, GetParam(), live), {});  // some are refused
    if (step % 20 == 7) {
      (void)mesh->Edit({dynmesh::Edit::Add(Feature::Polygon(200, {{100, 101, 102, 103}}))}, {});
    }
    if (step % 20 == 13) (void)mesh->Edit({dynmesh::Edit::Remove(200)}, {});
    // Some are taken every time, some now and then, some are kept for long.
    if (step % 3 == 0) ExpectColumnsAreTheReplicas(*mesh);
    if (step % 7 != 0) continue;
    seen.emplace_back(), held.emplace_back();
    const MutexLock lock(mesh->mutex());
    ForEachColumn(*mesh, [&](auto column, const auto&) {
      const auto shared = std::make_shared<decltype(column)>(std::move(column));
      const auto bytes = [shared] {
        const auto* const begin = reinterpret_cast<const std::uint8_t*>(shared->data());
        return std::vector<std::uint8_t>(begin, begin + shared->size() * sizeof(*shared->data()));
      };
      seen.back().push_back(bytes());
      held.back().push_back(bytes);
    });
    if (held.size() > 5) seen.erase(seen.begin()), held.erase(held.begin());
    for (std::size_t i = 0; i < held.size(); ++i) {
      for (std::size_t k = 0; k < held[i].size(); ++k) {
        ASSERT_EQ(held[i][k](), seen[i][k]) << "column " << k << " changed while it was held";
      }
    }
  }
  EXPECT_GT(mesh->numbers().revision, 20u);
}

TEST(HeldColumns, OfAReplicaFollowExtendedPatches) {
  const auto mesh = MakeMesh();
  auto whole = SharedMesh::FromSnapshot(mesh->replica().ToMesh());
  ASSERT_TRUE(whole.ok()) << whole.status();
  SharedMesh& replica = **whole;
  std::uint64_t state = 5;
  std::set<FeatureId> live;
  bool extends = false;
  for (int step = 0; step < 300; ++step) {
    const auto diff = mesh->Edit(RandomBatch(state, 2, live), {});
    if (!diff.ok()) continue;
    ASSERT_TRUE(replica.Apply(*diff, extends).ok());
    extends = step % 4 != 0;
    if (step % 2 == 0) ExpectColumnsAreTheReplicas(replica);
  }
  EXPECT_EQ(replica.numbers().hash, mesh->numbers().hash);
  EXPECT_EQ(replica.Edit({}, {}).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(SharedMesh, ACallFromTheProgressOfAnEditReadsTheMeshBeforeItAndIsRefusedTheMesher) {
  const auto mesh = MakeMesh();
  int calls = 0;
  ApplyOptions options;
  options.progress = [&](const ApplyProgress&) {
    ++calls;
    EXPECT_EQ(mesh->numbers().revision, 0u);
    EXPECT_EQ(mesh->TakePatch().patch.to_revision, 0u);
    const absl::Status edit = mesh->Edit(EditOf(1, 0), {}).status();
    EXPECT_EQ(edit.code(), absl::StatusCode::kFailedPrecondition) << edit;
    EXPECT_EQ(mesh->Locate(std::vector<double>{0.5, 0.5}).status(), edit);
    EXPECT_EQ(mesh->Features().status(), edit);
    EXPECT_EQ(mesh->Validate({}), edit);
    EXPECT_EQ(mesh->Audit().status(), edit);
  };
  ASSERT_TRUE(mesh->Edit(EditOf(0, 0), options).ok());
  EXPECT_GT(calls, 0);
  EXPECT_EQ(mesh->numbers().revision, 1u);
  EXPECT_TRUE(mesh->Edit(EditOf(1, 0), {}).ok());
}

TEST(SharedMesh, AnEditThatFailsChangesNeitherMesherNorReplica) {
  const auto mesh = MakeMesh();
  ASSERT_TRUE(mesh->Edit(EditOf(0, 0), {}).ok());
  const MeshNumbers before = mesh->numbers();
  EXPECT_FALSE(mesh->Edit({dynmesh::Edit::Remove(77)}, {}).ok());
  ApplyOptions cancelled;
  cancelled.interrupted = [] { return true; };
  EXPECT_FALSE(mesh->Edit(EditOf(0, 1), cancelled).ok());
  EXPECT_EQ(mesh->numbers().revision, before.revision);
  EXPECT_EQ(mesh->numbers().hash, before.hash);
  ASSERT_TRUE(mesh->Edit(EditOf(0, 1), {}).ok());
  ExpectColumnsAreTheReplicas(*mesh);
}

// An allocation that fails leaves the mesher between two revisions.
TEST(SharedMesh, AfterMemoryRanOutItCanBeReadAndTakesNoEdits) {
  for (const int dimension : {2, 3}) {
    const auto mesh = MakeMesh(dimension);
    ASSERT_TRUE(mesh->Edit({dynmesh::Edit::Add(Feature::Point(1, 0.3, 0.4, 0.5))}, {}).ok());
    const MeshNumbers before = mesh->numbers();
    ApplyOptions options;
    options.interrupted = [calls = 0]() mutable -> bool {
      if (++calls > 3) throw std::bad_alloc();
      return false;
    };
    EditBatch batch;
    for (int i = 0; i < 200; ++i) {
      batch.push_back(
          dynmesh::Edit::Add(Feature::Point(10 + i, 0.1 + 0.004 * i, 0.2, 0.1 + 0.001 * i)));
    }
    EXPECT_TRUE(absl::IsResourceExhausted(mesh->Edit(batch, options).status()));
    EXPECT_EQ(mesh->numbers().revision, before.revision);
    EXPECT_EQ(mesh->numbers().hash, before.hash);
    ExpectColumnsAreTheReplicas(*mesh);
    EXPECT_TRUE(absl::IsDataLoss(mesh->Edit(batch, {}).status()));
    EXPECT_TRUE(absl::IsDataLoss(mesh->Features().status()));
  }
}

}  // namespace
}  // namespace dynmesh::python
