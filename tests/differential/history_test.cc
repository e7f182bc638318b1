// History independence: after every revision of random scripts the dynamic mesh is, in
// mesh and complete trace, what its features make from scratch.
//
// DYNMESH_NIGHTLY=1 runs the long setting (over 100,000 revisions).
#include <gtest/gtest.h>

#include <cstdlib>
#include <tuple>

#include "core/dynamic_mesh/rebuild_choice.h"
#include "tests/differential/differential.h"
#include "tests/support/asked.h"
#include "tests/support/nightly.h"
#include "tests/support/polygon_script.h"
#include "tests/support/same_diff.h"

namespace dynmesh::test::history_test {
namespace {

// Scripts of `revisions` revisions around that many points.
struct Setting {
  int points, revisions, scripts;
};

void ExpectFromScratch(Distribution distribution, const Asked& asked,
                       const std::vector<Setting>& settings) {
  MeshOptions options;
  options.dimension = DimensionOf(distribution);
  options.quality = asked.quality;
  options.criterion = asked.criterion;
  options.min_dihedral = asked.min_dihedral;
  const std::uint64_t base = IsNightly() ? 77'000 : 1'000;
  for (const Setting& s : settings) {
    for (int k = 0; k < s.scripts; ++k) {
      const std::uint64_t seed =
          base + 100 * static_cast<std::uint64_t>(s.points) + static_cast<std::uint64_t>(k);
      SCOPED_TRACE(NameOf(distribution) + " points " + std::to_string(s.points) + " seed " +
                   std::to_string(seed));
      const RunReport run = RunScript(distribution, s.points, options, seed, s.revisions);
      if (run.difference.found) {
        FAIL() << run.difference.what << "\nshrunk script:\n"
               << ToScript(options, Shrink(run.script, options));
      }
      EXPECT_EQ(run.revisions, s.revisions) << "too many proposals were refused";
    }
  }
}

using Given = std::tuple<Distribution, int>;
class History : public ::testing::TestWithParam<Given> {};

// Many tiny scripts, where everything interacts, and a few larger ones.
TEST_P(History, DynamicIsFromScratchAfterEveryRevision) {
  ExpectFromScratch(
      std::get<0>(GetParam()), kAsked[std::get<1>(GetParam())],
      IsNightly() ? std::vector<Setting>{{6, 100, 6}, {12, 150, 4}, {40, 200, 2}, {150, 100, 1}}
                  : std::vector<Setting>{{6, 20, 1}, {14, 15, 1}, {60, 5, 1}});
}

INSTANTIATE_TEST_SUITE_P(All, History,
                         ::testing::Combine(::testing::ValuesIn(kAllDistributions),
                                            ::testing::Range(0, kAskedCount)),
                         [](const auto& given) {
                           return NameOf(std::get<0>(given.param)) +
                                  kAsked[std::get<1>(given.param)].name;
                         });

class SpaceHistory : public ::testing::TestWithParam<Given> {};

TEST_P(SpaceHistory, DynamicIsFromScratchAfterEveryRevision) {
  ExpectFromScratch(std::get<0>(GetParam()), kAskedInSpace[std::get<1>(GetParam())],
                    IsNightly() ? std::vector<Setting>{{10, 100, 3}, {40, 100, 2}, {200, 50, 1}}
                                : std::vector<Setting>{{10, 3, 1}, {40, 1, 1}});
}

INSTANTIATE_TEST_SUITE_P(All, SpaceHistory,
                         ::testing::Combine(::testing::ValuesIn(kSpaceDistributions),
                                            ::testing::Range(0, kAskedInSpaceCount)),
                         [](const auto& given) {
                           return NameOf(std::get<0>(given.param)) +
                                  kAskedInSpace[std::get<1>(given.param)].name;
                         });

void ExpectSameCounts(const MeshDiff& a, const MeshDiff& b) {
  EXPECT_EQ(a.added_vertices.size(), b.added_vertices.size());
  EXPECT_EQ(a.added_simplices.size(), b.added_simplices.size());
  EXPECT_EQ(a.removed_simplices.size(), b.removed_simplices.size());
}

// Large batches rebuild, small ones propagate: the results are the same.
template <int D>
void ExpectRebuiltIsPropagated(Distribution d) {
  const EditBatch all = AddAll(MakeFeatures(d, 200, 5));
  LiveMesh<D> rebuilt(DefaultsIn<D>()), propagated(DefaultsIn<D>(), AlwaysPropagate());
  const auto a = rebuilt.Apply(all, ApplyOptions{});
  const auto b = propagated.Apply(all, ApplyOptions{});
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->hash, b->hash);
  EXPECT_EQ(rebuilt.Audit().trace, propagated.Audit().trace);
  ExpectSameCounts(*a, *b);
}

TEST(Rebuild, GivesTheSameMeshAndTraceAsPropagation) {
  ExpectRebuiltIsPropagated<2>(Distribution::kUniform);
  ExpectRebuiltIsPropagated<2>(Distribution::kSegmentsTurned);
  ExpectRebuiltIsPropagated<3>(Distribution::kSpaceUniform);
  ExpectRebuiltIsPropagated<3>(Distribution::kTurnedGridEdges);
}

LiveMeshTuning AlwaysLook() {
  LiveMeshTuning looking;
  looking.rebuild = {0, -1, 1e9, -1, 1e9};
  return looking;
}

// Probed, found large and rebuilt: the same diffs.
template <int D, class Generator>
void ExpectLookedAtIsPropagated(const std::string& name, Generator generator, int batches) {
  SCOPED_TRACE(name);
  LiveMesh<D> looked(DefaultsIn<D>(), AlwaysLook()), propagated(DefaultsIn<D>(), AlwaysPropagate());
  int applied = 0;
  for (int i = 0; i < batches; ++i) {
    const EditBatch batch = generator.Next(propagated.Features());
    auto a = looked.Apply(batch, ApplyOptions{});
    auto b = propagated.Apply(batch, ApplyOptions{});
    ASSERT_EQ(a.status().code(), b.status().code());
    applied += a.ok();
    ASSERT_EQ(looked.hash(), propagated.hash());
    ASSERT_EQ(looked.Audit().problems, std::vector<std::string>());
    ASSERT_EQ(looked.Audit().trace, propagated.Audit().trace);
    if (!a.ok()) continue;
    Canonicalize(*a);
    Canonicalize(*b);
    ExpectSameRows(*a, *b);
  }
  EXPECT_GT(applied, 0);
}

TEST(Rebuild, AfterALookIsPropagation) {
  for (const Distribution d : kAllDistributions) {
    ExpectLookedAtIsPropagated<2>(NameOf(d), ScriptGenerator(d, 40, 8), 15);
  }
  for (const Distribution d : kSpaceDistributions) {
    ExpectLookedAtIsPropagated<3>(NameOf(d), ScriptGenerator(d, 40, 8), 3);
  }
  for (const PolygonKind kind : kPolygonKinds) {
    ExpectLookedAtIsPropagated<3>(NameOf(kind), PolygonScript(kind, 2, 8), 4);
  }
}

// Too many vertices: detected during the rebuild, and undone.
template <int D>
void ExpectUndone() {
  MeshOptions options = DefaultsIn<D>();
  options.limits.max_vertices = D == 2 ? 60 : 700;
  LiveMesh<D> mesh(options, AlwaysLook());
  ASSERT_TRUE(mesh.Apply({Edit::Add(Feature::Point(1, 0.5, 0.5, 0.5))}, ApplyOptions{}).ok());
  const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
  const Sizing fine = {SizeShape::kDisc, D == 2 ? 0.01 : 0.04, 0.3, {}};
  const auto diff =
      mesh.Apply({Edit::Add(Feature::Size(2, {0.5, 0.5, 0.5}, fine))}, ApplyOptions{});
  EXPECT_EQ(diff.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(mesh.hash(), hash);
  EXPECT_EQ(mesh.Audit().trace, trace);
}

TEST(Rebuild, OverALimitIsUndone) {
  ExpectUndone<2>();
  ExpectUndone<3>();
}

// The effect of a sizing feature decides, not its presence.
TEST(Rebuild, IsPlannedByWhatABatchIsWorth) {
  const Box box;
  plc::Delta<2> one, many;
  one.added_sizes.resize(1);
  one.added_sizes[0].sizing = {SizeShape::kDisc, 0.01, 0.3, {}};
  EXPECT_EQ(PlanFor(one, 100, 200, box, {}), Plan::kRebuild);
  EXPECT_EQ(PlanFor(one, 100'000, 200'000, box, {}), Plan::kPropagate);
  many.added_points.resize(100);
  // A move keeps what it can.
  plc::Delta<2> moved = one;
  moved.removed_sizes = one.added_sizes;
  EXPECT_EQ(PlanFor(moved, 100, 200, box, {}), Plan::kProbe);
  EXPECT_EQ(PlanFor(many, 100, 10'000, box, {}), Plan::kProbe);
  EXPECT_EQ(PlanFor(many, 0, 24, box, {}), Plan::kRebuild);
  EXPECT_EQ(PlanFor(many, 1000, 2000, box, {}), Plan::kProbe);
  EXPECT_EQ(PlanFor(many, 10'000, 20'000, box, {}), Plan::kPropagate);
  EXPECT_EQ(PlanFor(plc::Delta<2>{}, 0, 24, box, {}), Plan::kPropagate);
  // In 3D by volume: a ball of 0.3 has 113 cells of 0.1, 113,000 of 0.01.
  plc::Delta<3> ball;
  ball.added_sizes.resize(1);
  ball.added_sizes[0].sizing = {SizeShape::kDisc, 0.1, 0.3, {}};
  EXPECT_EQ(PlanFor(ball, 100, 1000, box, {}), Plan::kPropagate);
  EXPECT_EQ(PlanFor(ball, 100, 300, box, {}), Plan::kRebuild);
  ball.added_sizes[0].sizing.target = 0.01;
  EXPECT_EQ(PlanFor(ball, 100'000, 200'000, box, {}), Plan::kRebuild);
  EXPECT_EQ(PlanFor(ball, 100'000, 500'000, box, {}), Plan::kPropagate);
}

// Clients' order, ids and directions are not geometry.
TEST(Order, OfFeaturesAndEndsDoesNotMatter) {
  for (const Distribution d : {Distribution::kSegmentsTurned, Distribution::kTurnedGridEdges}) {
    MeshOptions options;
    options.dimension = DimensionOf(d);
    std::vector<Feature> features = MakeFeatures(d, 60, 9);
    const auto straight = BuildMesh(features, options);
    std::reverse(features.begin(), features.end());
    for (Feature& f : features) std::swap(f.ends[0], f.ends[1]);
    const auto turned = BuildMesh(features, options);
    ASSERT_TRUE(straight.ok() && turned.ok());
    EXPECT_EQ(straight->hash, turned->hash);
  }
}

}  // namespace
}  // namespace dynmesh::test::history_test
