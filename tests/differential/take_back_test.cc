// Undoing several revisions at once restores the mesh and the trace from before them, bit for bit;
// the same batches make the same revisions again.
#include <gtest/gtest.h>

#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "tests/differential/differential.h"
#include "tests/support/nightly.h"
#include "tests/support/polygon_script.h"

namespace dynmesh::test::take_back_test {
namespace {

constexpr std::uint64_t kSeed = 5;

template <int D>
struct Moment {
  explicit Moment(const LiveMesh<D>& mesh)
      : revision(mesh.revision()),
        hash(mesh.hash()),
        features(mesh.Features()),
        audit(mesh.Audit()) {}

  void ExpectAgain(const LiveMesh<D>& mesh) const {
    EXPECT_EQ(mesh.revision(), revision);
    EXPECT_EQ(mesh.hash(), hash);
    EXPECT_EQ(mesh.Features(), features);
    const AuditReport now = mesh.Audit();
    EXPECT_EQ(now.problems, std::vector<std::string>());
    EXPECT_EQ(now.trace, audit.trace);
  }

  std::uint64_t revision;
  MeshHash hash;
  std::vector<Feature> features;
  AuditReport audit;
};

// A group of batches, some of them refused, some stopped halfway. `moments` has the mesh before
// each that was applied.
template <int D, class Generator>
std::vector<EditBatch> ApplyGroup(LiveMesh<D>& mesh, Generator& generator, Random& random,
                                  std::vector<Moment<D>>& moments) {
  ApplyOptions revocable;
  revocable.revocable = true;
  std::vector<EditBatch> applied;
  for (int size = 1 + random.Below(5); static_cast<int>(applied.size()) < size;) {
    const EditBatch batch = generator.Next(mesh.Features());
    if (batch.empty()) {
      EXPECT_TRUE(mesh.Apply(batch, revocable).ok());
      continue;
    }
    if (random.OneIn(3)) {
      int left = random.Below(40);
      const auto stopped = mesh.Apply(batch, {.interrupted = [&] { return left-- == 0; }});
      if (stopped.ok()) {  // by its end, and it settled what was before
        applied.clear();
        moments.clear();
      }
      continue;
    }
    const Moment<D> before(mesh);
    if (!mesh.Apply(batch, revocable).ok()) continue;
    moments.push_back(before);
    applied.push_back(batch);
  }
  return applied;
}

template <int D, class Generator>
void ExpectGroupsToBeTakenBack(Generator generator, const LiveMeshTuning& tuning, int groups) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  LiveMesh<D> mesh(DefaultsIn<D>(), tuning);
  Random random(kSeed);
  std::size_t taken = 0;
  for (int group = 0; group < groups; ++group) {
    SCOPED_TRACE("group " + std::to_string(group));
    std::vector<Moment<D>> moments;
    const std::vector<EditBatch> batches = ApplyGroup(mesh, generator, random, moments);
    const Moment<D> after(mesh);
    // Some, then the rest.
    const auto all = static_cast<int>(batches.size());
    const int kept = random.Below(all);
    mesh.TakeBack(static_cast<std::size_t>(all - kept));
    moments[static_cast<std::size_t>(kept)].ExpectAgain(mesh);
    mesh.TakeBack(static_cast<std::size_t>(kept));
    moments.front().ExpectAgain(mesh);
    taken += batches.size();
    const Difference d = CompareWithScratch(mesh, true);
    ASSERT_FALSE(d.found) << d.what;
    Replica replica(mesh);
    for (const EditBatch& batch : batches) {
      const auto diff = mesh.Apply(batch, ApplyOptions{});
      ASSERT_TRUE(diff.ok()) << diff.status();
      const Difference followed = replica.Follow(*diff, mesh);
      ASSERT_FALSE(followed.found) << followed.what;
    }
    after.ExpectAgain(mesh);
    ASSERT_FALSE(::testing::Test::HasFailure());
  }
  EXPECT_GT(taken, static_cast<std::size_t>(groups));
}

// Batches are applied, the oldest settled and the last taken back, in any order. `moments` has the
// mesh before each revision that is not settled.
template <int D, class Generator>
void ExpectPrefixesToBeSettled(Generator generator, const LiveMeshTuning& tuning, int steps) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  LiveMesh<D> mesh(DefaultsIn<D>(), tuning);
  Random random(kSeed + 1);
  ApplyOptions revocable;
  revocable.revocable = true;
  std::deque<Moment<D>> moments;
  int settled = 0, taken = 0;
  for (int step = 0; step < steps; ++step) {
    SCOPED_TRACE("step " + std::to_string(step));
    const auto held = static_cast<int>(moments.size());
    const int way = random.Below(5);
    if (way == 0) {
      const int kept = random.Below(held + 1);
      const Moment<D> before(mesh);
      mesh.SettleAllBut(static_cast<std::size_t>(kept));
      before.ExpectAgain(mesh);
      moments.erase(moments.begin(), moments.end() - kept);
      settled += held - kept;
    } else if (way == 1) {
      const int gone = random.Below(held + 1);
      mesh.TakeBack(static_cast<std::size_t>(gone));
      if (gone > 0) moments[static_cast<std::size_t>(held - gone)].ExpectAgain(mesh);
      moments.erase(moments.end() - gone, moments.end());
      taken += gone;
    } else {
      const Moment<D> before(mesh);
      const EditBatch batch = generator.Next(mesh.Features());
      if (!batch.empty() && mesh.Apply(batch, revocable).ok()) moments.push_back(before);
    }
    const Difference d = CompareWithScratch(mesh, true, /*with_static=*/false);
    ASSERT_FALSE(d.found) << d.what;
    ASSERT_FALSE(::testing::Test::HasFailure());
  }
  mesh.TakeBack(moments.size());
  if (!moments.empty()) moments.front().ExpectAgain(mesh);
  EXPECT_GT(settled, 0);
  EXPECT_GT(taken, 0);
}

