// Owners that are found by places alone are those that the mesher knows.
#include "client/verify/owners.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/io/meshes/indexed_mesh.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/support/polygon_script.h"
#include "tests/support/workload.h"

namespace dynmesh::cli::owners_test {
namespace {

using test::Distribution, test::PolygonKind;

MeshOptions OptionsIn(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  return options;
}

// What the mesher says, without the domain box.
io::IndexedMesh WithoutBox(io::IndexedMesh mesh) {
  for (auto& v : mesh.vertices) {
    if (v.owner != kBoxFeature) continue;
    v.owner = kNoFeature;
    v.containing_dimension = mesh.dimension;
  }
  for (auto& e : mesh.edges) e.owner = e.owner == kBoxFeature ? kNoFeature : e.owner;
  for (auto& f : mesh.faces) f.owner = f.owner == kBoxFeature ? kNoFeature : f.owner;
  return mesh;
}

// Returns how many rows have an owner.
std::size_t ExpectFound(const std::vector<Feature>& features, const Mesh& mesh) {
  const auto indexed = io::IndexMesh(mesh);
  EXPECT_TRUE(indexed.ok()) << indexed.status();
  const io::IndexedMesh known = WithoutBox(*indexed);
  io::IndexedMesh found = known;
  FindOwners(features, found);
  std::size_t owned = 0;
  for (std::size_t v = 0; v < known.vertices.size(); ++v) {
    EXPECT_EQ(found.vertices[v].owner, known.vertices[v].owner) << "vertex " << v;
    EXPECT_EQ(found.vertices[v].containing_dimension, known.vertices[v].containing_dimension)
        << "vertex " << v;
  }
  for (std::size_t e = 0; e < known.edges.size(); ++e) {
    EXPECT_EQ(found.edges[e].owner, known.edges[e].owner) << "edge " << e;
    owned += known.edges[e].owner != kNoFeature;
  }
  for (std::size_t f = 0; f < known.faces.size(); ++f) {
    EXPECT_EQ(found.faces[f].owner, known.faces[f].owner) << "face " << f;
    owned += known.faces[f].owner != kNoFeature;
  }
  return owned;
}

class OwnersOfWorkload : public ::testing::TestWithParam<Distribution> {};

TEST_P(OwnersOfWorkload, AreThoseOfTheMesher) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    std::vector<Feature> features = test::MakeFeatures(GetParam(), 60, seed);
    // Grids may extend beyond the unit cube. They have no features but points.
    std::erase_if(features, [](const Feature& f) {
      return f.kind == FeatureKind::kPoint && std::ranges::max(f.position) > 1;
    });
    const auto mesh = BuildMesh(features, OptionsIn(test::DimensionOf(GetParam())));
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    ExpectFound(features, *mesh);
  }
}
INSTANTIATE_TEST_SUITE_P(In2D, OwnersOfWorkload, ::testing::ValuesIn(test::kAllDistributions),
                         [](const auto& d) { return NameOf(d.param); });
INSTANTIATE_TEST_SUITE_P(In3D, OwnersOfWorkload, ::testing::ValuesIn(test::kSpaceDistributions),
                         [](const auto& d) { return NameOf(d.param); });

class OwnersOfPolygons : public ::testing::TestWithParam<PolygonKind> {};

TEST_P(OwnersOfPolygons, AreThoseOfTheMesher) {
  std::size_t owned = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    const auto mesh = DynamicMesh::Create(OptionsIn(3));
    ASSERT_TRUE(mesh.ok());
    test::PolygonScript script(GetParam(), 6, seed);
    // What it proposes may be refused.
    for (int step = 0; step < 5; ++step) (void)(*mesh)->Apply(script.Next((*mesh)->Features()));
    owned += ExpectFound((*mesh)->Features(), (*mesh)->Snapshot());
  }
  EXPECT_GT(owned, 50U);
}
INSTANTIATE_TEST_SUITE_P(All, OwnersOfPolygons, ::testing::ValuesIn(test::kPolygonKinds),
                         [](const auto& kind) { return NameOf(kind.param); });

}  // namespace
}  // namespace dynmesh::cli::owners_test
