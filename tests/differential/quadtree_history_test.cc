// A dynamic quadtree is, after every batch, the one from scratch: leaves, hash, complete trace. A
// replica follows it by its diffs; a batch that is refused, stopped, vetoed or taken back changes
// nothing.
//
// DYNMESH_NIGHTLY=1 runs the long setting (over 100,000 revisions).
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/dynamic_mesh/live_quadtree.h"
#include "dynmesh/error.h"
#include "tests/differential/differential.h"
#include "tests/support/nightly.h"
#include "tests/support/polygon_script.h"

namespace dynmesh::test::quadtree_history_test {
namespace {

constexpr std::uint64_t kSeed = 24;

template <int D>
MeshOptions QuadtreeIn() {
  MeshOptions options = DefaultsIn<D>();
  options.kind = MeshKind::kQuadtree;
  return options;
}

template <int D>
void ExpectAsFromScratch(const LiveQuadtree<D>& tree, bool with_static) {
  const std::vector<Feature> features = tree.Features();
  LiveQuadtree<D> fresh(tree.options());
  if (!features.empty()) {
    const auto diff = fresh.Apply(AddAll(features), ApplyOptions{});
    ASSERT_TRUE(diff.ok()) << diff.status();
  }
  ASSERT_EQ(tree.hash(), fresh.hash());
  const AuditReport ours = tree.Audit(), theirs = fresh.Audit();
  ASSERT_EQ(ours.problems, std::vector<std::string>());
  ASSERT_EQ(theirs.problems, std::vector<std::string>());
  ASSERT_EQ(ours.trace, theirs.trace);
  if (!with_static) return;
  const auto built = BuildMesh(features, tree.options());
  ASSERT_TRUE(built.ok()) << built.status();
  ASSERT_EQ(built->hash, tree.hash());
}

// Applies `batch` in one of several ways. True if it was applied in the end.
template <int D>
bool ApplySomehow(LiveQuadtree<D>& tree, Replica& replica, const EditBatch& batch, Random& random) {
  const MeshHash before = tree.hash(), trace = tree.Audit().trace;
  const auto expect_as_before = [&] {
    EXPECT_EQ(tree.hash(), before);
    EXPECT_EQ(tree.Audit().trace, trace);
    EXPECT_EQ(tree.Audit().problems, std::vector<std::string>());
  };
  const int way = random.Below(6);
  ApplyOptions apply;
  int left = 1 + random.Below(50);
  if (way == 0) apply.interrupted = [&] { return left-- <= 0; };
  if (way == 1) apply.commit = [](const MeshDiff&) { return absl::AbortedError("not now"); };
  if (way == 2) apply.max_operations = 1 + static_cast<std::uint64_t>(random.Below(20));
  if (way == 3) {
    apply.revocable = true;
    tree.Settle();
    if (tree.Apply(batch, apply).ok()) tree.TakeBack(1);
    expect_as_before();
    apply.revocable = false;
  }
  auto diff = tree.Apply(batch, apply);
  if (!diff.ok()) {
    expect_as_before();
    if (way > 2 || GetErrorDetail(diff.status()).has_value() == (way == 1)) return false;
    diff = tree.Apply(batch, ApplyOptions{});  // undisturbed
    if (!diff.ok()) return false;
  }
  const Difference d = replica.Follow(*diff, tree);
  EXPECT_FALSE(d.found) << d.what;
  return true;
}

template <int D, class Generator>
void ExpectHistoryIndependence(Generator generator, int revisions) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  LiveQuadtree<D> tree(QuadtreeIn<D>());
  Replica replica(tree);
  Random random(kSeed);
  int applied = 0;
  for (int tried = 0; applied < revisions && tried < 50 * revisions; ++tried) {
    const EditBatch batch = generator.Next(tree.Features());
    if (batch.empty() || !ApplySomehow(tree, replica, batch, random)) continue;
    ++applied;
    ExpectAsFromScratch(tree, applied % 5 == 0);
    ASSERT_FALSE(::testing::Test::HasFailure()) << "revision " << applied;
  }
  EXPECT_EQ(applied, revisions);
}

class QuadtreeHistory : public ::testing::TestWithParam<Distribution> {};
TEST_P(QuadtreeHistory, IsAsFromScratch) {
  const Distribution d = GetParam();
  if (DimensionOf(d) == 2) {
    ExpectHistoryIndependence<2>(ScriptGenerator(d, 40, kSeed), IsNightly() ? 6000 : 60);
  } else {
    ExpectHistoryIndependence<3>(ScriptGenerator(d, 30, kSeed), IsNightly() ? 3500 : 30);
  }
}
// Not those of sizing features.
INSTANTIATE_TEST_SUITE_P(All, QuadtreeHistory,
                         ::testing::Values(Distribution::kUniform, Distribution::kClustered,
                                         Distribution::kCircle, Distribution::kGrid,
                                         Distribution::kLine, Distribution::kDyadicLine,
                                         Distribution::kTwoScale, Distribution::kSegmentsAxis,
                                         Distribution::kSegmentsTurned, Distribution::kDiagonals,
                                         Distribution::kParallel, Distribution::kWedges,
                                         Distribution::kSpaceUniform, Distribution::kSpaceClustered,
                                         Distribution::kSpaceGrid, Distribution::kSphere,
                                         Distribution::kLineAndCircle, Distribution::kSpaceTwoScale,
                                         Distribution::kGridEdges, Distribution::kTurnedGridEdges,
                                         Distribution::kSkewGridEdges),
                         [](const auto& test) { return NameOf(test.param); });

class QuadtreePolygons : public ::testing::TestWithParam<PolygonKind> {};
TEST_P(QuadtreePolygons, AreAsFromScratch) {
  ExpectHistoryIndependence<3>(PolygonScript(GetParam(), 5, kSeed), IsNightly() ? 500 : 15);
}
INSTANTIATE_TEST_SUITE_P(All, QuadtreePolygons, ::testing::ValuesIn(kPolygonKinds),
                         [](const auto& test) { return NameOf(test.param); });

}  // namespace
}  // namespace dynmesh::test::quadtree_history_test
