// Facets at small angles that come and go: after each edit the mesh and its complete trace are
// those of a run from scratch.
#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "tests/support/nightly.h"
#include "tests/support/workload.h"

namespace dynmesh::sharp_history_test {
namespace {

MeshOptions Options() {
  MeshOptions options;
  options.dimension = 3;
  options.box = {{-2, -2, -2}, {2, 2, 2}};
  options.limits.max_vertices = 6'000;
  return options;
}

// Triangles over a few random points, and points on their own.
class History {
 public:
  explicit History(std::uint64_t seed) : random_(seed), mesh_(*DynamicMesh::Create(Options())) {
    EditBatch batch;
    for (FeatureId id = 1; id <= kPoints; ++id) batch.push_back(Edit::Add(PointAt(id)));
    for (const Edit& edit : batch) features_.insert_or_assign(edit.feature.id, edit.feature);
    EXPECT_TRUE(mesh_->Apply(batch).ok());
  }

  // False if the edit is refused.
  bool Step() {
    const Edit edit = Next();
    const auto diff = mesh_->Apply({edit}, {.max_operations = 100'000});
    if (!diff.ok()) return false;
    if (edit.action == Edit::Action::kRemove) {
      features_.erase(edit.feature.id);
    } else {
      features_.insert_or_assign(edit.feature.id, edit.feature);
    }
    return true;
  }
  void ExpectAsFromScratch() const {
    const auto scratch = *DynamicMesh::Create(Options());
    EditBatch all;
    for (const auto& [id, feature] : features_) all.push_back(Edit::Add(feature));
    const auto diff = scratch->Apply(all);
    ASSERT_TRUE(diff.ok()) << diff.status();
    EXPECT_EQ(mesh_->hash(), scratch->hash());
    const AuditReport ours = mesh_->Audit(), theirs = scratch->Audit();
    EXPECT_EQ(ours.trace, theirs.trace);
    EXPECT_TRUE(ours.problems.empty()) << ours.problems.front();
  }

 private:
  static constexpr FeatureId kPoints = 6, kFirstAlone = 50, kFirstTriangle = 100;

  Feature PointAt(FeatureId id) {
    const auto coordinate = [&] { return 2 * random_.Unit() - 1; };
    const double x = coordinate(), y = coordinate(), z = coordinate();
    return Feature::Point(id, x, y, z);
  }
  FeatureId Corner() { return 1 + static_cast<FeatureId>(kPoints * random_.Unit()); }
  Edit Next() {
    std::vector<FeatureId> triangles;
    for (const auto& [id, feature] : features_) {
      if (id >= kFirstTriangle) triangles.push_back(id);
    }
    if (!triangles.empty() && random_.OneIn(4)) {
      const auto i =
          static_cast<std::size_t>(static_cast<double>(triangles.size()) * random_.Unit());
      return Edit::Remove(triangles[i]);
    }
    if (random_.OneIn(4)) {
      const FeatureId id = kFirstAlone + static_cast<FeatureId>(5 * random_.Unit());
      return features_.contains(id) ? Edit::Remove(id) : Edit::Add(PointAt(id));
    }
    const FeatureId a = Corner(), b = a % kPoints + 1;
    FeatureId c = Corner();
    while (c == a || c == b) c = Corner();
    return Edit::Add(Feature::Polygon(kFirstTriangle + made_++, {{a, b, c}}));
  }

  test::Random random_;
  std::unique_ptr<DynamicMesh> mesh_;
  std::map<FeatureId, Feature> features_;
  FeatureId made_ = 0;
};

TEST(SharpHistory, EveryRevisionIsAsFromScratch) {
  int accepted = 0;
  const std::uint64_t seeds = test::IsNightly() ? 32 : 4;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    History history(seed);
    for (int step = 0; step < 20 && !testing::Test::HasFailure(); ++step) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", step " + std::to_string(step));
      if (!history.Step()) continue;
      ++accepted;
      history.ExpectAsFromScratch();
    }
  }
  EXPECT_GT(accepted, 7 * static_cast<int>(seeds));
}

}  // namespace
}  // namespace dynmesh::sharp_history_test
