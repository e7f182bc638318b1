// An edit runs operations in proportion to what it changes, however large the rest of the scene.
// Each scene is built at two sizes, the second with 16 times the features. The bounds are upper
// ones: a filter that notifies operations needlessly exceeds them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/differential/differential.h"
#include "tests/support/workload.h"

namespace dynmesh::test {
namespace {

// Features, and batches that are applied one after the other, again and again.
struct Scene {
  std::vector<Feature> features;
  std::vector<EditBatch> edits;
};

// The most that one edit takes.
struct Cost {
  std::uint64_t executed = 0;
  std::size_t vertices = 0;  // that came or went
};

// Applies each edit of the scene; compares the mesh with runs from scratch at the end.
Cost CostOf(const Scene& scene) {
  const auto mesh = NewMesh(MeshOptions());
  const auto loaded = mesh->Apply(AddAll(scene.features));
  EXPECT_TRUE(loaded.ok()) << loaded.status();
  Cost most;
  for (const EditBatch& edit : scene.edits) {
    const auto diff = mesh->Apply(edit);
    EXPECT_TRUE(diff.ok()) << diff.status();
    if (!diff.ok()) break;
    most.executed = std::max(most.executed, diff->work.executed);
    most.vertices =
        std::max(most.vertices, diff->added_vertices.size() + diff->removed_vertices.size());
  }
  for (const bool local : {false, true}) EXPECT_EQ(CompareWithScratch(*mesh, local).what, "");
  return most;
}

// A long segment comes and goes.
constexpr FeatureId kFar = 10'000'000;
void AddLongSegment(Scene& scene) {
  scene.features.push_back(Feature::Point(kFar, 0.1, 0.5));
  scene.features.push_back(Feature::Point(kFar + 1, 0.9, 0.5));
  const Feature segment = Feature::Segment(kFar + 2, kFar, kFar + 1);
  scene.edits = {{Edit::Add(segment)}, {Edit::Remove(segment.id)}};
}

// Points in the corner of the box about the ball of a long segment, outside of the ball.
Scene PointsInTheCorner(int n) {
  Scene scene;
  Random random(7);
  for (int i = 0; i < n; ++i) {
    const double x = 0.1 + 0.08 * random.Unit();
    scene.features.push_back(
        Feature::Point(static_cast<FeatureId>(i) + 1, x, 0.1 + 0.08 * random.Unit()));
  }
  AddLongSegment(scene);
  return scene;
}

// The same with short segments.
Scene SegmentsInTheCorner(int n) {
  Scene scene;
  Random random(7);
  const int side = static_cast<int>(std::sqrt(n));
  const double step = 0.08 / side;
  for (int i = 0; i < side * side; ++i) {
    const double x = 0.1 + (i % side + 0.1) * step, y = 0.1 + (i / side + 0.1) * step;
    const double turn = 1.2 * random.Unit();
    const auto id = static_cast<FeatureId>(3 * i + 1);
    scene.features.push_back(Feature::Point(id, x, y));
    scene.features.push_back(
        Feature::Point(id + 1, x + 0.7 * step * std::cos(turn), y + 0.7 * step * std::sin(turn)));
    scene.features.push_back(Feature::Segment(id + 2, id, id + 1));
  }
  AddLongSegment(scene);
  return scene;
}

// A sizing feature over points that are nearer to each other than it asks for.
Scene SizeOverFinerPoints(int n) {
  Scene scene;
  scene.features = MakeFeatures(Distribution::kUniform, n, 7);
  const Feature size = Feature::SizeBox(kFar, 0, 0, 1, 1, 0.9);
  scene.edits = {{Edit::Add(size)}, {Edit::Remove(size.id)}};
  return scene;
}

// Discs of a coarse target over a fine one.
Scene CoarseSizesOverAFineOne(int n) {
  Scene scene;
  const double fine = 0.5 / std::sqrt(n);
  scene.features = {Feature::SizeBox(1, 0.2, 0.2, 0.8, 0.8, fine)};
  for (int k = 0; k < 3; ++k) {
    const auto id = kFar + static_cast<FeatureId>(k);
    const Feature size = Feature::SizeDisc(id, 0.4 + 0.1 * k, 0.5, 0.05, 8 * fine);
    scene.edits.push_back({Edit::Add(size)});
    scene.edits.push_back({Edit::Remove(id)});
  }
  return scene;
}

struct Bound {
  std::string name;
  std::function<Scene(int)> make;
  int n = 0;  // of the smaller scene
  std::uint64_t executed = 0;
  std::size_t vertices = 0;
};

class Locality : public testing::TestWithParam<Bound> {};

TEST_P(Locality, CostIsThatOfWhatChanges) {
  const Bound& bound = GetParam();
  for (const int n : {bound.n, 16 * bound.n}) {
    const Cost cost = CostOf(bound.make(n));
    EXPECT_LE(cost.executed, bound.executed) << "n " << n;
    EXPECT_LE(cost.vertices, bound.vertices) << "n " << n;
    RecordProperty("executed_" + std::to_string(n), std::to_string(cost.executed));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, Locality,
    testing::Values(Bound{"PointsInTheCorner", PointsInTheCorner, 500, 70, 16},
                    Bound{"SegmentsInTheCorner", SegmentsInTheCorner, 400, 60, 16},
                    Bound{"SizeOverFinerPoints", SizeOverFinerPoints, 1000, 20, 0},
                    Bound{"CoarseSizesOverAFineOne", CoarseSizesOverAFineOne, 100, 60, 0}),
    [](const auto& given) { return given.param.name; });

}  // namespace
}  // namespace dynmesh::test
