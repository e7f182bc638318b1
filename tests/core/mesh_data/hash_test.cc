// Ids and hashes. The literal values come from a second implementation, in Python,
// of the specification in mesh.proto (tests/e2e/mesh_hash.py): they must never change.
#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <numeric>
#include <set>

#include "dynmesh/mesh.h"
#include "gtest/gtest.h"
#include "tests/core/mesh_data/made_up_mesh.h"

namespace dynmesh {
namespace {

TEST(VertexId, IsTheSpecifiedFunctionOfTheCoordinates) {
  const double origin[2] = {0, 0};
  const double p[2] = {1.5, -2.25};
  const double q[2] = {0.1, 1e300};
  const double r[3] = {1, 2, 3};
  EXPECT_EQ(VertexIdAt(origin, 2), 0x85f1b8a8f4424aecULL);
  EXPECT_EQ(VertexIdAt(p, 2), 0x465276cb41212f65ULL);
  EXPECT_EQ(VertexIdAt(p, 2, 1), 0xfa11a68c8325d6aeULL);
  EXPECT_EQ(VertexIdAt(q, 2), 0xd8cbbddba1abd57aULL);
  EXPECT_EQ(VertexIdAt(r, 3), 0xfd72f973012be66dULL);
  EXPECT_EQ(VertexIdAt(r, 3, 1), 0xb2de590772d26c1cULL);
}

TEST(VertexId, TakesMinusZeroForZero) {
  const double plus[2] = {0.0, 3};
  const double minus[2] = {-0.0, 3};
  EXPECT_EQ(VertexIdAt(plus, 2), VertexIdAt(minus, 2));
  EXPECT_EQ(HashVertex(plus, 2, 2, 0), HashVertex(minus, 2, 2, 0));
}

TEST(VertexId, TellsNeighbouringDoublesApart) {
  std::set<VertexId> ids;
  double x = 1;
  for (int i = 0; i < 100'000; ++i) {
    const double p[2] = {x, 1};
    ids.insert(VertexIdAt(p, 2));
    x = std::nextafter(x, 2);
  }
  EXPECT_EQ(ids.size(), 100'000U);
  EXPECT_FALSE(ids.contains(0));
}

TEST(Hash, IsTheSpecifiedFunctionOfThePart) {
  const double p[2] = {1.5, -2.25};
  EXPECT_EQ(HashVertex(p, 2, 0, 7).ToHex(), "382aa5a7a46968e76ed881181738ac45");
  const double q[2] = {-0.0, 0.5};
  EXPECT_EQ(HashVertex(q, 2, 2, 0).ToHex(), "3892a58ac923d032378e9e3d4a5c99e1");
  const double r[3] = {1, 2, 3};
  EXPECT_EQ(HashVertex(r, 3, 1, kBoxFeature).ToHex(), "a4a54c4b4eea740439d064eac8b862bf");
  const VertexId ids[4] = {11, 22, 33, 44};
  EXPECT_EQ(HashSimplex(ids, 3).ToHex(), "8fbdcb673d29a3033a4ba2e01b47f7c2");
  EXPECT_EQ(HashSimplex(ids, 4).ToHex(), "c39d05d9fffdd969d710bcce06e84d10");
  EXPECT_EQ(HashSimplex(ids, 3, 7).ToHex(), "0a53fac13bbd22ab6568984334ad242c");
  EXPECT_EQ(HashSimplex(ids, 4, 0xf889be9516f31dceULL).ToHex(), "70f1ac0a72fe1ad0f554d1d57f23aade");
  EXPECT_EQ(HashSubsegment(5, 9, 42).ToHex(), "0903ae292cb5db6f4c997770ec225837");
  EXPECT_EQ(HashSubfacet({5, 9, 11}, 42).ToHex(), "b50c056f616fd1d3e947a271d23e1e7b");
}

TEST(RegionId, IsTheSpecifiedFunctionOfThePolygons) {
  const auto id = [](std::vector<FeatureId> polygons) { return RegionIdOf(polygons); };
  EXPECT_EQ(id({}), kNoRegion);
  EXPECT_EQ(id({7}), 7U);
  EXPECT_EQ(id({7, 9}), 0xf889be9516f31dceULL);
  EXPECT_EQ(id({7, 9, 12}), 0xd68bb193bd4ef481ULL);
  EXPECT_EQ(id({1, kBoxFeature - 1}), 0xa0afad8fd57d2741ULL);
}

TEST(RegionId, LeadsToItsPolygons) {
  const std::vector<FeatureId> one = {7, 9}, other = {7, 9, 12};
  std::vector<RegionSet> sets = {{RegionIdOf(other), other}, {RegionIdOf(one), one}};
  ASSERT_LT(sets[0].id, sets[1].id);
  EXPECT_EQ(PolygonsOf(RegionIdOf(one), sets), one);
  EXPECT_EQ(PolygonsOf(RegionIdOf(other), sets), other);
  EXPECT_EQ(PolygonsOf(7, sets), std::vector<FeatureId>{7});
  EXPECT_EQ(PolygonsOf(kNoRegion, sets), std::vector<FeatureId>{});
}

TEST(Hash, OfASubsegmentDoesNotDependOnItsDirection) {
  EXPECT_EQ(HashSubsegment(9, 5, 42), HashSubsegment(5, 9, 42));
  EXPECT_NE(HashSubsegment(9, 5, 42), HashSubsegment(5, 9, 43));
}

TEST(Hash, OfASubfacetDoesNotDependOnTheOrderOfItsCorners) {
  const MeshHash hash = HashSubfacet({5, 9, 11}, 42);
  std::array<VertexId, 3> ids = {5, 9, 11};
  do {
    EXPECT_EQ(HashSubfacet({ids[0], ids[1], ids[2]}, 42), hash);
  } while (std::next_permutation(ids.begin(), ids.end()));
  EXPECT_NE(HashSubfacet({5, 9, 11}, 43), hash);
  EXPECT_NE(HashSubfacet({5, 9, 12}, 42), hash);
}

TEST(Hash, TellsASubfacetFromATriangleInARegionAndFromASubsegment) {
  const VertexId ids[3] = {5, 9, 11};
  EXPECT_NE(HashSubfacet({5, 9, 11}, 42), HashSimplex(ids, 3, 42));
  EXPECT_NE(HashSubfacet({5, 9, 11}, 42), HashSubsegment(5, 9, 11));
}

TEST(Hash, ChangesInHalfOfItsBitsWhenOneBitOfAVertexChanges) {
  auto random = testing::MakeRandom();
  double flips[128] = {};
  constexpr int kRounds = 4000;
  for (int round = 0; round < kRounds; ++round) {
    std::uint64_t bits = 0x3ff0000000000000ULL | random() >> 12;
    const double p[2] = {std::bit_cast<double>(bits), 0.5};
    bits ^= std::uint64_t{1} << (random() % 52);
    const double q[2] = {std::bit_cast<double>(bits), 0.5};
    const MeshHash a = HashVertex(p, 2, 2, 0);
    const MeshHash b = HashVertex(q, 2, 2, 0);
    for (int i = 0; i < 64; ++i) {
      flips[i] += static_cast<double>((a.hi ^ b.hi) >> i & 1);
      flips[64 + i] += static_cast<double>((a.lo ^ b.lo) >> i & 1);
    }
  }
  for (const double f : flips) EXPECT_NEAR(f / kRounds, 0.5, 0.06);  // 7 standard deviations
}

TEST(Hash, OfAMeshDoesNotDependOnTheOrderOfItsRows) {
  auto random = testing::MakeRandom();
  for (const int dimension : testing::kDimensions) {
    const Mesh mesh = testing::MakeUpMesh(random, 50, 1, dimension);
    Mesh shuffled = mesh;
    const auto d = static_cast<std::size_t>(dimension);
    std::vector<std::size_t> order(mesh.vertices.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), random);
    for (std::size_t i = 0; i < order.size(); ++i) {
      const std::size_t from = order[i];
      shuffled.vertices.ids[i] = mesh.vertices.ids[from];
      std::copy_n(&mesh.vertices.coordinates[d * from], d, &shuffled.vertices.coordinates[d * i]);
      shuffled.vertices.containing_dimensions[i] = mesh.vertices.containing_dimensions[from];
      shuffled.vertices.owners[i] = mesh.vertices.owners[from];
    }
    ASSERT_NE(shuffled.vertices.ids, mesh.vertices.ids);
    // Rows and, in each, ids backwards.
    for (auto* column : {&shuffled.subsegments.ends, &shuffled.subsegments.owners,
                         &shuffled.subfacets.corners, &shuffled.subfacets.owners}) {
      std::reverse(column->begin(), column->end());
    }
    EXPECT_EQ(ComputeHash(shuffled), mesh.hash);
    shuffled.hash = mesh.hash;
    Mesh a = mesh;
    Canonicalize(a);
    Canonicalize(shuffled);
    EXPECT_TRUE(testing::Identical(a, shuffled));
  }
}

TEST(Hash, OfAMeshChangesWithEveryPart) {
  auto random = testing::MakeRandom();
  for (const int dimension : testing::kDimensions) {
    const Mesh mesh = testing::MakeUpMesh(random, 20, 1, dimension);
    Mesh other = mesh;
    other.vertices.owners[3] += 1;
    EXPECT_NE(ComputeHash(other), mesh.hash);
    other = mesh;
    other.vertices.containing_dimensions[3] ^= 1;
    EXPECT_NE(ComputeHash(other), mesh.hash);
    other = mesh;
    other.vertices.coordinates[5] = 0.123;
    EXPECT_NE(ComputeHash(other), mesh.hash);
    other = mesh;
    std::swap(other.simplices[1], other.simplices[2]);
    EXPECT_NE(ComputeHash(other), mesh.hash);
    other = mesh;
    other.subsegments.owners[0] += 1;
    EXPECT_NE(ComputeHash(other), mesh.hash);
    if (dimension == 3) {
      other = mesh;
      other.subfacets.owners[0] += 1;
      EXPECT_NE(ComputeHash(other), mesh.hash);
      other = mesh;
      other.subfacets.corners[1] += 1;
      EXPECT_NE(ComputeHash(other), mesh.hash);
    }
    other = mesh;
    other.regions.assign(other.simplex_count(), kNoRegion);  // without information
    EXPECT_EQ(ComputeHash(other), mesh.hash);
    other.regions[5] = 3;
    EXPECT_NE(ComputeHash(other), mesh.hash);
    other = mesh;
    other.revision = 77;  // no part of the mesh
    EXPECT_EQ(ComputeHash(other), mesh.hash);
  }
}

// The two meshes of proto/dynmesh/v1/mesh.proto; tests/e2e/mesh_hash.py also computes their hashes.
TEST(Hash, OfTheMeshesInTheProtoIsWhatItSays) {
  Mesh plane;
  plane.dimension = 2;
  const double places[][2] = {{0, 0}, {1, 0}, {0, 1}, {0.5, -0.0}};
  for (const auto& p : places) {
    plane.vertices.ids.push_back(VertexIdAt(p, 2));
    plane.vertices.coordinates.insert(plane.vertices.coordinates.end(), p, p + 2);
  }
  plane.vertices.containing_dimensions = {0, 0, 0, 1};
  plane.vertices.owners = {1, 2, 3, 4};
  const auto id = [&](std::size_t i) { return plane.vertices.ids[i]; };
  plane.simplices = {id(2), id(0), id(3), id(1), id(2), id(3)};
  const std::vector<FeatureId> both = {7, 9};
  plane.regions = {RegionIdOf(both), 7};
  plane.subsegments.ends = {id(0), id(3), id(1), id(3)};
  plane.subsegments.owners = {4, 4};
  EXPECT_EQ(ComputeHash(plane).ToHex(), "5ad29ad96e559f27c02d86611221fbc6");

  Mesh space;
  space.dimension = 3;
  const double corners[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.25, 0.25, -1.5}};
  for (const auto& p : corners) {
    space.vertices.ids.push_back(VertexIdAt(p, 3));
    space.vertices.coordinates.insert(space.vertices.coordinates.end(), p, p + 3);
  }
  space.vertices.containing_dimensions = {0, 0, 0, 0, 3};
  space.vertices.owners = {1, 2, 3, 4, 0};
  const auto at = [&](std::size_t i) { return space.vertices.ids[i]; };
  space.simplices = {at(0), at(2), at(3), at(1), at(0), at(4), at(2), at(1)};
  space.regions = {20, 0};
  space.subsegments.ends = {at(0), at(1), at(1), at(2), at(2), at(0)};
  space.subsegments.owners = {20, 20, 20};
  space.subfacets.corners = {at(0), at(1), at(2)};
  space.subfacets.owners = {20};
  EXPECT_EQ(ComputeHash(space).ToHex(), "1d85220eb926333326933084c857d4e2");
}

TEST(Hash, HexReadsBack) {
  const MeshHash hash{0x0123456789abcdefULL, 0xfULL};
  EXPECT_EQ(hash.ToHex(), "0123456789abcdef000000000000000f");
  EXPECT_EQ(MeshHash::FromHex(hash.ToHex()).value(), hash);
  EXPECT_EQ(MeshHash::FromHex("0123456789ABCDEF000000000000000F").value(), hash);
}

TEST(Hash, HexOfAnotherFormIsRefused) {
  for (const char* bad : {"", "0", "0123456789abcdef000000000000000",
                          "0x23456789abcdef000000000000000f", "0123456789abcdef000000000000000f0",
                          "g123456789abcdef000000000000000f", "0123456789abcdef 00000000000000f"}) {
    EXPECT_EQ(MeshHash::FromHex(bad).status().code(), absl::StatusCode::kInvalidArgument) << bad;
  }
}

}  // namespace
}  // namespace dynmesh
