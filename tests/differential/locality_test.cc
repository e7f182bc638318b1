// The number of operations of an edit is proportional to its changes, for any size of the scene.
// The bounds are upper ones and the same at both sizes. A filter that notifies operations
// needlessly exceeds them, and so does a rule that propagates changes.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/differential/differential.h"
#include "tests/differential/locality_scenes.h"

namespace dynmesh::test::locality_test {
namespace {

class Locality : public ::testing::TestWithParam<LocalityScene> {
 protected:
  // `times`: the scene's bounds.
  static void Check(double min_dihedral, std::uint64_t times) {
    for (const int n : {GetParam().n, GetParam().large}) {
      SCOPED_TRACE("n " + std::to_string(n));
      Scene scene = GetParam().make(n);
      scene.options.min_dihedral = min_dihedral;
      const auto mesh = NewMesh(scene.options);
      const auto loaded = mesh->Apply(AddAll(scene.features));
      ASSERT_TRUE(loaded.ok()) << loaded.status();
      std::uint64_t executed = 0;
      std::size_t vertices = 0;
      for (const EditBatch& edit : scene.edits) {
        const auto diff = mesh->Apply(edit);
        ASSERT_TRUE(diff.ok()) << diff.status();
        executed = std::max(executed, diff->work.executed);
        vertices = std::max(vertices, diff->added_vertices.size() + diff->removed_vertices.size());
      }
      EXPECT_LE(executed, times * GetParam().executed);
      EXPECT_LE(vertices, times * GetParam().vertices);
      EXPECT_EQ(CompareWithScratch(*mesh, n == GetParam().n).what, "");
    }
  }
};

TEST_P(Locality, AnEditCostsWhatItChanges) { Check(0, 1); }

// Cures are added and removed with the slivers of the changed part.
class LocalityAmongCures : public Locality {};
TEST_P(LocalityAmongCures, AnEditCostsTwiceThatAtMost) { Check(kDefaultMinDihedral3D, 2); }

std::vector<LocalityScene> ScenesIn3D() {
  std::vector<LocalityScene> scenes;
  for (const LocalityScene& scene : LocalityScenes()) {
    if (scene.make(scene.n).options.dimension == 3) scenes.push_back(scene);
  }
  return scenes;
}

constexpr auto kNameOf = [](const auto& given) { return std::string(given.param.name); };
INSTANTIATE_TEST_SUITE_P(Scenes, Locality, ::testing::ValuesIn(LocalityScenes()), kNameOf);
INSTANTIATE_TEST_SUITE_P(Scenes, LocalityAmongCures, ::testing::ValuesIn(ScenesIn3D()), kNameOf);

}  // namespace
}  // namespace dynmesh::test::locality_test
