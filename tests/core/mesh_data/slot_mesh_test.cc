#include "dynmesh/slot_mesh.h"

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "core/mesh_data/diff_meshes.h"
#include "gtest/gtest.h"
#include "tests/core/mesh_data/made_up_mesh.h"

namespace dynmesh::mesh_data {
namespace {

using testing::Identical;
using testing::MakeRandom;
using testing::MakeUpLabelledMesh;
using testing::MakeUpMesh;

Mesh Sorted(Mesh mesh) {
  Canonicalize(mesh);
  return mesh;
}

TEST(SlotMesh, TakesDiffAfterDiffAsTheModelDoes) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    SlotMesh store(dimension);
    Mesh model;
    model.dimension = dimension;
    model.hash = ComputeHash(model);
    for (std::uint64_t revision = 1; revision <= 60; ++revision) {
      Mesh next = MakeUpMesh(random, 20 + static_cast<int>(random() % 60), revision, dimension);
      if (revision % 3 != 0) testing::Label(random, next);
      const MeshDiff diff = DiffMeshes(model, next);
      ASSERT_TRUE(store.Apply(diff).ok());
      ASSERT_TRUE(Identical(Sorted(store.ToMesh()), Sorted(next)));
      ASSERT_EQ(store.hash(), ComputeHash(store.ToMesh()));
      ASSERT_EQ(store.vertex_count(), next.vertices.size());
      ASSERT_EQ(store.simplex_count(), next.simplex_count());
      ASSERT_EQ(store.subsegment_count(), next.subsegments.size());
      ASSERT_EQ(store.subfacet_count(), next.subfacets.size());
      model = next;
    }
  }
}

TEST(SlotMesh, KeepsARegionSetAsLongAsASimplexIsInIt) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    Mesh mesh = MakeUpMesh(random, 10, 1, dimension);
    const std::vector<FeatureId> both = {3, 4};
    const std::vector<RegionSet> sets = {{RegionIdOf(both), both}};
    Mesh labelled = mesh;
    labelled.regions.assign(labelled.simplex_count(), kNoRegion);
    labelled.regions[1] = labelled.regions[2] = RegionIdOf(both);
    labelled.region_sets = sets;
    Mesh less = labelled;
    less.regions[1] = 3;
    auto store = SlotMesh::FromMesh(mesh);
    ASSERT_TRUE(store.ok());
    const auto step = [&](Mesh to) {
      to.hash = ComputeHash(to);
      to.revision = store->revision() + 1;
      return store->Apply(DiffMeshes(store->ToMesh(), to));
    };
    ASSERT_TRUE(step(labelled).ok());
    EXPECT_EQ(store->ToMesh().region_sets, sets);
    ASSERT_TRUE(step(less).ok());
    EXPECT_EQ(store->ToMesh().region_sets, sets);
    ASSERT_TRUE(step(mesh).ok());
    EXPECT_TRUE(store->ToMesh().region_sets.empty());
    EXPECT_TRUE(store->ToMesh().regions.empty());
  }
}

