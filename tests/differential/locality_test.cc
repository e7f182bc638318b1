// An edit runs operations in proportion to what it changes, however large the rest of the scene.
// The bounds are upper ones and the same at both sizes: a filter that notifies operations
// needlessly exceeds them, and so does a rule by which a change is handed on.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/differential/differential.h"
#include "tests/differential/locality_scenes.h"

namespace dynmesh::test {
namespace {

class Locality : public testing::TestWithParam<LocalityScene> {};

TEST_P(Locality, AnEditCostsWhatItChanges) {
  for (const int n : {GetParam().n, GetParam().large}) {
    SCOPED_TRACE("n " + std::to_string(n));
    const Scene scene = GetParam().make(n);
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
    EXPECT_LE(executed, GetParam().executed);
    EXPECT_LE(vertices, GetParam().vertices);
    EXPECT_EQ(CompareWithScratch(*mesh, n == GetParam().n).what, "");
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Locality, testing::ValuesIn(LocalityScenes()),
                         [](const auto& given) { return std::string(given.param.name); });

}  // namespace
}  // namespace dynmesh::test
