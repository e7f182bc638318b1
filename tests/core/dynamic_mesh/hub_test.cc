// At points with very many segments or very many equidistant neighbours, the cost of an edit is
// about proportional to its changes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/dynamic_mesh/feature_table.h"
#include "core/meshing/refinement.h"
#include "core/plc/plc.h"

namespace dynmesh::hub_test {
namespace {

using Refinement = meshing::Refinement<2, sac::Engine>;

// The mesher with its input and visible counters.
class Scene {
 public:
  Scene() : plc_(Options()), refinement_(Options(), nullptr) {}
  void Apply(const EditBatch& batch) {
    const auto delta = plc_.Check(batch);
    ASSERT_TRUE(delta.ok()) << delta.status();
    refinement_.engine().ResetCounters();
    features_.Apply(*delta, refinement_);
    ASSERT_TRUE(refinement_.Propagate([] { return false; }));
    features_.Collect();
    plc_.Apply(*delta);
    refinement_.TakeChanges([](auto, bool, bool) {}, [](auto, bool, bool) {});
  }
  const Refinement& refinement() const { return refinement_; }

 private:
  static MeshOptions Options() {
    MeshOptions options;
    options.box = {{-1, -1}, {1, 1}};
    return options;
  }

  plc::Plc<2> plc_;
  FeatureTable<2> features_;
  Refinement refinement_;
};

Edit AddPointAt(FeatureId id, double radius, double angle) {
  return Edit::Add(Feature::Point(id, radius * std::cos(angle), radius * std::sin(angle)));
}

// Subscribers visited per executed or removed operation: one per segment, and some subsegments.
TEST(Hub, AnEditBesideItAsksAboutItsDegreeForEachOperation) {
  constexpr int kParts = 60;
  for (const int spokes : {100, 200, 400}) {
    Scene star;
    EditBatch batch = {Edit::Add(Feature::Point(1, 0, 0))};
    for (int i = 0; i < spokes; ++i) {
      batch.push_back(AddPointAt(2 + i, 0.8, 2 * std::numbers::pi * i / spokes));
      batch.push_back(Edit::Add(Feature::Segment(100'000 + i, 1, 2 + i)));
    }
    star.Apply(batch);
    const std::size_t before = star.refinement().vertex_count();
    const auto asked_per_operation = [&] {
      const sac::Counters& c = star.refinement().engine().counters();
      return static_cast<double>(c.notified) / static_cast<double>(c.executed + c.dropped);
    };
    star.Apply({AddPointAt(999'999, 2e-3, std::numbers::pi / spokes)});
    EXPECT_GT(star.refinement().vertex_count(), before + spokes);
    EXPECT_LT(asked_per_operation(), spokes + kParts);
    star.Apply({Edit::Remove(999'999)});
    EXPECT_EQ(star.refinement().vertex_count(), before);
    EXPECT_LT(asked_per_operation(), spokes + kParts);
  }
}

// Points at exactly the same distance from the origin, all that a lattice has; each is removed and
// added again. Returns how often a nearest neighbour was searched.
std::uint64_t SearchesOnACircle(bool with_centre) {
  constexpr int kSquared = 5 * 13 * 17 * 29 * 37;
  constexpr double kScale = 1.0 / 2048;
  EditBatch circle;
  for (int x = -1100; x <= 1100; ++x) {
    for (int y = -1100; y <= 1100; ++y) {
      if (x * x + y * y != kSquared) continue;
      circle.push_back(Edit::Add(
          Feature::Point(2 + static_cast<FeatureId>(circle.size()), x * kScale, y * kScale)));
    }
  }
  EXPECT_EQ(circle.size(), 128u);
  Scene scene;
  scene.Apply(circle);
  if (with_centre) scene.Apply({Edit::Add(Feature::Point(1, 0, 0))});
  const std::uint64_t before = scene.refinement().nearest_run();
  for (const Edit& edit : circle) {
    scene.Apply({Edit::Remove(edit.feature.id)});
    scene.Apply({edit});
  }
  return scene.refinement().nearest_run() - before;
}

TEST(Hub, OneOfManyThatAreEquallyNearIsRead) {
  EXPECT_LT(SearchesOnACircle(true), SearchesOnACircle(false) + 16);
}

}  // namespace
}  // namespace dynmesh::hub_test
