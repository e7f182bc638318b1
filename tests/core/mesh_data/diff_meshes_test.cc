#include "core/mesh_data/diff_meshes.h"

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "dynmesh/mesh.h"
#include "gtest/gtest.h"
#include "tests/core/mesh_data/made_up_mesh.h"
#include "tests/support/same_diff.h"

namespace dynmesh {
namespace {

using mesh_data::DiffMeshes;
using testing::Identical;
using testing::MakeRandom;
using testing::MakeUpLabelledMesh;
using testing::MakeUpMesh;

// All vertices of `part` and every other simplex.
void AddPart(const Mesh& part, Mesh& mesh) {
  const auto d = static_cast<std::size_t>(mesh.dimension);
  const std::set<VertexId> known(mesh.vertices.ids.begin(), mesh.vertices.ids.end());
  for (std::size_t i = 0; i < part.vertices.size(); ++i) {
    if (known.contains(part.vertices.ids[i])) continue;
    mesh.vertices.ids.push_back(part.vertices.ids[i]);
    for (std::size_t k = 0; k < d; ++k) {
      mesh.vertices.coordinates.push_back(part.vertices.coordinates[i * d + k]);
    }
    mesh.vertices.containing_dimensions.push_back(part.vertices.containing_dimensions[i]);
    mesh.vertices.owners.push_back(part.vertices.owners[i]);
  }
  const auto rows = [&](const SimplexColumn& simplices) {
    std::set<SimplexColumn> all;
    for (std::size_t i = 0; i < simplices.size(); i += d + 1) {
      all.insert(SimplexColumn(&simplices[i], &simplices[i] + d + 1));
    }
    return all;
  };
  const auto present = rows(mesh.simplices);
  bool take = false;
  for (const SimplexColumn& row : rows(part.simplices)) {
    take = !take;
    if (take && !present.contains(row)) {
      mesh.simplices.insert(mesh.simplices.end(), row.begin(), row.end());
    }
  }
  mesh.hash = ComputeHash(mesh);
}

TEST(DiffMeshes, LeadsFromOneMeshToTheOther) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    for (int round = 0; round < 50; ++round) {
      Mesh mesh = MakeUpMesh(random, 40 + static_cast<int>(random() % 40), 3, dimension);
      Mesh target = MakeUpMesh(random, 40 + static_cast<int>(random() % 40), 4, dimension);
      const MeshDiff diff = DiffMeshes(mesh, target);
      ASSERT_TRUE(ApplyDiff(mesh, diff).ok());
      Canonicalize(mesh);
      Canonicalize(target);
      EXPECT_TRUE(Identical(mesh, target));
    }
  }
}

// Between labelled meshes, and to and from such.
TEST(DiffMeshes, LeadsFromLabelledMeshesToOthers) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    for (int round = 0; round < 60; ++round) {
      // Of like sizes, or one much smaller.
      const int old_size = round % 5 == 1 ? 400 : 40, new_size = round % 5 == 3 ? 400 : 50;
      Mesh mesh = MakeUpMesh(random, old_size, 3, dimension);
      Mesh target = round % 2 == 0 ? mesh : MakeUpMesh(random, new_size, 4, dimension);
      target.revision = 4;
      if (round % 5 == 1) AddPart(target, mesh);  // the smaller one's part
      if (round % 5 == 3) AddPart(mesh, target);
      if (round % 3 != 0) testing::Label(random, mesh);
      if (round % 3 != 1) testing::Label(random, target);
      const MeshDiff diff = DiffMeshes(mesh, target);
      const absl::Status status = ApplyDiff(mesh, diff);
      ASSERT_TRUE(status.ok()) << status;
      Canonicalize(mesh);
      Canonicalize(target);
      EXPECT_TRUE(Identical(mesh, target));
    }
  }
}

