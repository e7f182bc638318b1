// Capsules where rounding and ties decide: on borders of cells, of radius 0, wider than the box,
// on top of each other. After every revision the dynamic mesh is what its features make from
// scratch, and capsules that leave and come back leave no trace.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/differential/differential.h"
#include "tests/support/nightly.h"

namespace dynmesh::test::capsule_test {
namespace {

constexpr std::uint64_t kSeed = 20261125;

template <int D>
class CapsuleScript {
 public:
  explicit CapsuleScript(std::uint64_t seed) : random_(seed), mesh_(NewMesh(DefaultsIn<D>())) {}

  void Run(int revisions) {
    EditBatch points;
    for (FeatureId id = 1; id <= 6; ++id) {
      const auto p = AnyPosition();
      points.push_back(Edit::Set(Feature::Point(id, p[0], p[1], p[2])));
    }
    (void)mesh_->Apply(points, ApplyOptions{});  // refused if two are equal: then there are none
    const MeshHash bare = mesh_->hash();
    for (int i = 0; i < revisions; ++i) ASSERT_NO_FATAL_FAILURE(Apply({AnyEdit()}));
    const MeshHash full = mesh_->hash();
    const std::vector<Feature> capsules = Capsules();
    EditBatch away, back;
    for (const Feature& f : capsules) away.push_back(Edit::Remove(f.id));
    for (Feature f : capsules) {
      if (random_.OneIn(2)) std::ranges::reverse(f.sizing.path);
      back.insert(back.begin(), Edit::Add(f));
    }
    if (away.empty()) return;
    ASSERT_NO_FATAL_FAILURE(Apply(away));
    EXPECT_EQ(mesh_->hash(), bare);
    ASSERT_NO_FATAL_FAILURE(Apply(back));
    EXPECT_EQ(mesh_->hash(), full);
  }

 private:
  // Often on the borders of cells.
  std::array<double, 3> AnyPosition() {
    std::array<double, 3> p = {0, 0, 0};
    for (std::size_t k = 0; k < D; ++k) {
      p[k] = random_.OneIn(3) ? random_.Unit() : random_.Below(9) / 8.0;
    }
    return p;
  }
  Path AnyPath() {
    Path path = {AnyPosition()};
    for (int i = random_.Below(4); i >= 0; --i) {
      std::array<double, 3> next = AnyPosition();
      if (random_.OneIn(3)) next[1] = path.back()[1];
      if (next != path.back()) path.push_back(next);
    }
    if (path.size() == 1) path.push_back({path[0][0] < 0.5 ? 0.75 : 0.25, path[0][1], path[0][2]});
    return path;
  }
  double AnyRadius() {
    const double some[] = {0, 0, 0x1p-40, 0.0625, 0.125, 0.1 * random_.Unit()};
    return random_.OneIn(12) ? random_.OneIn(2) ? 2 : 1e300 : some[random_.Below(6)];
  }
  double AnyTarget() {
    return (D == 2 ? 0.06 : 0.25) * (1 + (random_.OneIn(2) ? random_.Below(3) : random_.Unit()));
  }
  std::vector<Feature> Capsules() const {
    std::vector<Feature> capsules = mesh_->Features();
    std::erase_if(capsules, [](const Feature& f) { return f.kind != FeatureKind::kSize; });
    return capsules;
  }
  Edit AnyEdit() {
    const std::vector<Feature> capsules = Capsules();
    if (capsules.size() < 2 || (capsules.size() < 6 && random_.OneIn(2))) {
      return Edit::Add(Feature::SizeCapsule(next_++, AnyPath(), AnyRadius(), AnyTarget()));
    }
    Feature f =
        capsules[static_cast<std::size_t>(random_.Below(static_cast<int>(capsules.size())))];
    const int kind = random_.Below(5);
    if (kind == 0) return Edit::Remove(f.id);
    if (kind == 1) f.sizing.path.push_back(f.sizing.path[f.sizing.path.size() - 2]);  // back
    if (kind == 2) f.sizing.radius = AnyRadius();
    if (kind == 3) f.sizing.target = AnyTarget();
    if (kind == 4) f.sizing.path = AnyPath();
    return Edit::Set(f);
  }
  void Apply(const EditBatch& batch) {
    const auto diff = mesh_->Apply(batch, ApplyOptions{});
    ASSERT_TRUE(diff.ok()) << diff.status();
    const Difference difference = CompareWithScratch(*mesh_, random_.OneIn(2));
    ASSERT_FALSE(difference.found) << difference.what;
  }

  Random random_;
  std::unique_ptr<DynamicMesh> mesh_;
  FeatureId next_ = 100;
};

TEST(CapsulesOfTies, AreThoseFromScratch) {
  for (std::uint64_t seed = kSeed; seed < kSeed + (IsNightly() ? 24 : 6); ++seed) {
    SCOPED_TRACE(seed);
    CapsuleScript<2>(seed).Run(16);
    if (HasFatalFailure()) return;
  }
}

TEST(CapsulesOfTies, AreThoseFromScratchIn3D) {
  for (std::uint64_t seed = kSeed; seed < kSeed + (IsNightly() ? 12 : 2); ++seed) {
    SCOPED_TRACE(seed);
    CapsuleScript<3>(seed).Run(8);
    if (HasFatalFailure()) return;
  }
}

// A path and its reverse are one region: the same mesh to the bit.
TEST(CapsulesOfTies, HaveNoDirection) {
  const Path path = {{0.125, 0.25}, {0.7, 0.3}, {0.7, 0.9}, {0.2, 0.8}};
  const auto forth = NewMesh(DefaultsIn<2>()), back = NewMesh(DefaultsIn<2>());
  const Path reverse(path.rbegin(), path.rend());
  ASSERT_TRUE(
      forth->Apply({Edit::Add(Feature::SizeCapsule(1, path, 0.03, 0.05))}, ApplyOptions{}).ok());
  ASSERT_TRUE(
      back->Apply({Edit::Add(Feature::SizeCapsule(1, reverse, 0.03, 0.05))}, ApplyOptions{}).ok());
  EXPECT_EQ(forth->hash(), back->hash());
}

}  // namespace
}  // namespace dynmesh::test::capsule_test
