// History independence: after every revision of random scripts the dynamic mesh is, in
// mesh and complete trace, what its features make from scratch.
//
// DYNMESH_NIGHTLY=1 runs the long setting (over 100,000 revisions).
#include <gtest/gtest.h>

#include <cstdlib>
#include <tuple>

#include "tests/differential/differential.h"
#include "tests/support/asked.h"

namespace dynmesh::test {
namespace {

bool IsNightly() {
  const char* set = std::getenv("DYNMESH_NIGHTLY");
  return set != nullptr && *set != '\0' && *set != '0';
}

class History : public testing::TestWithParam<std::tuple<Distribution, int>> {};

TEST_P(History, DynamicIsFromScratchAfterEveryRevision) {
  const auto [distribution, asked] = GetParam();
  MeshOptions options;
  options.quality = kAsked[asked].quality;
  options.criterion = kAsked[asked].criterion;
  // Many tiny scripts, where everything interacts, and a few larger ones.
  struct Setting {
    int points, revisions, scripts;
  };
  const std::vector<Setting> settings =
      IsNightly() ? std::vector<Setting>{{6, 100, 6}, {12, 150, 4}, {40, 200, 2}, {150, 100, 1}}
                  : std::vector<Setting>{{6, 20, 1}, {14, 15, 1}, {60, 5, 1}};
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

std::string NameOfCase(const testing::TestParamInfo<std::tuple<Distribution, int>>& info) {
  return NameOf(std::get<0>(info.param)) + kAsked[std::get<1>(info.param)].name;
}

INSTANTIATE_TEST_SUITE_P(All, History,
                         testing::Combine(testing::ValuesIn(kAllDistributions),
                                          testing::Range(0, kAskedCount)),
                         NameOfCase);

// What is large is rebuilt, what is small propagated: nobody can tell.
TEST(Rebuild, GivesTheSameMeshAndTraceAsPropagation) {
  for (const Distribution d : {Distribution::kUniform, Distribution::kSegmentsTurned}) {
    const std::vector<Feature> features = MakeFeatures(d, 200, 5);
    const EditBatch all = AddAll(features);
    PlanarMesh rebuilt({}), propagated({}, AlwaysPropagate());
    const auto a = rebuilt.Apply(all, ApplyOptions{});
    const auto b = propagated.Apply(all, ApplyOptions{});
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_EQ(a->hash, b->hash);
    EXPECT_EQ(rebuilt.Audit().trace, propagated.Audit().trace);
    EXPECT_EQ(a->added_vertices.size(), b->added_vertices.size());
    EXPECT_EQ(a->added_simplices.size(), b->added_simplices.size());
    EXPECT_EQ(a->removed_simplices.size(), b->removed_simplices.size());
  }
}

// Looked at, found large and built anew: the same diffs, and undone when that fails.
TEST(Rebuild, AfterALookIsPropagation) {
  PlanarMeshTuning looking;
  looking.rebuild = {0, -1, 1e9, -1, 1e9};
  for (const Distribution d : kAllDistributions) {
    SCOPED_TRACE(NameOf(d));
    PlanarMesh looked({}, looking), propagated({}, AlwaysPropagate());
    ScriptGenerator generator(d, 40, 8);
    int applied = 0;
    for (int i = 0; i < 15; ++i) {
      const EditBatch batch = generator.Next(propagated.Features());
      const auto a = looked.Apply(batch, ApplyOptions{});
      const auto b = propagated.Apply(batch, ApplyOptions{});
      ASSERT_EQ(a.status().code(), b.status().code());
      applied += a.ok();
      ASSERT_EQ(looked.hash(), propagated.hash());
      ASSERT_EQ(looked.Audit().problems, std::vector<std::string>());
      ASSERT_EQ(looked.Audit().trace, propagated.Audit().trace);
      if (!a.ok()) continue;
      EXPECT_EQ(a->added_vertices, b->added_vertices);
      EXPECT_EQ(a->removed_vertices, b->removed_vertices);
      EXPECT_EQ(a->added_simplices, b->added_simplices);
      EXPECT_EQ(a->removed_simplices, b->removed_simplices);
    }
    EXPECT_GT(applied, 0);
  }
  // Too many vertices: found out while building anew.
  MeshOptions options;
  options.limits.max_vertices = 60;
  PlanarMesh mesh(options, looking);
  ASSERT_TRUE(mesh.Apply({Edit::Add(Feature::Point(1, 0.5, 0.5))}, ApplyOptions{}).ok());
  const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
  EXPECT_FALSE(
      mesh.Apply({Edit::Add(Feature::SizeDisc(2, 0.5, 0.5, 0.3, 0.01))}, ApplyOptions{}).ok());
  EXPECT_EQ(mesh.hash(), hash);
  EXPECT_EQ(mesh.Audit().trace, trace);
}

// What one sizing feature carries decides, not that it is one.
TEST(Rebuild, IsPlannedByWhatABatchIsWorth) {
  const Box box;
  plc::Delta<2> one, many;
  one.added_sizes.resize(1);
  one.added_sizes[0].sizing = {SizeShape::kDisc, 0.01, 0.3, {}};
  EXPECT_EQ(PlanFor(one, 100, 200, box, {}), Plan::kRebuild);
  EXPECT_EQ(PlanFor(one, 100'000, 200'000, box, {}), Plan::kPropagate);
  many.added_points.resize(100);
  EXPECT_EQ(PlanFor(many, 0, 24, box, {}), Plan::kRebuild);
  EXPECT_EQ(PlanFor(many, 1000, 2000, box, {}), Plan::kLook);
  EXPECT_EQ(PlanFor(many, 10'000, 20'000, box, {}), Plan::kPropagate);
  EXPECT_EQ(PlanFor(plc::Delta<2>{}, 0, 24, box, {}), Plan::kPropagate);
}

// Clients' order, ids and directions are not geometry.
TEST(Order, OfFeaturesAndEndsDoesNotMatter) {
  std::vector<Feature> features = MakeFeatures(Distribution::kSegmentsTurned, 60, 9);
  const auto straight = BuildMesh(features, {});
  std::reverse(features.begin(), features.end());
  for (Feature& f : features) std::swap(f.ends[0], f.ends[1]);
  const auto turned = BuildMesh(features, {});
  ASSERT_TRUE(straight.ok() && turned.ok());
  EXPECT_EQ(straight->hash, turned->hash);
}

}  // namespace
}  // namespace dynmesh::test
