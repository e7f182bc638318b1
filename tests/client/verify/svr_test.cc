// SVR of points, segments, polygons and sizing features: the verifier of mesh files, which shares
// no code with a mesher, finds no fault; and the mesh is a function of the set of features.
//
// DYNMESH_NIGHTLY=1 runs more and larger inputs.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <unordered_map>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "tests/support/judged.h"
#include "tests/support/nightly.h"
#include "tests/support/polygon_script.h"
#include "tests/support/workload.h"

namespace dynmesh::test::svr_test {
namespace {

absl::StatusOr<Mesh> BySvr(const std::vector<Feature>& features, const MeshOptions& options) {
  BuildOptions build;
  build.engine = BuildEngine::kSvr;
  return BuildMesh(features, options, build);
}

MeshOptions OptionsIn(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  return options;
}

// The same features under other ids, in another order.
std::vector<Feature> Renamed(std::vector<Feature> features, std::uint64_t seed) {
  std::vector<FeatureId> ids;
  for (const Feature& f : features) ids.push_back(f.id);
  std::mt19937_64 bits(seed);
  std::shuffle(ids.begin(), ids.end(), bits);
  std::unordered_map<FeatureId, FeatureId> to;
  for (std::size_t i = 0; i < ids.size(); ++i) to[features[i].id] = ids[i];
  for (Feature& f : features) {
    f.id = to.at(f.id);
    if (f.kind == FeatureKind::kSegment) f.ends = {to.at(f.ends[1]), to.at(f.ends[0])};
    for (auto& ring : f.rings) {
      for (FeatureId& id : ring) id = to.at(id);
    }
  }
  std::shuffle(features.begin(), features.end(), bits);
  return features;
}

// Positions of the vertices, ascending.
std::vector<std::array<double, 3>> PositionsOf(const Mesh& mesh) {
  std::vector<std::array<double, 3>> all(mesh.vertices.size());
  const auto d = static_cast<std::size_t>(mesh.dimension);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = 0; k < d; ++k) all[i][k] = mesh.vertices.coordinates[d * i + k];
  }
  std::sort(all.begin(), all.end());
  return all;
}

void ExpectGood(const std::vector<Feature>& features, const MeshOptions& options) {
  const auto mesh = BySvr(features, options);
  ASSERT_TRUE(mesh.ok()) << mesh.status() << "\n" << features.size() << " features";
  EXPECT_EQ(Judged(*mesh, options.quality, features), "");
  const auto renamed = BySvr(Renamed(features, 7), options);
  ASSERT_TRUE(renamed.ok()) << renamed.status();
  EXPECT_EQ(PositionsOf(*mesh), PositionsOf(*renamed));
}

class SvrOfWorkload : public ::testing::TestWithParam<Distribution> {};

TEST_P(SvrOfWorkload, IsGoodAndAFunctionOfTheSet) {
  const Distribution distribution = GetParam();
  const int runs = IsNightly() ? 40 : 2;
  for (const int n : IsNightly() ? std::vector<int>{5, 30, 200, 1000} : std::vector<int>{5, 60}) {
    for (int run = 0; run < runs; ++run) {
      const auto seed = static_cast<std::uint64_t>(1000 * n + run);
      std::vector<Feature> features = MakeFeatures(distribution, n, seed);
      // Grids may extend beyond the unit cube. They have no features but points.
      std::erase_if(features, [](const Feature& f) {
        return f.kind == FeatureKind::kPoint && std::ranges::max(f.position) > 1;
      });
      MeshOptions options = OptionsIn(DimensionOf(distribution));
      if (run % 2 == 1) options.quality *= 1.5;
      SCOPED_TRACE(NameOf(distribution) + ", n " + std::to_string(n) + ", seed " +
                   std::to_string(seed));
      ExpectGood(features, options);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(In2D, SvrOfWorkload, ::testing::ValuesIn(kAllDistributions),
                         [](const auto& d) { return NameOf(d.param); });
INSTANTIATE_TEST_SUITE_P(In3D, SvrOfWorkload, ::testing::ValuesIn(kSpaceDistributions),
                         [](const auto& d) { return NameOf(d.param); });

class SvrOfPolygons : public ::testing::TestWithParam<PolygonKind> {};

TEST_P(SvrOfPolygons, IsGoodAndAFunctionOfTheSet) {
  const int scripts = IsNightly() ? 20 : 2, steps = IsNightly() ? 20 : 4;
  for (int script = 0; script < scripts; ++script) {
    const auto seed = static_cast<std::uint64_t>(300 + script);
    const int solids = 1 + 3 * (script % 3);
    SCOPED_TRACE(NameOf(GetParam()) + ", solids " + std::to_string(solids) + ", seed " +
                 std::to_string(seed));
    PolygonScript polygons(GetParam(), solids, seed);
    const MeshOptions options = OptionsIn(3);
    auto features = DynamicMesh::Create(options);
    ASSERT_TRUE(features.ok());
    for (int step = 0; step < steps; ++step) {
      // What it proposes may be refused.
      (void)(*features)->Apply(polygons.Next((*features)->Features()));
      if (step % 2 == 1) ExpectGood((*features)->Features(), options);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(All, SvrOfPolygons, ::testing::ValuesIn(kPolygonKinds),
                         [](const auto& kind) { return NameOf(kind.param); });

TEST(SvrOfSizes, MaxEdgeBoundsAllEdges) {
  for (const int dimension : {2, 3}) {
    MeshOptions options = OptionsIn(dimension);
    options.max_edge = dimension == 2 ? 0.05 : 0.2;
    std::vector<Feature> features = MakeFeatures(
        dimension == 2 ? Distribution::kSegmentsAxis : Distribution::kGridEdges, 20, 3);
    ExpectGood(features, options);
    const auto mesh = BySvr(features, options);
    const auto coarse = BySvr(features, OptionsIn(dimension));
    ASSERT_TRUE(mesh.ok() && coarse.ok());
    EXPECT_GT(mesh->vertices.size(), coarse->vertices.size());
  }
}

}  // namespace
}  // namespace dynmesh::test::svr_test
