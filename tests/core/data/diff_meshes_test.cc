#include "core/data/diff_meshes.h"

#include <algorithm>

#include "dynmesh/mesh.h"
#include "gtest/gtest.h"
#include "tests/core/data/made_up_mesh.h"
#include "tests/support/same_diff.h"

namespace dynmesh {
namespace {

using data::DiffMeshes;
using testing::Identical;
using testing::MakeRandom;
using testing::MakeUpMesh;

TEST(DiffMeshes, LeadsFromOneMeshToTheOther) {
  auto random = MakeRandom();
  for (int round = 0; round < 50; ++round) {
    Mesh mesh = MakeUpMesh(random, 40 + static_cast<int>(random() % 40), 3);
    Mesh target = MakeUpMesh(random, 40 + static_cast<int>(random() % 40), 4);
    const MeshDiff diff = DiffMeshes(mesh, target);
    ASSERT_TRUE(ApplyDiff(mesh, diff).ok());
    Canonicalize(mesh);
    Canonicalize(target);
    EXPECT_TRUE(Identical(mesh, target));
  }
}

TEST(DiffMeshes, OfAMeshWithItselfIsEmpty) {
  auto random = MakeRandom();
  const Mesh mesh = MakeUpMesh(random, 30, 3);
  const MeshDiff diff = DiffMeshes(mesh, mesh);
  EXPECT_TRUE(diff.removed_vertices.empty() && diff.removed_simplices.empty());
  EXPECT_EQ(diff.added_vertices.size() + diff.added_simplex_count(), 0U);
  EXPECT_EQ(diff.added_subsegments.size() + diff.removed_subsegments.size(), 0U);
}

TEST(DiffMeshes, PutsAVertexThatChangesItsOwnerIntoBothLists) {
  auto random = MakeRandom();
  const Mesh mesh = MakeUpMesh(random, 30, 3);
  Mesh target = mesh;
  target.vertices.owners[7] += 1;
  target.hash = ComputeHash(target);
  const MeshDiff diff = DiffMeshes(mesh, target);
  ASSERT_EQ(diff.removed_vertices.size(), 1U);
  ASSERT_EQ(diff.added_vertices.size(), 1U);
  EXPECT_EQ(diff.removed_vertices[0], mesh.vertices.ids[7]);
  EXPECT_EQ(diff.added_vertices.ids[0], mesh.vertices.ids[7]);
  Mesh applied = mesh;
  applied.revision = diff.from_revision;
  EXPECT_TRUE(ApplyDiff(applied, diff).ok());
}

TEST(Canonicalize, OrdersEveryColumnOfADiff) {
  auto random = MakeRandom();
  MeshDiff diff = DiffMeshes(MakeUpMesh(random, 40, 1), MakeUpMesh(random, 40, 2));
  const MeshDiff sorted = diff;  // as DiffMeshes makes them
  std::reverse(diff.removed_vertices.begin(), diff.removed_vertices.end());
  const auto reverse_rows = [](auto& column, std::size_t width) {
    for (std::size_t i = 0, j = column.size() / width; i + 1 < j; ++i) {
      --j;
      for (std::size_t k = 0; k < width; ++k) {
        std::swap(column[i * width + k], column[j * width + k]);
      }
    }
  };
  reverse_rows(diff.removed_simplices, 3);
  reverse_rows(diff.added_simplices, 3);
  reverse_rows(diff.added_vertices.ids, 1);
  reverse_rows(diff.added_vertices.coordinates, 2);
  reverse_rows(diff.added_vertices.containing_dimensions, 1);
  reverse_rows(diff.added_vertices.owners, 1);
  reverse_rows(diff.added_subsegments.ends, 2);
  reverse_rows(diff.added_subsegments.owners, 1);
  reverse_rows(diff.removed_subsegments.ends, 2);
  reverse_rows(diff.removed_subsegments.owners, 1);
  ASSERT_NE(diff.added_simplices, sorted.added_simplices);
  Canonicalize(diff);
  test::ExpectSameRows(diff, sorted);
}

}  // namespace
}  // namespace dynmesh
