// The differential test has teeth: with any one term of a notification filter
// switched off it fails. Built from its own copy of the mesher, in which they can be.
#include <gtest/gtest.h>

#include <cstdint>
#include <iostream>
#include <utility>

#include "core/meshing/filter_terms.h"
#include "tests/differential/differential.h"
#include "tests/support/polygon_script.h"

namespace dynmesh::test {
namespace {

// Operations that a batch of these sizes stays far below.
constexpr int kEnough = 20'000;
constexpr int kEnoughInSpace = 100'000;

bool SuiteFails() {
  constexpr double kQualities[] = {2.0, kDefaultQuality2D, 1.2, 1.0};
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    for (const Distribution d : kAllDistributions) {
      if (d == Distribution::kParallel) continue;
      if (RunScript(d, 12, kQualities[seed % 4], seed, 15, 1, kEnough).difference.found)
        return true;
    }
    // Cascades of splits, the only place where this term counts. (With other terms off
    // they may not end.)
    if (meshing::switched_off == meshing::Term::kDeathOfSubsegment &&
        RunScript(Distribution::kParallel, 14, seed % 2 == 0 ? 1.2 : 1.0, seed, 40, 1, kEnough)
            .difference.found) {
      return true;
    }
  }
  return false;
}

// Two segments at 65 degrees, and points that come near one of them on the side away from the
// other: the vertices at which it is split encroach on the other.
bool WedgeFails(const MeshOptions& options) {
  std::vector<EditBatch> script = {
      {Edit::Add(Feature::Point(1, 0.1, 0.1, 0.5)), Edit::Add(Feature::Point(2, 0.9, 0.1, 0.5)),
       Edit::Add(Feature::Point(3, 0.438, 0.825, 0.5)), Edit::Add(Feature::Segment(4, 1, 2)),
       Edit::Add(Feature::Segment(5, 1, 3))}};
  for (const double at : {0.37, 0.4, 0.5}) {
    script.push_back(
        {Edit::Add(Feature::Point(6, 0.1 + 0.4226 * at - 0.01, 0.1 + 0.9063 * at + 0.005, 0.5))});
    script.push_back({Edit::Remove(6)});
  }
  return Replay(script, options).found;
}

// In space, by scripts with polygons: the kinds that notice much come first.
bool SpaceSuiteFails() {
  RunPlan plan;
  plan.revisions = 10;
  plan.every_static = ~0 >> 1;
  plan.most_operations = kEnoughInSpace;
  MeshOptions options = DefaultsIn<3>();
  if (WedgeFails(options)) return true;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    for (const auto& [kind, solids] : {std::pair(PolygonKind::kSticks, 1),
                                       {PolygonKind::kHoled, 1},
                                       {PolygonKind::kPlates, 3},
                                       {PolygonKind::kMixture, 2}}) {
      options.quality = seed % 2 == 0 ? kDefaultQuality2D : kDefaultQuality3D;
      if (RunScriptOf<3>(PolygonScript(kind, solids, seed), options, plan).difference.found) {
        std::cout << NameOf(kind) << " with seed " << seed << " notices\n";
        return true;
      }
    }
  }
  return false;
}

class Mutation : public testing::TestWithParam<int> {
 protected:
  void TearDown() override { meshing::switched_off = meshing::Term::kCount; }
};

TEST_P(Mutation, OfOneFilterTermIsNoticed) {
  meshing::switched_off = static_cast<meshing::Term>(GetParam());
  if (meshing::switched_off == meshing::Term::kOverFacet) return;  // none in the plane
  EXPECT_TRUE(SuiteFails());
}

TEST_P(Mutation, OfOneFilterTermIsNoticedInSpace) {
  meshing::switched_off = static_cast<meshing::Term>(GetParam());
  EXPECT_TRUE(SpaceSuiteFails());
}

INSTANTIATE_TEST_SUITE_P(EveryTerm, Mutation,
                         testing::Range(0, static_cast<int>(meshing::Term::kCount)));

TEST(Mutation, WithNothingSwitchedOffNothingFails) {
  for (const Distribution d : kAllDistributions) {
    const RunReport run = RunScript(d, 12, 1.2, 3, 10);
    EXPECT_FALSE(run.difference.found) << NameOf(d) << ": " << run.difference.what;
  }
}

}  // namespace
}  // namespace dynmesh::test