TEST(DiffMeshes, PutsASimplexThatChangesItsRegionIntoBothLists) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    Mesh mesh = MakeUpMesh(random, 30, 3, dimension);
    Canonicalize(mesh);
    Mesh target = mesh;
    mesh.regions.assign(mesh.simplex_count(), kNoRegion);
    mesh.regions[7] = 5;
    mesh.regions[8] = 6;
    target.regions.assign(target.simplex_count(), kNoRegion);
    const std::vector<FeatureId> both = {5, 6};
    target.regions[7] = RegionIdOf(both);
    target.regions[8] = 6;
    target.region_sets = {{RegionIdOf(both), both}};
    const MeshDiff diff = DiffMeshes(mesh, target);
    const auto at = mesh.simplices.begin() + 7 * (dimension + 1);
    const SimplexColumn row(at, at + dimension + 1);
    EXPECT_EQ(diff.removed_simplices, row);
    EXPECT_EQ(diff.added_simplices, row);
    EXPECT_EQ(diff.removed_regions, RegionColumn{5});
    EXPECT_EQ(diff.added_regions, RegionColumn{RegionIdOf(both)});
    EXPECT_EQ(diff.region_sets, target.region_sets);
    EXPECT_TRUE(diff.removed_vertices.empty());
  }
}

TEST(Canonicalize, KeepsARegionWithItsSimplex) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    Mesh mesh = MakeUpLabelledMesh(random, 40, 1, dimension);
    std::map<SimplexColumn, RegionId> expected;
    const auto row = [&](const Mesh& m, std::size_t i) {
      const auto at = m.simplices.begin() + static_cast<std::ptrdiff_t>(i) * (dimension + 1);
      return SimplexColumn(at, at + dimension + 1);
    };
    for (std::size_t i = 0; i < mesh.simplex_count(); ++i) expected[row(mesh, i)] = mesh.regions[i];
    Canonicalize(mesh);
    ASSERT_EQ(mesh.regions.size(), mesh.simplex_count());
    for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
      EXPECT_EQ(mesh.regions[i], expected.at(row(mesh, i)));
      if (i > 0) {
        EXPECT_LT(row(mesh, i - 1), row(mesh, i));
      }
    }
  }
}

TEST(Canonicalize, DropsRegionsThatSayNothing) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    Mesh mesh = MakeUpMesh(random, 20, 1, dimension);
    const std::vector<FeatureId> a = {1, 2}, b = {1, 3}, c = {2, 3};
    mesh.regions.assign(mesh.simplex_count(), kNoRegion);
    mesh.region_sets = {{RegionIdOf(a), a}, {RegionIdOf(b), b}, {RegionIdOf(c), c}};
    Mesh idle = mesh;
    Canonicalize(idle);
    EXPECT_TRUE(idle.regions.empty());
    EXPECT_TRUE(idle.region_sets.empty());
    mesh.regions[3] = RegionIdOf(c);
    mesh.regions[4] = RegionIdOf(a);
    mesh.regions[5] = 1;
    mesh.region_sets.push_back(mesh.region_sets[0]);  // as when two lists are put together
    Canonicalize(mesh);
    std::vector<RegionSet> kept = {{RegionIdOf(a), a}, {RegionIdOf(c), c}};
    std::ranges::sort(kept, {}, &RegionSet::id);
    EXPECT_EQ(mesh.region_sets, kept);
  }
}

TEST(DiffMeshes, OfAMeshWithItselfIsEmpty) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    const Mesh mesh = MakeUpLabelledMesh(random, 30, 3, dimension);
    const MeshDiff diff = DiffMeshes(mesh, mesh);
    EXPECT_TRUE(diff.removed_regions.empty() && diff.added_regions.empty());
    EXPECT_TRUE(diff.region_sets.empty());
    EXPECT_TRUE(diff.removed_vertices.empty() && diff.removed_simplices.empty());
    EXPECT_EQ(diff.added_vertices.size() + diff.added_simplex_count(), 0U);
    EXPECT_EQ(diff.added_subsegments.size() + diff.removed_subsegments.size(), 0U);
    EXPECT_EQ(diff.added_subfacets.size() + diff.removed_subfacets.size(), 0U);
  }
}

