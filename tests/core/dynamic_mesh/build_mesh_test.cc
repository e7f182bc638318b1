// BuildMesh: its engines, limits, interrupts and progress.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "dynmesh/quality.h"
#include "tests/support/point_layouts.h"

namespace dynmesh::build_mesh_test {
namespace {

MeshOptions OptionsIn(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  return options;
}

template <int D>
std::vector<Feature> PointFeatures(test::Layout layout, int n) {
  std::vector<Feature> features;
  for (const auto& p : test::PointsOf<D>(layout, n, 3)) {
    features.push_back(Feature::Point(features.size() + 1, p[0], p[1], D == 3 ? p[D - 1] : 0));
  }
  return features;
}

BuildOptions BySvr() {
  BuildOptions build;
  build.engine = BuildEngine::kSvr;
  return build;
}

template <int D>
void ExpectGoodMesh(test::Layout layout, int n) {
  SCOPED_TRACE(std::string(NameOf(layout)) + " in " + std::to_string(D) + "D");
  std::vector<Feature> features = PointFeatures<D>(layout, n);
  const MeshOptions options = OptionsIn(D);
  const auto mesh = BuildMesh(features, options, BySvr());
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->hash, ComputeHash(*mesh));
  EXPECT_EQ(mesh->revision, features.empty() ? 0u : 1u);
  const QualityReport quality = MeasureQuality(*mesh, options);
  EXPECT_EQ(quality.over_rho, 0u);
  EXPECT_EQ(quality.exempt, 0u);
  // Every point is a vertex with its id.
  std::set<FeatureId> owners;
  for (std::size_t i = 0; i < mesh->vertices.size(); ++i) {
    const FeatureId owner = mesh->vertices.owners[i];
    if (owner == kNoFeature || owner == kBoxFeature) continue;
    owners.insert(owner);
    EXPECT_EQ(mesh->vertices.containing_dimensions[i], 0);
    for (int k = 0; k < D; ++k) {
      EXPECT_EQ(mesh->vertices.coordinates[i * D + static_cast<std::size_t>(k)],
                features[owner - 1].position[static_cast<std::size_t>(k)]);
    }
  }
  EXPECT_EQ(owners.size(), features.size());
  EXPECT_EQ(mesh->subsegments.size(), D == 2 ? 24u : 0u);
  // The order of features does not matter.
  std::shuffle(features.begin(), features.end(), std::mt19937_64(5));
  EXPECT_EQ(BuildMesh(features, options, BySvr())->hash, mesh->hash);
}

TEST(BuildMesh, BySvrIsGoodAndHasAllPoints) {
  for (const test::Layout layout : test::kLayouts) {
    ExpectGoodMesh<2>(layout, 500);
    ExpectGoodMesh<3>(layout, 300);
  }
}

// Neither mesher needs many more vertices than the other.
TEST(BuildMesh, BySvrIsAsLargeAsByTheDynamicMesher) {
  for (const test::Layout layout : {test::Layout::kUniform, test::Layout::kClustered}) {
    const auto features = PointFeatures<2>(layout, 3000);
    const double svr =
        static_cast<double>(BuildMesh(features, OptionsIn(2), BySvr())->vertices.size());
    const double dynamic = static_cast<double>(BuildMesh(features, OptionsIn(2))->vertices.size());
    EXPECT_LT(svr, 1.5 * dynamic);
    EXPECT_LT(dynamic, 1.5 * svr);
  }
}

TEST(BuildMesh, BySvrRefusesWhatItDoesNotSupport) {
  const auto expect = [](const absl::StatusOr<Mesh>& mesh, const char* words) {
    ASSERT_FALSE(mesh.ok()) << words;
    EXPECT_EQ(GetErrorDetail(mesh.status())->reason, reason::kBadOption);
    EXPECT_EQ(mesh.status().message().find("engine: svr"), 0u) << mesh.status();
    EXPECT_NE(mesh.status().message().find(words), absl::string_view::npos) << mesh.status();
  };
  MeshOptions options = OptionsIn(2);
  std::vector<Feature> features = {Feature::Point(1, 0.2, 0.2), Feature::Point(2, 0.8, 0.2),
                                   Feature::Point(3, 0.5, 0.8)};
  const auto with = [&](const Feature& f) {
    std::vector<Feature> all = features;
    all.push_back(f);
    return BuildMesh(all, options, BySvr());
  };
  options.quality = 1.2;
  expect(BuildMesh(features, options, BySvr()), "quality 1.2");
  options = OptionsIn(2);
  options.criterion = Criterion::kThesis;
  expect(BuildMesh(features, options, BySvr()), "criterion");
  options = OptionsIn(3);
  options.min_dihedral = 10;
  expect(BuildMesh(features, options, BySvr()), "min_dihedral");
  options = OptionsIn(2);
  options.kind = MeshKind::kQuadtree;
  expect(BuildMesh(features, options, BySvr()), "of kind delaunay only");
  // Bad input is judged as by the dynamic mesher.
  options = OptionsIn(2);
  EXPECT_EQ(GetErrorDetail(with(Feature::Point(4, 0.2, 0.2)).status())->reason,
            reason::kDuplicatePoint);
}

struct Way {
  const char* name;
  BuildEngine engine;
  MeshKind kind;
};
constexpr Way kWays[] = {{"dynamic", BuildEngine::kDynamic, MeshKind::kDelaunay},
                         {"svr", BuildEngine::kSvr, MeshKind::kDelaunay},
                         {"quadtree", BuildEngine::kDynamic, MeshKind::kQuadtree}};

TEST(BuildMesh, IsLimitedInterruptedAndReported) {
  const auto features = PointFeatures<2>(test::Layout::kUniform, 2000);
  for (const Way& way : kWays) {
    SCOPED_TRACE(way.name);
    MeshOptions options = OptionsIn(2);
    options.kind = way.kind;
    BuildOptions build;
    build.engine = way.engine;
    std::uint64_t polls = 0;
    std::vector<ApplyProgress> reports;
    build.interrupted = [&] { return ++polls, false; };
    build.progress = [&](const ApplyProgress& p) { reports.push_back(p); };
    const auto whole = BuildMesh(features, options, build);
    ASSERT_TRUE(whole.ok()) << whole.status();
    EXPECT_GT(polls, 1000u);
    ASSERT_GE(reports.size(), 6u);
    EXPECT_EQ(reports.back().stage, ApplyProgress::Stage::kDiff);
    EXPECT_EQ(reports.back().done, reports.back().total);
    build.progress = nullptr;
    for (const std::uint64_t at : {std::uint64_t{1}, polls / 3, polls - 1}) {
      std::uint64_t poll = 0;
      build.interrupted = [&] { return ++poll >= at; };
      const auto stopped = BuildMesh(features, options, build);
      ASSERT_FALSE(stopped.ok());
      EXPECT_EQ(GetErrorDetail(stopped.status())->reason, reason::kCancelled);
    }
    build.interrupted = nullptr;
    build.max_operations = 100;
    EXPECT_EQ(GetErrorDetail(BuildMesh(features, options, build).status())->reason,
              reason::kWorkLimit);
    build.max_operations = 0;
    options.limits.max_vertices = whole->vertices.size();
    EXPECT_EQ(BuildMesh(features, options, build)->hash, whole->hash);
    --options.limits.max_vertices;
    EXPECT_EQ(GetErrorDetail(BuildMesh(features, options, build).status())->reason,
              reason::kVertexLimit);
  }
}

TEST(BuildMesh, FeaturesMayGoWhenTheyAreRead) {
  for (const bool has_segment : {false, true}) {
    for (const BuildEngine engine : {BuildEngine::kDynamic, BuildEngine::kSvr}) {
      std::vector<Feature> features = PointFeatures<2>(test::Layout::kUniform, 200);
      features[7].label = OptionalLabel(3, "seven");
      if (has_segment) {
        features.push_back(Feature::Point(900, 2, 2));
        features.push_back(Feature::Point(901, 3, 2));
        features.push_back(Feature::Segment(902, 900, 901));
      }
      MeshOptions options = OptionsIn(2);
      options.box = {{-1, -1, 0}, {4, 4, 0}};
      BuildOptions build;
      build.engine = engine;
      const auto kept = BuildMesh(features, options, build);
      ASSERT_TRUE(kept.ok()) << kept.status();
      int calls = 0;
      build.features_read = [&] {
        ++calls;
        std::vector<Feature>().swap(features);
      };
      const auto mesh = BuildMesh(features, options, build);
      ASSERT_TRUE(mesh.ok()) << mesh.status();
      EXPECT_EQ(calls, 1);
      EXPECT_EQ(mesh->hash, kept->hash);
      EXPECT_EQ(mesh->revision, 1U);
      EXPECT_EQ(mesh->labels, kept->labels);
      EXPECT_EQ(mesh->labels.size(), 1U);
    }
  }
}

}  // namespace
}  // namespace dynmesh::build_mesh_test