TEST(SlotMesh, FindsWhatItHoldsAndNothingElse) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    const Mesh mesh = MakeUpLabelledMesh(random, 30, 5, dimension);
    const auto store = SlotMesh::FromMesh(mesh);
    ASSERT_TRUE(store.ok());
    EXPECT_EQ(store->revision(), 5U);
    const auto vertex = store->FindVertex(mesh.vertices.ids[4]);
    ASSERT_TRUE(vertex.has_value());
    const auto d = static_cast<std::size_t>(dimension), corners = d + 1;
    for (std::size_t k = 0; k < d; ++k) {
      EXPECT_EQ(vertex->coordinates[k], mesh.vertices.coordinates[4 * d + k]);
    }
    EXPECT_EQ(vertex->owner, mesh.vertices.owners[4]);
    EXPECT_EQ(vertex->containing_dimension, mesh.vertices.containing_dimensions[4]);
    EXPECT_FALSE(store->FindVertex(12345).has_value());
    EXPECT_TRUE(store->HasSimplex({&mesh.simplices[corners], corners}));
    EXPECT_FALSE(store->HasSimplex({&mesh.simplices[corners], corners - 1}));
    EXPECT_EQ(store->FindRegion({&mesh.simplices[corners], corners}), mesh.regions[1]);
    const std::vector<VertexId> none(corners, 7);
    EXPECT_FALSE(store->HasSimplex(none));
    EXPECT_FALSE(store->FindRegion(none).has_value());
    const SubsegmentColumns& s = mesh.subsegments;
    EXPECT_TRUE(store->HasSubsegment(s.ends[1], s.ends[0], s.owners[0]));
    EXPECT_FALSE(store->HasSubsegment(s.ends[1], s.ends[0], s.owners[0] + 1));
    if (dimension == 2) continue;
    const SubfacetColumns& f = mesh.subfacets;
    EXPECT_TRUE(store->HasSubfacet({f.corners[1], f.corners[2], f.corners[0]}, f.owners[0]));
    EXPECT_FALSE(store->HasSubfacet({f.corners[1], f.corners[2], f.corners[0]}, f.owners[0] + 1));
  }
}

// Every kind of invalid diff or mesh, and its error.
struct Refusal {
  const char* name;
  absl::StatusCode code;
  std::function<void(MeshDiff&)> damage;
};

// Even if the sum is right.
template <class Columns>
void GoesTwice(MeshDiff& d, Columns& constraints) {
  const auto key = KeyOf(constraints, 0);
  Append(constraints, key);
  d.hash -= HashOf(key);
}
template <class Columns>
void ComesTwice(MeshDiff& d, Columns& constraints) {
  const auto key = KeyOf(constraints, 0);
  Append(constraints, key);
  d.hash += HashOf(key);
}

// In 2D, where there are no subfacets to damage, another damage with the same code.
template <class Damage>
void InSpace(MeshDiff& d, Damage damage) {
  d.dimension == 3 ? damage() : static_cast<void>(d.hash.lo ^= 1);
}

