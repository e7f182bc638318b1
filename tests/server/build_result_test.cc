// BuildMesh over loopback, with the real mesher: the same as in process, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <random>
#include <thread>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "tests/server/raw_upload.h"
#include "tests/server/server_fixture.h"

namespace dynmesh::server::build_result_test {
namespace {

using client::BuildParams;

std::vector<Feature> RandomPoints(int dimension, std::size_t count) {
  std::mt19937_64 random(count);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Feature> points;
  for (FeatureId id = 1; id <= count; ++id) {
    const double x = unit(random), y = unit(random);
    points.push_back(Feature::Point(id, x, y, dimension == 3 ? unit(random) : 0));
  }
  return points;
}

MeshOptions OptionsOf(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  options.min_dihedral = DefaultMinDihedral(dimension);
  return options;
}

// Two polygons, one in the other, a segment and sizes.
std::vector<Feature> Plate() {
  std::vector<Feature> plate = {Feature::Polygon(30, {{1, 2, 3, 4}})};  // before its points
  FeatureId id = 1;
  for (const double r : {0.4, 0.2}) {
    for (const auto& [x, y] : {std::pair(-r, -r), std::pair(r, -r), std::pair(r, r), {-r, r}}) {
      plate.push_back(Feature::Point(id++, 0.5 + x, 0.5 + y));
    }
  }
  plate.push_back(Feature::Polygon(31, {{5, 6, 7, 8}}));
  plate.push_back(Feature::Segment(20, 4, 8));
  plate.push_back(Feature::SizeDisc(40, 0.5, 0.5, 0.1, 0.02));
  return plate;
}

// A cube of polygons.
std::vector<Feature> Cube() {
  std::vector<Feature> cube;
  for (FeatureId i = 0; i < 8; ++i) {
    const auto at = [i](int bit) { return (i >> bit & 1) != 0 ? 0.7 : 0.3; };
    cube.push_back(Feature::Point(1 + i, at(0), at(1), at(2)));
  }
  const Rings faces = {{1, 2, 4, 3}, {5, 6, 8, 7}, {1, 2, 6, 5},
                       {3, 4, 8, 7}, {1, 3, 7, 5}, {2, 4, 8, 6}};
  for (FeatureId i = 0; i < 6; ++i) cube.push_back(Feature::Polygon(20 + i, {faces[i]}));
  return cube;
}

// Sorted: the mesher lists them in the order of a hash table.
std::vector<std::array<std::uint64_t, 4>> RowsOf(const SubfacetColumns& subfacets) {
  std::vector<std::array<std::uint64_t, 4>> rows;
  for (std::size_t i = 0; i < subfacets.size(); ++i) {
    const VertexId* const corners = &subfacets.corners[3 * i];
    rows.push_back({corners[0], corners[1], corners[2], subfacets.owners[i]});
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

class BuildResultTest : public ServerFixture {
 protected:
  BuildResultTest() { builder_ = &BuildMesh; }

  void ExpectSame(const std::vector<Feature>& features, const MeshOptions& options,
                  BuildEngine engine = BuildEngine::kDynamic, bool only_inside = false) {
    BuildOptions build;
    build.engine = engine;
    build.only_inside = only_inside;
    const auto expected = BuildMesh(features, options, build);
    ASSERT_TRUE(expected.ok()) << Text(expected.status());
    BuildParams params;
    params.engine = engine;
    params.only_inside = only_inside;
    const auto mesh = client_->BuildMesh(features, options, params);
    ASSERT_TRUE(mesh.ok()) << Text(mesh.status());
    EXPECT_EQ(mesh->dimension, expected->dimension);
    EXPECT_EQ(mesh->revision, expected->revision);
    EXPECT_EQ(mesh->hash, expected->hash);
    EXPECT_EQ(mesh->vertices, expected->vertices);
    EXPECT_EQ(mesh->simplices, expected->simplices);
    EXPECT_EQ(mesh->regions, expected->regions);
    EXPECT_EQ(mesh->region_sets, expected->region_sets);
    EXPECT_EQ(mesh->subsegments, expected->subsegments);
    EXPECT_EQ(RowsOf(mesh->subfacets), RowsOf(expected->subfacets));
  }
  void StartUnlimited() {
    ServerConfig config;
    config.max_builds = 1;
    config.max_build_vertices = 100'000'000;
    StartServer(config);
  }
  // Of a mesh that takes minutes, on such a server.
  static MeshOptions EndlessOptions() {
    MeshOptions options;
    options.max_edge = 3e-4;
    return options;
  }
};

TEST_F(BuildResultTest, DelaunayMeshes) {
  StartServer();
  ExpectSame(Plate(), OptionsOf(2));
  ExpectSame(RandomPoints(2, 2'000), OptionsOf(2));
  ExpectSame(Cube(), OptionsOf(3));
  ExpectSame(RandomPoints(3, 300), OptionsOf(3));
  MeshOptions thesis = OptionsOf(2);
  thesis.criterion = Criterion::kThesis;
  thesis.box = {{-1, -2, 0}, {3, 4, 0}};
  ExpectSame(RandomPoints(2, 100), thesis);
}

TEST_F(BuildResultTest, ByTheSvrEngine) {
  StartServer();
  for (const int dimension : {2, 3}) {
    MeshOptions options = OptionsOf(dimension);
    options.min_dihedral = 0;
    ExpectSame(RandomPoints(dimension, 500), options, BuildEngine::kSvr);
  }
}

TEST_F(BuildResultTest, OnlyInside) {
  StartServer();
  MeshOptions options = OptionsOf(3);
  options.min_dihedral = 20;
  ExpectSame(Cube(), options, BuildEngine::kDynamic, true);
  BuildOptions build;
  build.only_inside = true;
  EXPECT_NE(BuildMesh(Cube(), options, build)->hash, BuildMesh(Cube(), options)->hash);
}

TEST_F(BuildResultTest, Quadtrees) {
  StartServer();
  for (const int dimension : {2, 3}) {
    MeshOptions options = OptionsOf(dimension);
    options.kind = MeshKind::kQuadtree;
    options.min_dihedral = 0;
    ExpectSame(RandomPoints(dimension, 200), options);
  }
}

TEST_F(BuildResultTest, OfNothing) {
  StartServer();
  ExpectSame({}, OptionsOf(2));
  ExpectSame({}, OptionsOf(3));
}

TEST_F(BuildResultTest, InManyParts) {
  StartServer();
  ExpectSame(RandomPoints(2, 40'000), OptionsOf(2));  // 1.4 MB
}

TEST_F(BuildResultTest, InputIsRefusedAsInProcess) {
  StartServer();
  std::vector<Feature> crossing = Plate();
  crossing.push_back(Feature::Segment(21, 1, 3));
  const auto expect_same = [&](const std::vector<Feature>& features, BuildEngine engine,
                               double quality = kDefaultQuality2D) {
    MeshOptions options;
    options.quality = quality;
    BuildOptions build;
    build.engine = engine;
    const absl::Status expected = BuildMesh(features, options, build).status();
    ASSERT_FALSE(expected.ok());
    BuildParams params;
    params.engine = engine;
    const absl::Status status = client_->BuildMesh(features, options, params).status();
    EXPECT_EQ(status.code(), expected.code());
    EXPECT_EQ(status.message(), expected.message());
    EXPECT_EQ(ReasonOf(status), GetErrorDetail(expected)->reason);
    EXPECT_EQ(codec::GetServiceError(status)->Features(), GetErrorDetail(expected)->features);
  };
  expect_same(crossing, BuildEngine::kDynamic);
  expect_same(crossing, BuildEngine::kSvr);
  expect_same(Plate(), BuildEngine::kSvr, 1.2);
  std::vector<Feature> twice = RandomPoints(2, 100);
  twice[70].id = 7;
  expect_same(twice, BuildEngine::kDynamic);
  RawBuild build(*stub_, MeshOptions());
  for (const Feature& f : twice) build.Add(f);
  EXPECT_EQ(codec::GetServiceError(build.SendLastAndFinish())->field, "features[70]");
}

// By itself it would not end.
TEST_F(BuildResultTest, LimitsAndCancellationEndALongBuild) {
  StartUnlimited();
  BuildParams params;
  params.max_time = absl::Milliseconds(300);
  EXPECT_EQ(ReasonOf(client_->BuildMesh({}, EndlessOptions(), params).status()),
            codec::reason::kTimeLimit);
  std::atomic<bool> cancelled{false};
  std::vector<client::LoadProgress> told;
  params = {};
  params.cancelled = &cancelled;
  params.progress = [&](const client::LoadProgress& p) {
    told.push_back(p);
    cancelled = told.size() >= 2;
  };
  absl::Status status;
  test::WaitUntil("a free place", [&] {
    status = client_->BuildMesh({}, EndlessOptions(), params).status();
    return ReasonOf(status) != codec::reason::kStreamLimit;
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
  ASSERT_GE(told.size(), 2u);
  EXPECT_EQ(told.back().stage, client::LoadProgress::Stage::kRefine);
  MeshOptions few = EndlessOptions();
  few.limits.max_vertices = 10'000;
  test::WaitUntil("a free place", [&] {
    status = client_->BuildMesh({}, few).status();
    return ReasonOf(status) != codec::reason::kStreamLimit;
  });
  EXPECT_EQ(ReasonOf(status), reason::kVertexLimit);
}

TEST_F(BuildResultTest, ADrainStopsALongBuild) {
  StartUnlimited();
  Mailbox<absl::Status> ended;
  Mailbox<int> refines;
  BuildParams params;
  params.progress = [&](const client::LoadProgress& p) {
    if (p.stage == client::LoadProgress::Stage::kRefine) refines.Put(0);
  };
  std::thread builder(
      [&] { ended.Put(client_->BuildMesh({}, EndlessOptions(), params).status()); });
  refines.Take();
  EXPECT_TRUE(server_->Drain(kLong));
  EXPECT_EQ(ReasonOf(ended.Take()), codec::reason::kDraining);
  builder.join();
}

}  // namespace
}  // namespace dynmesh::server::build_result_test
