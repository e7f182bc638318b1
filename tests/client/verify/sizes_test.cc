// `verify` of meshes with sizing features: what the mesher makes passes, what is too coarse does
// not.
#include <string>
#include <vector>

#include "client/verify/verify_internal.h"
#include "dynmesh/dynamic_mesh.h"
#include "gtest/gtest.h"
#include "tests/client/verify/good_mesh.h"
#include "tests/client/verify/report_text.h"
#include "tests/support/workload.h"

namespace dynmesh::cli::sizes_test {
namespace {

using test::Distribution;

std::uint64_t FailuresOf(const io::IndexedMesh& mesh, const std::vector<Feature>& features) {
  return CheckSizes(mesh, features).failures;
}

// Triangles of the unit grid from 1 to 4: their longest edge is sqrt 2, as a target of 1 allows.
TEST(VerifySizes, FindsATriangleThatIsTooLargeForEachShape) {
  const testing::GoodMesh grid = testing::MakeGridMesh(4);
  const std::vector<Feature>& points = grid.features;
  const Rings ring = {{points[0].id, points[3].id, points[15].id, points[12].id}};
  const auto shapes = [&](double target) {
    return std::vector<Feature>{
        Feature::SizeAt(900, 2.3, 2.4, target),
        Feature::SizeDisc(901, 2.5, 2.5, 0.2, target),
        Feature::SizeBox(902, 2.2, 2.1, 2.3, 2.9, target),
        Feature::SizeBox(903, 1.5, 1.5, 3.5, 3.5, target),
        Feature::SizePolygon(904, ring, target),
        Feature::SizeCapsule(905, {{1.5, 1.5}, {3.5, 3.5}, {3.5, 2}}, 0.01, target),
    };
  };
  for (const Feature& size : shapes(1)) {
    std::vector<Feature> features = points;
    features.push_back(size);
    EXPECT_EQ(FailuresOf(grid.files.mesh, features), 0u) << size.id;
  }
  for (const Feature& size : shapes(0.9)) {
    std::vector<Feature> features = points;
    features.push_back(size);
    EXPECT_GT(FailuresOf(grid.files.mesh, features), 0u) << size.id;
    const VerifyReport report = VerifyMesh(grid.files, 1e9, &features);
    EXPECT_EQ(FailedChecks(report), std::set<std::string>{"sizes"});
  }
}

// A disc counts the triangles that it meets, not those that its box does.
TEST(VerifySizes, CountsWhatMeetsARegionOnly) {
  io::IndexedMesh mesh;
  mesh.vertices.resize(3);
  mesh.vertices[1].x = 1;
  mesh.vertices[2].y = 1;
  mesh.triangles = {{0, 1, 2}};
  const auto failures = [&](const Feature& size) { return FailuresOf(mesh, {size}); };
  EXPECT_EQ(failures(Feature::SizeDisc(1, 1, 1, 0.70, 0.1)), 0u);  // sqrt 1/2 away
  EXPECT_EQ(failures(Feature::SizeDisc(1, 1, 1, 0.71, 0.1)), 1u);
  EXPECT_EQ(failures(Feature::SizeDisc(1, 0.3, 0.3, 0.01, 0.1)), 1u);
  EXPECT_EQ(failures(Feature::SizeAt(1, 0.3, 0.3, 0.1)), 1u);
  EXPECT_EQ(failures(Feature::SizeAt(1, 0.6, 0.6, 0.1)), 0u);
  EXPECT_EQ(failures(Feature::SizeAt(1, 0, 0, 0.1)), 0u);  // touches
  EXPECT_EQ(failures(Feature::SizeBox(1, 0.6, 0.6, 2, 2, 0.1)), 0u);
  EXPECT_EQ(failures(Feature::SizeBox(1, -1, 0.4, 2, 0.5, 0.1)), 1u);
  EXPECT_EQ(failures(Feature::SizeBox(1, -1, -1, 2, 2, 0.1)), 1u);
  EXPECT_EQ(failures(Feature::SizeBox(1, -1, -1, 2, 2, 1)), 0u);
  EXPECT_EQ(failures(Feature::SizeCapsule(1, {{2, 0}, {0, 2}}, 0.70, 0.1)), 0u);
  EXPECT_EQ(failures(Feature::SizeCapsule(1, {{2, 0}, {0, 2}}, 0.71, 0.1)), 1u);
  EXPECT_EQ(failures(Feature::SizeCapsule(1, {{2, 2}, {2, 0}, {0, 2}}, 0.71, 0.1)), 1u);
  EXPECT_EQ(failures(Feature::SizeCapsule(1, {{-1, 0.5}, {2, 0.5}}, 1e-6, 0.1)), 1u);
  EXPECT_EQ(failures(Feature::SizeCapsule(1, {{0.3, 0.3}, {0.3, 0.4}}, 1e-6, 0.1)), 1u);
  EXPECT_EQ(failures(Feature::SizeCapsule(1, {{0.3, 0.3}, {0.3, 0.4}}, 0, 0.1)), 1u);
  // One vertex of many.
  Path zigzag;
  for (int i = 0; i < 200; ++i) zigzag.push_back({2, i % 2 == 0 ? 2.0 : 3.0});
  EXPECT_EQ(failures(Feature::SizeCapsule(1, zigzag, 1e-6, 0.1)), 0u);
  for (const std::size_t i : {0, 1, 63, 64, 65, 127, 128, 198, 199}) {
    Path path = zigzag;
    path[i] = {0.3, 0.3};
    EXPECT_EQ(failures(Feature::SizeCapsule(1, path, 1e-6, 0.1)), 1u) << i;
  }
}

TEST(VerifySizes, CountsWhatMeetsARegionOnlyIn3D) {
  io::IndexedMesh mesh;
  mesh.dimension = 3;
  mesh.vertices.resize(4);
  mesh.vertices[1].x = 1;
  mesh.vertices[2].y = 1;
  mesh.vertices[3].z = 1;
  mesh.tetrahedra = {{0, 1, 2, 3}};
  const auto failures = [&](const std::array<double, 3>& at, const Sizing& sizing) {
    return FailuresOf(mesh, {Feature::Size(1, at, sizing)});
  };
  EXPECT_EQ(failures({1, 1, 1}, {SizeShape::kDisc, 0.1, 1.15, {}}), 0u);  // 2 / sqrt 3 away
  EXPECT_EQ(failures({1, 1, 1}, {SizeShape::kDisc, 0.1, 1.16, {}}), 1u);
  EXPECT_EQ(failures({0.2, 0.2, 0.2}, {SizeShape::kPoint, 0.1, 0, {}}), 1u);
  EXPECT_EQ(failures({0.4, 0.4, 0.4}, {SizeShape::kPoint, 0.1, 0, {}}), 0u);
  EXPECT_EQ(failures({0.4, 0.4, 0.4}, {SizeShape::kBox, 0.1, 0, {1, 1, 1}}), 0u);
  EXPECT_EQ(failures({0.3, 0.3, 0.3}, {SizeShape::kBox, 0.1, 0, {1, 1, 1}}), 1u);
  EXPECT_EQ(failures({-1, 0.1, 0.1}, {SizeShape::kBox, 0.1, 0, {2, 0.2, 0.2}}), 1u);
  EXPECT_EQ(failures({-1, -1, 0.1}, {SizeShape::kBox, 0.1, 0, {2, 2, 0.2}}), 1u);
  const auto along = [&](const Path& path, double radius) {
    return FailuresOf(mesh, {Feature::SizeCapsule(1, path, radius, 0.1)});
  };
  EXPECT_EQ(along({{-1, 0.2, 0.2}, {2, 0.2, 0.2}}, 1e-6), 1u);  // through two faces
  EXPECT_EQ(along({{-1, -1, -1}, {-1, 0.2, 0.2}, {2, 0.2, 0.2}}, 1e-6), 1u);
  EXPECT_EQ(along({{0.2, 0.2, 0.2}, {0.3, 0.2, 0.2}}, 1e-6), 1u);  // inside
  EXPECT_EQ(along({{2, 0, 1}, {0, 2, 1}}, 1.15), 0u);              // beside an edge: 2 / sqrt 3
  EXPECT_EQ(along({{2, 0, 1}, {0, 2, 1}}, 1.16), 1u);
}

class MeshOfSizes : public ::testing::TestWithParam<Distribution> {};

TEST_P(MeshOfSizes, ObeysThem) {
  const int dimension = DimensionOf(GetParam());
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    MeshOptions options;
    options.dimension = dimension;
    options.quality = DefaultQuality(dimension);
    std::vector<Feature> features = test::MakeFeatures(GetParam(), 60, seed);
    const absl::StatusOr<Mesh> mesh = BuildMesh(features, options);
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    const absl::StatusOr<io::IndexedMesh> indexed = io::IndexMesh(*mesh);
    ASSERT_TRUE(indexed.ok());
    const VerifyCheck check = CheckSizes(*indexed, features);
    EXPECT_EQ(check.failures, 0u) << "seed " << seed << ": " << check.examples.front();
    for (Feature& f : features) {
      if (f.kind != FeatureKind::kSize) continue;
      std::vector<Feature> finer = features;
      finer[static_cast<std::size_t>(&f - features.data())].sizing.target /= 8;
      EXPECT_GT(FailuresOf(*indexed, finer), 0u) << "seed " << seed << ", size " << f.id;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, MeshOfSizes,
                         ::testing::Values(Distribution::kSized, Distribution::kPolygons,
                                           Distribution::kCapsules, Distribution::kSpaceSized,
                                           Distribution::kSpaceCapsules),
                         [](const auto& row) { return NameOf(row.param); });

}  // namespace
}  // namespace dynmesh::cli::sizes_test
