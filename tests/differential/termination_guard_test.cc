// The termination guard. Segments at one point, at angles that leave no room at rho = 1, would be
// split forever, each because of the previous one. Every such run ends, at the scale at which it
// began; the remaining triangles are distinguished from bad ones without excuse; and with the guard
// at work, too, the dynamic mesh equals one from scratch.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "dynmesh/quality.h"
#include "tests/differential/differential.h"

namespace dynmesh::test::termination_guard_test {
namespace {

// Four segments around a point: one angle is small, the others are about 105 degrees, where splits
// go round forever.
std::vector<Feature> MakeStar(std::uint64_t seed) {
  Random random(seed);
  constexpr double kDegree = std::numbers::pi / 180;
  std::vector<Feature> features = {Feature::Point(1, 0.5, 0.5)};
  double angle = random.Unit();
  const double small = (40 + 20 * random.Unit()) * kDegree;
  for (int i = 0; i < 4; ++i) {
    angle += i == 0 ? small : (360 * kDegree - small) / 3 + (2 * random.Unit() - 1) * 4 * kDegree;
    const double length = 0.4 * std::exp2(-10 * random.Unit());
    const auto id = static_cast<FeatureId>(2 + 2 * i);
    features.push_back(
        Feature::Point(id, 0.5 + length * std::cos(angle), 0.5 + length * std::sin(angle)));
    features.push_back(Feature::Segment(id + 1, 1, id));
  }
  return features;
}

double ShortestEdge(const Mesh& mesh) {
  double shortest = INFINITY;
  for (std::size_t s = 0; s < mesh.subsegments.size(); ++s) {
    std::array<const double*, 2> at = {};
    for (std::size_t i = 0; i < 2; ++i) {
      const VertexId id = mesh.subsegments.ends[2 * s + i];
      const auto row = std::ranges::find(mesh.vertices.ids, id) - mesh.vertices.ids.begin();
      at[i] = &mesh.vertices.coordinates[2 * static_cast<std::size_t>(row)];
    }
    shortest = std::min(shortest, std::hypot(at[0][0] - at[1][0], at[0][1] - at[1][1]));
  }
  return shortest;
}

TEST(TerminationGuard, StarsAroundAPoint) {
  constexpr std::uint64_t kSeeds = 2000;
  MeshOptions options;
  options.quality = 1;
  int fired = 0, compared = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const std::vector<Feature> features = MakeStar(seed);
    const auto mesh = BuildMesh(features, options);
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    const QualityReport report = MeasureQuality(*mesh, options);
    EXPECT_EQ(report.over_rho, report.exempt);
    EXPECT_GT(ShortestEdge(*mesh), 0.4 / 1024 / 1000);
    if (report.exempt_by_guard == 0) continue;
    ++fired;
    if (++compared > 10) continue;
    LiveMesh<2> dynamic(options, AlwaysPropagate());
    ASSERT_TRUE(dynamic.Apply(AddAll(features), ApplyOptions{}).ok());
    for (std::size_t i = 2; i < features.size(); i += 2) {
      const Feature& segment = features[i];
      const auto& end = features[i - 1].position;
      for (const Edit& edit : {Edit::Remove(segment.id), Edit::Add(segment),
                               Edit::Move(segment.ends[1], end[0], end[1] + 1e-3),
                               Edit::Move(segment.ends[1], end[0], end[1])}) {
        ASSERT_TRUE(dynamic.Apply({edit}, ApplyOptions{}).ok());
        EXPECT_EQ(CompareWithScratch(dynamic, i % 4 == 0).what, "");
      }
    }
    EXPECT_EQ(dynamic.hash(), mesh->hash);
  }
  EXPECT_GT(fired, 0) << "the guard is not tested";
  RecordProperty("fired", fired);
}

// Usual options do not come near it.
TEST(TerminationGuard, LeavesOtherInputAlone) {
  for (const Distribution d : kAllDistributions) {
    for (const double quality : {1.0, kDefaultQuality2D}) {
      MeshOptions options;
      options.quality = quality;
      const auto mesh = BuildMesh(MakeFeatures(d, 300, 3), options);
      ASSERT_TRUE(mesh.ok()) << mesh.status();
      EXPECT_EQ(MeasureQuality(*mesh, options).exempt_by_guard, 0u) << NameOf(d);
    }
  }
}

}  // namespace
}  // namespace dynmesh::test::termination_guard_test