TEST(DiffMeshes, PutsAVertexThatChangesItsOwnerIntoBothLists) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    const Mesh mesh = MakeUpMesh(random, 30, 3, dimension);
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
}

TEST(DiffMeshes, AConstraintThatChangesItsOwnerGoesAndComes) {
  auto random = MakeRandom();
  const Mesh mesh = MakeUpMesh(random, 30, 3, 3);
  Mesh target = mesh;
  target.revision = 4;
  target.subfacets.owners[7] += 1;
  target.subsegments.owners[5] += 1;
  target.hash = ComputeHash(target);
  EXPECT_NE(target.hash, mesh.hash);
  const MeshDiff diff = DiffMeshes(mesh, target);
  const auto row = [](const SubfacetColumns& from, std::size_t i) {
    const auto at = from.corners.begin() + static_cast<std::ptrdiff_t>(3 * i);
    return SubfacetColumns{{at, at + 3}, {from.owners[i]}};
  };
  EXPECT_EQ(diff.removed_subfacets, row(mesh.subfacets, 7));
  EXPECT_EQ(diff.added_subfacets, row(target.subfacets, 7));
  EXPECT_EQ(diff.removed_subsegments.owners, std::vector{mesh.subsegments.owners[5]});
  EXPECT_EQ(diff.added_subsegments.owners, std::vector{target.subsegments.owners[5]});
  EXPECT_TRUE(diff.removed_vertices.empty() && diff.removed_simplices.empty());
  Mesh applied = mesh;
  ASSERT_TRUE(ApplyDiff(applied, diff).ok());
  Canonicalize(applied);
  Canonicalize(target);
  EXPECT_TRUE(Identical(applied, target));
}

TEST(Canonicalize, OrdersEveryColumnOfADiff) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    MeshDiff diff = DiffMeshes(MakeUpLabelledMesh(random, 40, 1, dimension),
                               MakeUpLabelledMesh(random, 40, 2, dimension));
    const auto d = static_cast<std::size_t>(dimension);
    Canonicalize(diff);
    const MeshDiff sorted = diff;
    std::reverse(diff.removed_vertices.begin(), diff.removed_vertices.end());
    const auto reverse_rows = [](auto& column, std::size_t width) {
      for (std::size_t i = 0, j = column.size() / width; i + 1 < j; ++i) {
        --j;
        for (std::size_t k = 0; k < width; ++k) {
          std::swap(column[i * width + k], column[j * width + k]);
        }
      }
    };
    reverse_rows(diff.removed_simplices, d + 1);
    reverse_rows(diff.added_simplices, d + 1);
    reverse_rows(diff.removed_regions, 1);
    reverse_rows(diff.added_regions, 1);
    reverse_rows(diff.region_sets, 1);
    reverse_rows(diff.added_vertices.ids, 1);
    reverse_rows(diff.added_vertices.coordinates, d);
    reverse_rows(diff.added_vertices.containing_dimensions, 1);
    reverse_rows(diff.added_vertices.owners, 1);
    reverse_rows(diff.added_subsegments.ends, 2);
    reverse_rows(diff.added_subsegments.owners, 1);
    reverse_rows(diff.removed_subsegments.ends, 2);
    reverse_rows(diff.removed_subsegments.owners, 1);
    reverse_rows(diff.added_subfacets.corners, 3);
    reverse_rows(diff.added_subfacets.owners, 1);
    reverse_rows(diff.removed_subfacets.corners, 3);
    reverse_rows(diff.removed_subfacets.owners, 1);
    ASSERT_NE(diff.added_simplices, sorted.added_simplices);
    Canonicalize(diff);
    test::ExpectSameRows(diff, sorted);
  }
}

}  // namespace
}  // namespace dynmesh
