// Mutation test of two oracles: with any single term of a notification filter switched off, each
// fails. One compares with a run from scratch, the other executes every operation again
// (core/meshing/trace_audit.h). Built from its own copy of the mesher, which has the switches.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <iostream>
#include <numbers>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "core/meshing/filter_terms.h"
#include "tests/differential/differential.h"
#include "tests/support/polygon_script.h"

namespace dynmesh::test {
namespace {

using meshing::FilterTerm;

// Operations that a batch of these sizes stays far below.
constexpr int kEnough = 20'000;
constexpr int kEnoughInSpace = 100'000;

enum class Oracle { kFromScratch, kReproduction };
constexpr Oracle kOracles[] = {Oracle::kFromScratch, Oracle::kReproduction};

template <int D>
RunPlan PlanOf(Oracle oracle, int revisions, int most_operations) {
  RunPlan plan;
  plan.revisions = revisions;
  plan.every_static = ~0 >> 1;
  plan.most_operations = most_operations;
  plan.from_scratch = oracle == Oracle::kFromScratch;
  if (oracle == Oracle::kReproduction) {
    plan.every_judged = 1;
    plan.judge = [](const DynamicMesh& mesh) {
      return dynamic_cast<const LiveMesh<D>&>(mesh).FirstUnreproduced();
    };
  }
  return plan;
}

bool SuiteFails(Oracle oracle) {
  const auto fails = [&](Distribution d, int n, double quality, std::uint64_t seed, int revisions) {
    MeshOptions options;
    options.quality = quality;
    return RunScriptOf<2>(ScriptGenerator(d, n, seed), options,
                          PlanOf<2>(oracle, revisions, kEnough))
        .difference.found;
  };
  constexpr double kQualities[] = {2.0, kDefaultQuality2D, 1.2, 1.0};
  // That two operations split one subsegment, at different times, is rare: where segments
  // meet. Scripts of kParallel may not end.
  const bool only_wedges = switched_off<FilterTerm> == FilterTerm::kDeathOfSubsegment;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    for (const Distribution d : kAllDistributions) {
      if (d == Distribution::kParallel || (only_wedges && d != Distribution::kWedges)) continue;
      if (fails(d, 12, kQualities[seed % 4], seed, 15)) return true;
    }
  }
  return false;
}

// Two segments at 65 degrees, and points that come near one of them on the side away from the
// other: the vertices at which it is split encroach on the other.
bool WedgeFails(const MeshOptions& options, const RunPlan& plan) {
  std::vector<EditBatch> script = {
      {Edit::Add(Feature::Point(1, 0.1, 0.1, 0.5)), Edit::Add(Feature::Point(2, 0.9, 0.1, 0.5)),
       Edit::Add(Feature::Point(3, 0.438, 0.825, 0.5)), Edit::Add(Feature::Segment(4, 1, 2)),
       Edit::Add(Feature::Segment(5, 1, 3))}};
  for (const double at : {0.37, 0.4, 0.5}) {
    script.push_back(
        {Edit::Add(Feature::Point(6, 0.1 + 0.4226 * at - 0.01, 0.1 + 0.9063 * at + 0.005, 0.5))});
    script.push_back({Edit::Remove(6)});
  }
  return Replay(script, options, plan).found;
}

// Three segments at one point. Points near the first split it, its vertices encroach on the second,
// and the midpoints of that encroach on the third, which is added and removed.
bool FanFails(const MeshOptions& options, const RunPlan& plan) {
  for (const double degrees : {62.0, 66.0, 70.0, 75.0}) {
    const double turn = degrees * std::numbers::pi / 180;
    const auto at = [](double angle, double reach) {
      return std::pair(0.4 + reach * std::cos(angle), 0.1 + reach * std::sin(angle));
    };
    const auto point = [&](FeatureId id, double angle, double reach) {
      const auto [x, y] = at(angle, reach);
      return Edit::Add(Feature::Point(id, x, y, 0.5));
    };
    for (const double second : {0.3, 0.35, 0.45}) {
      std::vector<EditBatch> script = {
          {Edit::Add(Feature::Point(1, 0.4, 0.1, 0.5)), point(2, 0, 0.5), point(3, turn, second),
           point(4, 2 * turn, 0.5), Edit::Add(Feature::Segment(5, 1, 2)),
           Edit::Add(Feature::Segment(6, 1, 3))}};
      for (const double reach : {0.05, 0.1, 0.17, 0.25}) {
        script.push_back({point(8, -0.01 / reach, reach)});
        script.push_back({Edit::Add(Feature::Segment(7, 1, 4))});
        script.push_back({Edit::Remove(8)});
        script.push_back({point(8, -0.01 / reach, reach)});
        script.push_back({Edit::Remove(7)});
        script.push_back({Edit::Remove(8)});
      }
      if (Replay(script, options, plan).found) return true;
    }
  }
  return false;
}

// Few points, among which segments are added and removed: balls of subsegments contain vertices
// made before them.
bool CloudFails(const MeshOptions& options, const RunPlan& plan) {
  for (std::uint64_t seed = 5; seed <= 20; ++seed) {  // the first that notices
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> within(0.1, 0.9);
    constexpr FeatureId kPoints = 12;
    std::vector<EditBatch> script(1);
    for (FeatureId id = 1; id <= kPoints; ++id) {
      const double x = within(random), y = within(random);
      script[0].push_back(Edit::Add(Feature::Point(id, x, y, within(random))));
    }
    for (FeatureId id = 1; id < kPoints; ++id) {
      script.push_back({Edit::Add(Feature::Segment(100, id, id + 1))});
      script.push_back({Edit::Remove(100)});
    }
    if (Replay(script, options, plan).found) return true;
  }
  return false;
}

// In 3D, by scripts with polygons: the kinds with the most findings come first.
bool SpaceSuiteFails(Oracle oracle) {
  const RunPlan plan = PlanOf<3>(oracle, 10, kEnoughInSpace);
  MeshOptions options = DefaultsIn<3>();
  if (WedgeFails(options, plan)) return true;
  if (switched_off<FilterTerm> == FilterTerm::kNearCure) options.min_dihedral = 10;
  // Segments are split by the features near them: balls that hold Steiner points are rare
  // elsewhere.
  if (switched_off<FilterTerm> == FilterTerm::kOverSteinerPoint) return CloudFails(options, plan);
  // A midpoint encroaches on another segment's ball only where segments meet.
  if (switched_off<FilterTerm> == FilterTerm::kOverMidpoint) return FanFails(options, plan);
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

class Mutation : public testing::TestWithParam<std::tuple<FilterTerm, Oracle>> {
 protected:
  void SetUp() override { switched_off<FilterTerm> = std::get<0>(GetParam()); }
  Oracle oracle() const { return std::get<1>(GetParam()); }
  void TearDown() override { switched_off<FilterTerm> = FilterTerm::kCount; }
};

std::vector<FilterTerm> TermsBut(std::initializer_list<FilterTerm> none) {
  std::vector<FilterTerm> terms;
  for (int i = 0; i < static_cast<int>(FilterTerm::kCount); ++i) {
    const auto term = static_cast<FilterTerm>(i);
    if (std::ranges::find(none, term) == none.end()) terms.push_back(term);
  }
  return terms;
}

TEST_P(Mutation, OfOneFilterTermIsNoticed) { EXPECT_TRUE(SuiteFails(oracle())); }

// There are no facets, and no cures.
INSTANTIATE_TEST_SUITE_P(EveryTerm, Mutation,
                         testing::Combine(testing::ValuesIn(TermsBut({FilterTerm::kOverFacet,
                                                                      FilterTerm::kNearCure})),
                                          testing::ValuesIn(kOracles)));

using MutationInSpace = Mutation;

TEST_P(MutationInSpace, OfOneFilterTermIsNoticed) { EXPECT_TRUE(SpaceSuiteFails(oracle())); }

// A subsegment that two operations split at different times is rare since features split
// segments first: no script of a few minutes has one. The code of the term is that of 2D.
INSTANTIATE_TEST_SUITE_P(
    EveryTerm, MutationInSpace,
    testing::Combine(testing::ValuesIn(TermsBut({FilterTerm::kDeathOfSubsegment})),
                     testing::ValuesIn(kOracles)));

// A difference names the first operation in which the traces differ, and both versions of it.
TEST(MutationReport, ADifferenceNamesTheFirstOperation) {
  switched_off<FilterTerm> = FilterTerm::kAppearsInCorner;
  Difference difference;
  for (std::uint64_t seed = 1; seed <= 60 && !difference.found; ++seed) {
    difference =
        RunScript(Distribution::kUniform, 12, kDefaultQuality2D, seed, 15, 1, kEnough).difference;
  }
  switched_off<FilterTerm> = FilterTerm::kCount;
  ASSERT_TRUE(difference.found);
  EXPECT_NE(difference.what.find("first in operation "), std::string::npos) << difference.what;
  EXPECT_NE(difference.what.find("\n  here:  "), std::string::npos) << difference.what;
  EXPECT_NE(difference.what.find(" of ("), std::string::npos) << difference.what;
}

TEST(MutationReport, AnOperationNotReproducedIsNamed) {
  switched_off<FilterTerm> = FilterTerm::kAppearsNearer;
  Difference difference;
  for (std::uint64_t seed = 1; seed <= 60 && !difference.found; ++seed) {
    difference = RunScriptOf<2>(ScriptGenerator(Distribution::kUniform, 12, seed), DefaultsIn<2>(),
                                PlanOf<2>(Oracle::kReproduction, 15, kEnough))
                     .difference;
  }
  switched_off<FilterTerm> = FilterTerm::kCount;
  ASSERT_TRUE(difference.found);
  EXPECT_NE(difference.what.find(" when run again: Nearest of ("), std::string::npos)
      << difference.what;
}

TEST(MutationReport, WithNothingSwitchedOffNothingFails) {
  for (const Distribution d : kAllDistributions) {
    const RunReport run = RunScript(d, 12, 1.2, 3, 10);
    EXPECT_FALSE(run.difference.found) << NameOf(d) << ": " << run.difference.what;
  }
}

}  // namespace
}  // namespace dynmesh::test
