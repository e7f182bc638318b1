// A proof of validity saves a build the validation of those features, and of no others.
#include "dynmesh/valid_features.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "tests/support/point_layouts.h"

namespace dynmesh::valid_features_test {
namespace {

MeshOptions OptionsIn(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  options.min_dihedral = DefaultMinDihedral(dimension);
  return options;
}

// A box of six squares, with points around it.
std::vector<Feature> Box() {
  std::vector<Feature> features;
  for (std::uint64_t i = 0; i < 8; ++i) {
    features.push_back(Feature::Point(i + 1, (i & 1) != 0 ? 0.7 : 0.3, (i & 2) != 0 ? 0.7 : 0.3,
                                      (i & 4) != 0 ? 0.7 : 0.3));
  }
  const std::vector<std::vector<FeatureId>> squares = {{1, 2, 4, 3}, {5, 6, 8, 7}, {1, 2, 6, 5},
                                                       {3, 4, 8, 7}, {1, 3, 7, 5}, {2, 4, 8, 6}};
  FeatureId id = 10;
  for (const auto& square : squares) features.push_back(Feature::Polygon(id++, {square}));
  return features;
}

std::vector<Feature> Points(int dimension) {
  std::vector<Feature> features;
  const auto add = [&](double x, double y, double z) {
    features.push_back(Feature::Point(features.size() + 1, x, y, z));
  };
  if (dimension == 2) {
    for (const auto& p : test::PointsOf<2>(test::Layout::kUniform, 300, 3)) add(p[0], p[1], 0);
  } else {
    for (const auto& p : test::PointsOf<3>(test::Layout::kUniform, 300, 3)) add(p[0], p[1], p[2]);
  }
  features.push_back(Feature::Segment(1000, 1, 2));
  return features;
}

BuildOptions With(std::shared_ptr<const ValidFeatures> valid) {
  BuildOptions build;
  build.valid = std::move(valid);
  return build;
}

// How often a build looks whether it is to be given up while it validates.
std::uint64_t PollsOfValidation(const std::vector<Feature>& features, const MeshOptions& options,
                                std::shared_ptr<const ValidFeatures> valid) {
  BuildOptions build = With(std::move(valid));
  std::uint64_t polls = 0, validating = 0;
  bool is_validating = false;
  build.interrupted = [&] {
    ++polls;
    validating += is_validating;
    return false;
  };
  build.progress = [&](const ApplyProgress& p) {
    is_validating = p.stage == ApplyProgress::Stage::kValidate;
  };
  EXPECT_TRUE(BuildMesh(features, options, build).ok());
  EXPECT_GT(polls, validating);
  return validating;
}

TEST(ValidFeatures, BuildsOfAllKindsAreTheSameWithTheProof) {
  for (const int dimension : {2, 3}) {
    for (const MeshKind kind :
         {MeshKind::kDelaunay, MeshKind::kQuadtree, MeshKind::kTriangulation}) {
      if (kind == MeshKind::kTriangulation && dimension == 3) continue;
      SCOPED_TRACE(std::to_string(dimension) + " " + std::string(NameOf(kind)));
      MeshOptions options = OptionsIn(dimension);
      options.kind = kind;
      if (kind == MeshKind::kQuadtree) options.min_dihedral = 0;
      const std::vector<Feature> features = Points(dimension);
      const auto valid = ValidFeatures::Of(features, options);
      ASSERT_TRUE(valid.ok()) << valid.status();
      const auto expected = BuildMesh(features, options);
      const auto mesh = BuildMesh(features, options, With(*valid));
      ASSERT_TRUE(expected.ok() && mesh.ok()) << expected.status() << mesh.status();
      EXPECT_EQ(mesh->hash, expected->hash);
      EXPECT_EQ(mesh->revision, expected->revision);
    }
  }
  const auto valid = ValidFeatures::Of(Box(), OptionsIn(3));
  ASSERT_TRUE(valid.ok()) << valid.status();
  EXPECT_EQ(BuildMesh(Box(), OptionsIn(3), With(*valid))->hash,
            BuildMesh(Box(), OptionsIn(3))->hash);
}

TEST(ValidFeatures, AreNotValidatedAgain) {
  const MeshOptions options = OptionsIn(3);
  const std::vector<Feature> features = Points(3);
  const auto valid = ValidFeatures::Of(features, options);
  ASSERT_TRUE(valid.ok()) << valid.status();
  const std::uint64_t before = PollsOfValidation(features, options, nullptr);
  EXPECT_GE(before, features.size());
  EXPECT_LT(PollsOfValidation(features, options, *valid), features.size());
  // No rule is about dihedral angles.
  MeshOptions other = options;
  other.min_dihedral = 5;
  EXPECT_LT(PollsOfValidation(features, other, *valid), features.size());
  // What is proved of other features is no proof.
  std::vector<Feature> moved = features;
  moved[0].position[1] += 1e-3;
  EXPECT_GE(PollsOfValidation(moved, options, *valid), features.size());
}

TEST(ValidFeatures, AProofOfOthersLetsNothingThrough) {
  const MeshOptions options = OptionsIn(3);
  const std::vector<Feature> features = Box();
  const auto valid = ValidFeatures::Of(features, options);
  ASSERT_TRUE(valid.ok()) << valid.status();
  const auto expect = [&](const std::vector<Feature>& given, const MeshOptions& with) {
    EXPECT_FALSE((*valid)->Proves(given, with));
    const auto expected = BuildMesh(given, with), mesh = BuildMesh(given, with, With(*valid));
    ASSERT_FALSE(expected.ok());
    EXPECT_EQ(mesh.status(), expected.status());
  };
  std::vector<Feature> given = features;
  given[0].position = given[1].position;
  expect(given, options);
  given = features;
  given[3].position[2] = 0.31;  // not flat
  expect(given, options);
  given = features;
  given.push_back(features.back());  // an id twice
  expect(given, options);
  given = features;
  given.erase(given.begin());  // a corner that is not there
  expect(given, options);
  given = features;
  given.back().rings[0].push_back(99);
  expect(given, options);
  given = features;
  given.push_back(Feature::Point(50, 0.5, 0.5, 0.3));  // on a polygon
  expect(given, options);
  given = features;
  FeatureLabel label;
  label.name = std::string("\xff");  // no text
  given[0].label = label;
  expect(given, options);

  MeshOptions other = options;
  other.quality = 1.3;  // too low for polygons
  expect(features, other);
  other = options;
  other.box.hi[0] = 0.6;
  expect(features, other);
  other = options;
  other.kind = MeshKind::kQuadtree;
  other.limits.max_vertices = 9;
  other.min_dihedral = 0;
  expect(features, other);
  other = options;
  other.limits.max_vertices = 100;
  expect(features, other);
  other = options;
  other.dimension = 4;
  expect(features, other);
}

TEST(ValidFeatures, AreRefusedAsByAMesh) {
  std::vector<Feature> given = Box();
  given.push_back(Feature::Point(50, 0.5, 0.5, 0.3));
  const MeshOptions options = OptionsIn(3);
  const auto valid = ValidFeatures::Of(given, options);
  EXPECT_EQ(valid.status(), BuildMesh(given, options).status());
  EXPECT_EQ(GetErrorDetail(valid.status())->reason, reason::kPointOnPolygon);
  MeshOptions other = options;
  other.quality = -1;
  EXPECT_EQ(GetErrorDetail(ValidFeatures::Of(Box(), other).status())->reason, reason::kBadOption);
  other = options;
  other.max_edge = 1e-6;
  EXPECT_EQ(ValidFeatures::Of(Box(), other).status(), BuildMesh(Box(), other).status());
  // None is no reason to refuse.
  EXPECT_TRUE((*ValidFeatures::Of({}, options))->Proves({}, options));
}

}  // namespace
}  // namespace dynmesh::valid_features_test
