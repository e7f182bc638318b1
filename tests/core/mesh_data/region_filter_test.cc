#include "core/mesh_data/region_filter.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "core/mesh_data/diff_meshes.h"
#include "dynmesh/slot_mesh.h"
#include "gtest/gtest.h"
#include "tests/core/mesh_data/made_up_mesh.h"

namespace dynmesh::mesh_data {
namespace {

using testing::Identical;
using testing::MakeRandom;
using testing::MakeUpLabelledMesh;

Mesh SortedRows(Mesh mesh) {
  Canonicalize(mesh);
  return mesh;
}

// The text of a choice, literally.
bool NaiveHas(const RegionChoice& choice, const std::vector<FeatureId>& polygons) {
  const auto inside = [&](FeatureId id) { return std::ranges::count(polygons, id) > 0; };
  if (std::ranges::any_of(choice.out, inside)) return false;
  if (choice.in_any) return !polygons.empty();
  if (!choice.in.empty()) return std::ranges::any_of(choice.in, inside);
  return true;
}

Mesh NaiveSimplicesInside(const Mesh& mesh, const RegionChoice& choice) {
  Mesh part = mesh;
  const int corners = mesh.dimension + 1;
  part.simplices.clear();
  part.regions.clear();
  for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
    if (!NaiveHas(choice, PolygonsOf(mesh.region(i), mesh.region_sets))) continue;
    const auto row = mesh.simplices.begin() + static_cast<std::ptrdiff_t>(i) * corners;
    part.simplices.insert(part.simplices.end(), row, row + corners);
    part.regions.push_back(mesh.region(i));
  }
  part.hash = ComputeHash(part);
  return SortedRows(part);
}

// Rows with only corners of one simplex as ids.
template <class Columns>
Columns NaiveConstraintsOf(const Mesh& mesh, const Columns& from) {
  const auto corners = static_cast<std::ptrdiff_t>(mesh.dimension) + 1;
  Columns to;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto key = KeyOf(from, i);
    for (auto row = mesh.simplices.begin(); row != mesh.simplices.end(); row += corners) {
      const auto is_corner = [&](VertexId id) { return std::count(row, row + corners, id) > 0; };
      if (!std::all_of(key.begin(), key.end() - 1, is_corner)) continue;
      Append(to, key);
      break;
    }
  }
  return to;
}

Mesh NaiveOnlyInside(const Mesh& mesh, const RegionChoice& choice) {
  Mesh part = NaiveSimplicesInside(mesh, choice);
  std::set<VertexId> used(part.simplices.begin(), part.simplices.end());
  const VertexColumns all = std::exchange(part.vertices, {});
  const auto d = static_cast<std::size_t>(mesh.dimension);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!used.contains(all.ids[i])) continue;
    part.vertices.ids.push_back(all.ids[i]);
    for (std::size_t k = 0; k < d; ++k) {
      part.vertices.coordinates.push_back(all.coordinates[d * i + k]);
    }
    part.vertices.containing_dimensions.push_back(all.containing_dimensions[i]);
    part.vertices.owners.push_back(all.owners[i]);
  }
  part.subsegments = NaiveConstraintsOf(part, mesh.subsegments);
  part.subfacets = NaiveConstraintsOf(part, mesh.subfacets);
  part.hash = ComputeHash(part);
  return SortedRows(part);
}

const std::vector<RegionChoice> kChoices = {
    {},
    {{101}, false, {}},
    {{102, 104}, false, {}},
    {{101, 102, 103, 104}, false, {}},
    {{999}, false, {}},
    {{}, true, {}},
    {{}, true, {103}},
    {{101, 103}, false, {102}},
    {{}, false, {101, 104}},
};

TEST(OnlyInside, KeepsWhatTheChoiceSaysAndWhatThatNeeds) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    for (int round = 0; round < 20; ++round) {
      const Mesh mesh = MakeUpLabelledMesh(random, 60, 3, dimension);
      for (const RegionChoice& choice : kChoices) {
        const Mesh part = OnlyInside(mesh, choice);
        if (choice.IsEverything()) {
          EXPECT_TRUE(Identical(part, mesh));
          continue;
        }
        EXPECT_EQ(part.hash, ComputeHash(part));
        EXPECT_TRUE(Identical(SortedRows(part), NaiveOnlyInside(mesh, choice)));
        EXPECT_TRUE(Identical(SortedRows(SimplicesInside(mesh, choice)),
                              NaiveSimplicesInside(mesh, choice)));
      }
    }
  }
}

TEST(OnlyInside, OfAMeshWithoutPolygonsIsNothingOrAllOfItsSimplices) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    const Mesh mesh = testing::MakeUpMesh(random, 30, 3, dimension);
    EXPECT_EQ(OnlyInside(mesh, {{101}, false, {}}).simplex_count(), 0U);
    EXPECT_EQ(OnlyInside(mesh, {{101}, false, {}}).vertices.size(), 0U);
    EXPECT_EQ(OnlyInside(mesh, {{101}, false, {}}).hash, MeshHash());
    EXPECT_EQ(OnlyInside(mesh, {{}, false, {101}}).simplices, mesh.simplices);
  }
}

// A replica of the part that gets filtered diffs only equals the part at any time.
TEST(SimplicesInside, OfDiffsKeepAReplicaOfThePart) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    for (const RegionChoice& choice : kChoices) {
      Mesh mesh = MakeUpLabelledMesh(random, 60, 0, dimension);
      const Mesh part = SimplicesInside(mesh, choice);
      MeshHash hidden = mesh.hash;
      hidden -= part.hash;
      auto store = SlotMesh::FromMesh(part);
      ASSERT_TRUE(store.ok()) << store.status();
      for (std::uint64_t revision = 1; revision <= 10; ++revision) {
        // Every other one changes labels only.
        Mesh next = revision % 2 == 0 ? mesh : testing::MakeUpMesh(random, 60, revision, dimension);
        next.revision = revision;
        testing::Label(random, next);
        const MeshDiff diff = SimplicesInside(DiffMeshes(mesh, next), choice, hidden);
        const absl::Status status = store->Apply(diff);
        ASSERT_TRUE(status.ok()) << status;
        EXPECT_TRUE(Identical(SortedRows(store->ToMesh()), NaiveSimplicesInside(next, choice)));
        mesh = next;
      }
    }
  }
}

TEST(RegionChoice, IsPutInOrder) {
  RegionChoice choice = {{3, 1, 3}, false, {5, 5, 4}};
  Normalize(choice);
  EXPECT_EQ(choice, (RegionChoice{{1, 3}, false, {4, 5}}));
}

}  // namespace
}  // namespace dynmesh::mesh_data
