// Calls of ApplyOptions::progress: stages in order, increasing parts, done == total at the end. The
// callback has no effect on the result.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "core/dynamic_mesh/progress_meter.h"
#include "tests/differential/differential.h"
#include "tests/support/deadline.h"
#include "tests/support/polygon_script.h"

namespace dynmesh::test::progress_test {
namespace {

using Stage = ApplyProgress::Stage;
using Told = std::vector<ApplyProgress>;

constexpr std::uint64_t kSeed = 11;

double PartOf(const ApplyProgress& p) {
  return p.total == 0 ? 0 : static_cast<double>(p.done) / static_cast<double>(p.total);
}

// Stages do not go back; within one neither `done` nor the part decreases. With `complete`, each
// stage is reported to its end.
void ExpectSound(const Told& told, bool complete) {
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_LE(told[i].done, told[i].total) << i;
    const bool is_last = i + 1 == told.size() || told[i + 1].stage != told[i].stage;
    if (complete && is_last) {
      EXPECT_GT(told[i].total, 0u) << i;
      EXPECT_EQ(told[i].done, told[i].total) << i;
    }
    if (i + 1 == told.size()) break;
    EXPECT_LE(told[i].stage, told[i + 1].stage) << i;
    if (is_last) continue;
    EXPECT_LE(told[i].done, told[i + 1].done) << i;
    EXPECT_LE(PartOf(told[i]), PartOf(told[i + 1])) << i;
  }
}

std::vector<Stage> StagesOf(const Told& told) {
  std::vector<Stage> stages;
  for (const ApplyProgress& p : told) {
    if (stages.empty() || stages.back() != p.stage) stages.push_back(p.stage);
  }
  return stages;
}

const std::vector<Stage> kAllStages = {Stage::kValidate, Stage::kRefine, Stage::kDiff};

ApplyOptions Into(Told& told) {
  ApplyOptions options;
  options.progress = [&told](const ApplyProgress& p) { told.push_back(p); };
  return options;
}

// The same script with and without a callback.
template <int D, class Generator>
void ExpectListeningChangesNothing(Generator generator, const LiveMeshTuning& tuning,
                                   int revisions) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  LiveMesh<D> heard(DefaultsIn<D>(), tuning), unheard(DefaultsIn<D>(), tuning);
  for (int revision = 0; revision < revisions;) {
    const EditBatch batch = generator.Next(heard.Features());
    if (batch.empty()) continue;
    Told told;
    const auto a = heard.Apply(batch, Into(told));
    const auto b = unheard.Apply(batch, ApplyOptions());
    ASSERT_EQ(a.status(), b.status());
    ExpectSound(told, a.ok());
    if (!a.ok()) continue;
    ++revision;
    EXPECT_EQ(StagesOf(told), kAllStages);
    EXPECT_EQ(a->hash, b->hash);
    EXPECT_EQ(a->work.executed, b->work.executed);
    EXPECT_EQ(heard.Audit().trace, unheard.Audit().trace);
    EXPECT_EQ(heard.Audit().problems, std::vector<std::string>());
    ASSERT_FALSE(testing::Test::HasFailure());
  }
}

TEST(Progress, ListeningChangesNothing) {
  LiveMeshTuning rebuild;
  rebuild.rebuild.at_least = 0;
  rebuild.rebuild.features = -1;
  for (const LiveMeshTuning& tuning : {LiveMeshTuning(), AlwaysPropagate(), rebuild}) {
    for (const Distribution d : {Distribution::kUniform, Distribution::kWedges,
                                 Distribution::kSized, Distribution::kPolygons}) {
      SCOPED_TRACE(NameOf(d));
      ExpectListeningChangesNothing<2>(ScriptGenerator(d, 40, kSeed), tuning, 10);
    }
    ExpectListeningChangesNothing<3>(ScriptGenerator(Distribution::kSpaceSized, 10, kSeed), tuning,
                                     4);
    ExpectListeningChangesNothing<3>(PolygonScript(kPolygonKinds[0], 2, kSeed), tuning, 4);
  }
}

// Long enough to be reported, on any machine on which a user would wait noticeably.
template <int D>
void ExpectToldOfOnTheWay(Distribution distribution, std::size_t count) {
  SCOPED_TRACE(NameOf(distribution));
  const std::vector<Feature> features = MakeFeatures(distribution, count, kSeed);
  LiveMesh<D> mesh(DefaultsIn<D>());
  EditBatch few;
  for (std::size_t i = 0; i < count / 60; ++i) few.push_back(Edit::Remove(features[i * 50].id));
  for (const EditBatch& batch : {AddAll(features), few}) {
    Told told;
    std::vector<std::chrono::steady_clock::time_point> when;
    ApplyOptions options;
    options.progress = [&](const ApplyProgress& p) {
      told.push_back(p);
      when.push_back(std::chrono::steady_clock::now());
    };
    ASSERT_TRUE(mesh.Apply(batch, options).ok());
    ExpectSound(told, true);
    EXPECT_EQ(StagesOf(told), kAllStages);
    int between = 0;
    for (std::size_t i = 1; i < told.size(); ++i) {
      if (told[i].done == told[i].total || told[i].total == 0) continue;
      ++between;
      EXPECT_GE(when[i] - when[i - 1], std::chrono::milliseconds(50));
    }
    const auto took = when.back() - when.front();
    EXPECT_TRUE(between >= 1 || took < std::chrono::milliseconds(400))
        << "nothing was told for " << took / std::chrono::milliseconds(1) << " ms";
  }
}