std::vector<Refusal> Refusals() {
  using absl::StatusCode;
  return {
      {"gap", StatusCode::kFailedPrecondition, [](MeshDiff& d) { d.from_revision += 1; }},
      {"replay", StatusCode::kFailedPrecondition, [](MeshDiff& d) { d.from_revision -= 1; }},
      {"wrong hash", StatusCode::kDataLoss, [](MeshDiff& d) { d.hash.lo ^= 1; }},
      {"vertex to remove is absent", StatusCode::kDataLoss,
       [](MeshDiff& d) { d.removed_vertices[0] = 99; }},
      {"vertex removed twice", StatusCode::kDataLoss,
       [](MeshDiff& d) { d.removed_vertices.push_back(d.removed_vertices[0]); }},
      {"vertex not removed", StatusCode::kDataLoss,
       [](MeshDiff& d) { d.removed_vertices.pop_back(); }},
      {"vertex added twice", StatusCode::kDataLoss,
       [](MeshDiff& d) { d.added_vertices.ids[0] = d.added_vertices.ids[1]; }},
      {"simplex to remove is absent", StatusCode::kDataLoss,
       [](MeshDiff& d) { d.removed_simplices[0] = 99; }},
      {"simplex removed twice", StatusCode::kDataLoss,
       [](MeshDiff& d) {
         const SimplexColumn row(d.removed_simplices.begin(),
                                 d.removed_simplices.begin() + d.dimension + 1);
         d.removed_regions.push_back(d.removed_regions[0]);
         d.removed_simplices.insert(d.removed_simplices.end(), row.begin(), row.end());
       }},
      {"simplex added twice", StatusCode::kDataLoss,
       [](MeshDiff& d) {
         const SimplexColumn row(d.added_simplices.begin(),
                                 d.added_simplices.begin() + d.dimension + 1);
         d.added_regions.push_back(d.added_regions[0]);
         d.added_simplices.insert(d.added_simplices.end(), row.begin(), row.end());
       }},
      {"simplex to remove is in another region", StatusCode::kDataLoss,
       [](MeshDiff& d) {
         // Even if the sum is right.
         d.hash += HashSimplex(&d.removed_simplices[0], d.dimension + 1, d.removed_regions[0]);
         d.removed_regions[0] ^= 1;
         d.hash -= HashSimplex(&d.removed_simplices[0], d.dimension + 1, d.removed_regions[0]);
       }},
      {"simplex added in another region", StatusCode::kDataLoss,
       [](MeshDiff& d) { d.added_regions[0] ^= 1; }},
      {"regions too few", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.added_regions.pop_back(); }},
      {"removed regions too few", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.removed_regions.pop_back(); }},
      {"region set with another id", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.region_sets[0].id += 1; }},
      {"region set of one polygon", StatusCode::kInvalidArgument,
       [](MeshDiff& d) {
         d.region_sets[0] = {7, {7}};
       }},
      {"region set out of order", StatusCode::kInvalidArgument,
       [](MeshDiff& d) {
         std::ranges::reverse(d.region_sets[0].polygons);
         d.region_sets[0].id = RegionIdOf(d.region_sets[0].polygons);
       }},
      {"region set twice", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.region_sets.insert(d.region_sets.begin(), d.region_sets[0]); }},
      {"subsegment to remove is absent", StatusCode::kDataLoss,
       [](MeshDiff& d) { d.removed_subsegments.owners[0] = 99; }},
      {"subsegment removed twice", StatusCode::kDataLoss,
       [](MeshDiff& d) { GoesTwice(d, d.removed_subsegments); }},
      {"subsegment added twice", StatusCode::kDataLoss,
       [](MeshDiff& d) { ComesTwice(d, d.added_subsegments); }},
      {"coordinate changed", StatusCode::kDataLoss,
       [](MeshDiff& d) { d.added_vertices.coordinates[0] += 1; }},
      {"owner changed", StatusCode::kDataLoss,
       [](MeshDiff& d) { d.added_vertices.owners[0] += 1; }},
      {"coordinates too few", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.added_vertices.coordinates.pop_back(); }},
      {"owners too few", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.added_vertices.owners.pop_back(); }},
      {"half a simplex added", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.added_simplices.pop_back(); }},
      {"half a simplex removed", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.removed_simplices.pop_back(); }},
      {"half a subsegment added", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.added_subsegments.ends.pop_back(); }},
      {"half a subsegment removed", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.removed_subsegments.ends.pop_back(); }},
      {"subfacet to remove is absent", StatusCode::kDataLoss,
       [](MeshDiff& d) { InSpace(d, [&] { d.removed_subfacets.owners[0] = 99; }); }},
      {"subfacet removed twice", StatusCode::kDataLoss,
       [](MeshDiff& d) { InSpace(d, [&] { GoesTwice(d, d.removed_subfacets); }); }},
      {"subfacet added twice", StatusCode::kDataLoss,
       [](MeshDiff& d) { InSpace(d, [&] { ComesTwice(d, d.added_subfacets); }); }},
      {"subfacet of another owner", StatusCode::kDataLoss,
       [](MeshDiff& d) { InSpace(d, [&] { d.added_subfacets.owners[0] += 1; }); }},
      {"part of a subfacet added", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.added_subfacets.corners.push_back(1); }},
      {"part of a subfacet removed", StatusCode::kInvalidArgument,
       [](MeshDiff& d) { d.removed_subfacets.corners.push_back(1); }},
      {"another dimension", StatusCode::kInvalidArgument,
       [](MeshDiff& d) {
         const int other = 5 - d.dimension;
         d = MeshDiff();
         d.dimension = other;
       }},
      {"no dimension", StatusCode::kInvalidArgument, [](MeshDiff& d) { d.dimension = -1; }},
  };
}