class TakeBack : public ::testing::TestWithParam<Distribution> {};

// With propagation alone, and with rebuilds, forth and back, whenever more than a few operations
// run: at any step of several. By day one of them, in `turn`.
std::vector<LiveMeshTuning> TuningsOf(int turn) {
  LiveMeshTuning anew;
  anew.rebuild.at_least = 4;
  anew.rebuild.at_least_work = 30;
  anew.rebuild.work = 0.1;
  if (IsNightly()) return {AlwaysPropagate(), anew};
  return {turn % 2 == 0 ? AlwaysPropagate() : anew};
}

TEST_P(TakeBack, BringsTheFormerTraceBack) {
  const Distribution given = GetParam();
  for (const LiveMeshTuning& tuning : TuningsOf(static_cast<int>(given))) {
    SCOPED_TRACE(tuning.rebuild.at_least);
    if (DimensionOf(given) == 2) {
      ExpectGroupsToBeTakenBack<2>(ScriptGenerator(given, 12, kSeed), tuning, 12);
    } else {
      ExpectGroupsToBeTakenBack<3>(ScriptGenerator(given, 10, kSeed), tuning, IsNightly() ? 8 : 3);
    }
  }
}

TEST_P(TakeBack, UndoesWhatIsNotSettled) {
  const Distribution given = GetParam();
  for (const LiveMeshTuning& tuning : TuningsOf(static_cast<int>(given) + 1)) {
    SCOPED_TRACE(tuning.rebuild.at_least);
    if (DimensionOf(given) == 2) {
      ExpectPrefixesToBeSettled<2>(ScriptGenerator(given, 12, kSeed), tuning, 60);
    } else {
      ExpectPrefixesToBeSettled<3>(ScriptGenerator(given, 10, kSeed), tuning,
                                   IsNightly() ? 60 : 18);
    }
  }
}

class TakeBackPolygons : public ::testing::TestWithParam<PolygonKind> {};

TEST_P(TakeBackPolygons, BringsTheFormerTraceBack) {
  ExpectGroupsToBeTakenBack<3>(PolygonScript(GetParam(), 2, kSeed), AlwaysPropagate(),
                               IsNightly() ? 6 : 2);
}

INSTANTIATE_TEST_SUITE_P(All, TakeBack, ::testing::ValuesIn(kAllDistributions),
                         [](const auto& given) { return NameOf(given.param); });
INSTANTIATE_TEST_SUITE_P(Space, TakeBack, ::testing::ValuesIn(kSpaceDistributions),
                         [](const auto& given) { return NameOf(given.param); });
INSTANTIATE_TEST_SUITE_P(All, TakeBackPolygons, ::testing::ValuesIn(kPolygonKinds),
                         [](const auto& given) { return NameOf(given.param); });

TEST(Settle, KeepsWhatWasAppliedAndOnlyLaterRevisionsAreTakenBack) {
  LiveMesh<2> mesh(MeshOptions{});
  ApplyOptions revocable;
  revocable.revocable = true;
  const auto add = [&](FeatureId id, double x, const ApplyOptions& options) {
    ASSERT_TRUE(mesh.Apply({Edit::Add(Feature::Point(id, x, 0.5))}, options).ok());
  };
  add(1, 0.1, revocable);
  mesh.Settle();
  add(2, 0.2, revocable);
  mesh.TakeBack(1);
  EXPECT_EQ(mesh.revision(), 1u);
  EXPECT_EQ(mesh.Features().size(), 1u);
  // A batch that is refused settles nothing.
  add(3, 0.3, revocable);
  EXPECT_FALSE(mesh.Apply({Edit::Add(Feature::Point(3, 0.4, 0.5))}, ApplyOptions{}).ok());
  mesh.TakeBack(1);
  EXPECT_EQ(mesh.revision(), 1u);
  const Difference d = CompareWithScratch(mesh, true);
  EXPECT_FALSE(d.found) << d.what;
}

}  // namespace
}  // namespace dynmesh::test::take_back_test