TEST(Progress, LongBatchesAreToldOfOnTheWayButSeldom) {
  ExpectToldOfOnTheWay<2>(Distribution::kUniform, 60'000);
  ExpectToldOfOnTheWay<3>(Distribution::kSpaceUniform, 12'000);
}

TEST(Progress, ABatchThatIsTriedTwiceIsToldOfOnce) {
  MeshOptions options;
  options.limits.max_vertices = 60;
  LiveMesh<2> mesh(options, AlwaysPropagate());
  const EditBatch ten = AddAll(MakeFeatures(Distribution::kUniform, 10, kSeed));
  ASSERT_TRUE(mesh.Apply(ten, ApplyOptions()).ok());
  EditBatch many;
  for (const Feature& f : MakeFeatures(Distribution::kUniform, 60, kSeed + 1)) {
    many.push_back(Edit::Add(f));
    many.back().feature.id += 1000;
  }
  Told told;
  // Propagated, over the limit, undone, built anew, over the limit.
  ASSERT_TRUE(absl::IsResourceExhausted(mesh.Apply(many, Into(told)).status()));
  ExpectSound(told, false);
  EXPECT_EQ(StagesOf(told), (std::vector{Stage::kValidate, Stage::kRefine}));
}

TEST(Progress, OfARefusedBatchOnlyItsValidationIsTold) {
  LiveMesh<2> mesh(MeshOptions{});
  Told told;
  ASSERT_FALSE(mesh.Apply({Edit::Remove(7)}, Into(told)).ok());
  EXPECT_EQ(StagesOf(told), std::vector{Stage::kValidate});
  told.clear();
  ASSERT_TRUE(mesh.Apply({}, Into(told)).ok());
  EXPECT_TRUE(told.empty()) << "nothing was to be done";
}

TEST(Progress, AnotherThreadMayCancelAtAnyStage) {
  const EditBatch load = AddAll(MakeFeatures(Distribution::kUniform, 20'000, kSeed));
  LiveMesh<2> mesh(MeshOptions{});
  ASSERT_TRUE(mesh.Apply({Edit::Add(Feature::Point(1'000'000, 0.5, 0.25))}, ApplyOptions()).ok());
  const MeshHash before = mesh.hash(), trace = mesh.Audit().trace;
  for (const Stage stage : {Stage::kValidate, Stage::kRefine}) {
    std::mutex mutex;
    std::condition_variable changed;
    bool reached = false;
    std::atomic<bool> cancelled{false};
    std::thread canceller([&] {
      std::unique_lock lock(mutex);
      WaitUntil("the stage", changed, lock, [&] { return reached; });
      cancelled.store(true);
      changed.notify_all();
    });
    Told told;
    ApplyOptions options;
    options.interrupted = [&] { return cancelled.load(); };
    options.progress = [&](const ApplyProgress& p) {
      told.push_back(p);
      if (p.stage != stage) return;
      std::unique_lock lock(mutex);
      reached = true;
      changed.notify_all();
      WaitUntil("cancellation", changed, lock, [&] { return cancelled.load(); });
    };
    EXPECT_TRUE(absl::IsCancelled(mesh.Apply(load, options).status()));
    canceller.join();
    ExpectSound(told, false);
    EXPECT_EQ(told.back().stage, stage) << "undoing is not reported";
    EXPECT_EQ(mesh.hash(), before);
    EXPECT_EQ(mesh.Audit().trace, trace);
  }
}

// The meter with work that grows faster than it is done, and with repeated stages.
TEST(ProgressMeter, KeepsItsPromiseWhateverItIsFedWith) {
  Told told;
  const ProgressMeter::Listener listener = [&](const ApplyProgress& p) { told.push_back(p); };
  ProgressMeter meter(listener);
  const auto feed = [&](std::uint64_t done, std::uint64_t total) {
    std::this_thread::sleep_for(std::chrono::milliseconds(51));
    for (int i = 0; i < 32; ++i) meter.Step([&] { return ProgressMeter::Work{done, total}; });
  };
  meter.Begin(Stage::kValidate);
  feed(1, 10);
  meter.End(10);
  meter.Begin(Stage::kRefine);
  feed(50, 100);
  feed(60, 1000);  // half is done, and stays done
  feed(900, 1000);
  meter.Begin(Stage::kRefine);  // again from the beginning, with less to do
  feed(10, 100);
  feed(10, 2000);
  meter.End(1500);
  meter.Begin(Stage::kDiff);
  meter.Begin(Stage::kRefine);  // too late to report that
  feed(5, 10);
  meter.End(10);
  meter.Begin(Stage::kDiff);
  meter.End();
  ExpectSound(told, true);
  EXPECT_EQ(StagesOf(told), kAllStages);
  ASSERT_EQ(told.size(), 11u);
  EXPECT_EQ(told[5].done, 500u);
  EXPECT_EQ(told[7].done, 1800u);
  EXPECT_EQ(told[8].done, 1800u);
}

}  // namespace
}  // namespace dynmesh::test::progress_test