TEST(SlotMesh, RefusesAWrongDiffAndStaysAsItWas) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    const Mesh mesh = MakeUpLabelledMesh(random, 40, 7, dimension);
    const Mesh next = MakeUpLabelledMesh(random, 40, 8, dimension);
    const MeshDiff good = DiffMeshes(mesh, next);
    ASSERT_GE(good.removed_vertices.size(), 1U);
    auto store = SlotMesh::FromMesh(mesh);
    ASSERT_TRUE(store.ok());
    for (const Refusal& refusal : Refusals()) {
      MeshDiff bad = good;
      refusal.damage(bad);
      EXPECT_EQ(store->Apply(bad).code(), refusal.code) << refusal.name;
      EXPECT_TRUE(Identical(Sorted(store->ToMesh()), Sorted(mesh))) << refusal.name;
    }
    EXPECT_TRUE(store->Apply(good).ok());
    EXPECT_TRUE(Identical(Sorted(store->ToMesh()), Sorted(next)));
  }
}

TEST(SlotMesh, RefusesToAddWhatIsPresent) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    const Mesh mesh = MakeUpMesh(random, 20, 1, dimension);
    auto store = SlotMesh::FromMesh(mesh);
    ASSERT_TRUE(store.ok());
    // One kind of row at a time, even where the sum is right.
    const auto add_again = [&](auto keep) {
      Mesh part;
      part.dimension = dimension;
      keep(part);
      MeshDiff again;
      again.dimension = dimension;
      again.from_revision = 1;
      again.to_revision = 2;
      again.hash = mesh.hash;
      again.hash += ComputeHash(part);
      again.added_vertices = part.vertices;
      again.added_simplices = part.simplices;
      again.added_subsegments = part.subsegments;
      again.added_subfacets = part.subfacets;
      return store->Apply(again).code();
    };
    constexpr auto kRefused = absl::StatusCode::kDataLoss;
    EXPECT_EQ(add_again([&](Mesh& part) { part.vertices = mesh.vertices; }), kRefused);
    EXPECT_EQ(add_again([&](Mesh& part) { part.simplices = mesh.simplices; }), kRefused);
    EXPECT_EQ(add_again([&](Mesh& part) { part.subsegments = mesh.subsegments; }), kRefused);
    if (dimension == 2) continue;
    EXPECT_EQ(add_again([&](Mesh& part) { part.subfacets = mesh.subfacets; }), kRefused);
  }
}

TEST(SlotMesh, RefusesASnapshotThatIsNotWhatItsHashSays) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    Mesh mesh = MakeUpMesh(random, 20, 1, dimension);
    mesh.hash.hi ^= 4;
    EXPECT_EQ(SlotMesh::FromMesh(mesh).status().code(), absl::StatusCode::kDataLoss);
    mesh.hash = ComputeHash(mesh);
    mesh.vertices.owners.pop_back();
    EXPECT_EQ(SlotMesh::FromMesh(mesh).status().code(), absl::StatusCode::kInvalidArgument);
  }
}

TEST(SlotMesh, TakesAnEmptyDiffInPlace) {
  SlotMesh store;
  MeshDiff diff;
  EXPECT_TRUE(store.Apply(diff).ok());
  EXPECT_EQ(store.revision(), 0U);
}

TEST(ApplyDiff, LeavesTheMeshAloneOnRefusal) {
  auto random = MakeRandom();
  for (const int dimension : testing::kDimensions) {
    const Mesh before = MakeUpLabelledMesh(random, 40, 7, dimension);
    const MeshDiff good = DiffMeshes(before, MakeUpLabelledMesh(random, 40, 8, dimension));
    for (const Refusal& refusal : Refusals()) {
      MeshDiff bad = good;
      refusal.damage(bad);
      Mesh mesh = before;
      EXPECT_EQ(ApplyDiff(mesh, bad).code(), refusal.code) << refusal.name;
      EXPECT_TRUE(Identical(mesh, before)) << refusal.name;
    }
  }
}

}  // namespace
}  // namespace dynmesh::mesh_data
