// The lower bound of vertices by validation, compared with the actual number: never more. Also the
// batches refused for it: at once, with names, as Apply would refuse them in the end.
#include "core/plc/least_vertices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "tests/core/dynamic_mesh/demand_scenes.h"
#include "tests/core/plc/plc_test_util.h"

namespace dynmesh::least_vertices_test {
namespace {

using test::Scenes;

constexpr std::uint64_t kSeed = 20;

MeshOptions OptionsIn(int dimension, double quality) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = quality;
  return options;
}

// True if validation accepts all these with such a limit of vertices.
template <int D>
absl::Status CheckWith(std::span<const Feature> features, MeshOptions options,
                       std::uint64_t max_vertices) {
  options.limits.max_vertices = max_vertices;
  return plc::Plc<D>(options).Check(AddAll(features)).status();
}

// The greatest limit that validation refuses; 0 if there is none.
template <int D>
std::uint64_t LeastOf(std::span<const Feature> features, const MeshOptions& options) {
  std::uint64_t refused = 0, passed = std::uint64_t{1} << 50;
  while (passed - refused > 1) {
    const std::uint64_t middle = refused + (passed - refused) / 2;
    (CheckWith<D>(features, options, middle).ok() ? passed : refused) = middle;
  }
  return refused;
}

struct Sharpness {
  int scenes = 0, told = 0;
  double least = INFINITY, sum = 0;
};

// Makes scenes and compares; skips illegal input.
template <int D, class Make>
Sharpness ExpectNeverTooHigh(const char* name, std::span<const double> qualities, int rounds,
                             Make make) {
  Sharpness found;
  for (int round = 0; round < rounds; ++round) {
    const std::uint64_t seed = kSeed + 1000 * static_cast<std::uint64_t>(round);
    SCOPED_TRACE(std::string(name) + ", seed " + std::to_string(seed));
    Scenes scenes(seed);
    make(scenes);
    MeshOptions options =
        OptionsIn(D, qualities[static_cast<std::size_t>(round) % qualities.size()]);
    if (round % 5 == 4 && options.quality >= (D == 2 ? 1.5 : 2)) {
      options.criterion = Criterion::kThesis;
    }
    if (!CheckWith<D>(scenes.features, options, std::uint64_t{1} << 50).ok()) continue;
    options.limits.max_vertices = D == 2 ? 200'000 : 60'000;
    const auto mesh = BuildMesh(scenes.features, options);
    if (!mesh.ok()) continue;
    ++found.scenes;
    const auto vertices = static_cast<std::uint64_t>(mesh->vertices.size());
    // The actual number is not much larger.
    EXPECT_TRUE(CheckWith<D>(scenes.features, options, vertices).ok())
        << CheckWith<D>(scenes.features, options, vertices) << ", but it took " << vertices;
    const std::uint64_t least = LeastOf<D>(scenes.features, options);
    if (least == 0) continue;
    ++found.told;
    const double ratio = static_cast<double>(vertices) / static_cast<double>(least);
    found.least = std::min(found.least, ratio);
    found.sum += std::log(ratio);
  }
  std::printf("%-16s %4d scenes, %4d bounds; vertices / bound: least %.2f, mean %.2f\n", name,
              found.scenes, found.told, found.least, std::exp(found.sum / found.told));
  return found;
}

constexpr double kPlanar[] = {1.0, 1.2, kDefaultQuality2D, 2.0, 5.0};
constexpr double kSpatial[] = {1.4, 2.0, 3.0};

TEST(LeastVertices, AreNeverMoreThanThereAreInThePlane) {
  const auto check = [&](const char* name, int rounds, auto make) {
    const Sharpness found = ExpectNeverTooHigh<2>(name, kPlanar, rounds, make);
    EXPECT_GT(found.told, rounds / 8);
  };
  check("regions", 60, [](Scenes& s) { s.Regions(2); });
  check("capsules", 60, [](Scenes& s) { s.Regions(2, true); });
  check("thin regions", 60, [](Scenes& s) { s.ThinRegions(2); });
  check("lines", 100, [](Scenes& s) { s.Lines(2); });
  check("squares", 60, [](Scenes& s) { s.NestedSquares(); });
  check("seams", 120, [](Scenes& s) { s.Seams(); });
  check("near doubles", 60, [](Scenes& s) { s.NearDoubles(); });
}

// The bound of lines is not far from the truth: meshing must not take gigabytes to find out.
TEST(LeastVertices, OfNearLinesAreAQuarterOfTheTruth) {
  for (const bool is_seam : {true, false}) {
    const Sharpness found =
        ExpectNeverTooHigh<2>(is_seam ? "seams" : "near doubles", {{kDefaultQuality2D}}, 20,
                              [&](Scenes& s) { is_seam ? s.Seams() : s.NearDoubles(); });
    ASSERT_GT(found.told, 5);
    EXPECT_LT(std::exp(found.sum / found.told), 8);
  }
}

// SVR validates by the same bound.
TEST(LeastVertices, AreNeverMoreThanSvrMakes) {
  int told = 0;
  for (std::uint64_t round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    Scenes scenes(kSeed + 7919 * round);
    switch (round % 3) {
      case 0:
        scenes.Lines(2);
        break;
      case 1:
        scenes.Seams();
        break;
      default:
        scenes.NearDoubles();
    }
    MeshOptions options = OptionsIn(2, kDefaultQuality2D);
    if (!CheckWith<2>(scenes.features, options, std::uint64_t{1} << 50).ok()) continue;
    options.limits.max_vertices = 200'000;
    BuildOptions build;
    build.engine = BuildEngine::kSvr;
    const auto mesh = BuildMesh(scenes.features, options, build);
    if (!mesh.ok()) continue;
    EXPECT_TRUE(CheckWith<2>(scenes.features, options, mesh->vertices.size()).ok());
    told += LeastOf<2>(scenes.features, options) != 0 ? 1 : 0;
  }
  EXPECT_GT(told, 10);
}

TEST(LeastVertices, AreNeverMoreThanThereAreAtSharpAngles) {
  ExpectNeverTooHigh<2>("zigzags", kPlanar, 150, [](Scenes& s) { s.Zigzags(); });
  ExpectNeverTooHigh<2>("fans", kPlanar, 60, [](Scenes& s) { s.Fan(); });
  ExpectNeverTooHigh<3>("blades", kSpatial, 16, [](Scenes& s) { s.Blades(); });
}

TEST(LeastVertices, AreNeverMoreThanThereAreInSpace) {
  const auto check = [&](const char* name, int rounds, auto make) {
    return ExpectNeverTooHigh<3>(name, kSpatial, rounds, make);
  };
  EXPECT_GT(check("regions", 24, [](Scenes& s) { s.Regions(3); }).told, 8);
  EXPECT_GT(check("capsules", 24, [](Scenes& s) { s.Regions(3, true); }).told, 8);
  EXPECT_GT(check("thin regions", 24, [](Scenes& s) { s.ThinRegions(3); }).told, 8);
  EXPECT_GT(check("lines", 24, [](Scenes& s) { s.Lines(3); }).told, 5);
  EXPECT_GT(check("plates", 16, [](Scenes& s) { s.Plates(); }).told, 3);
}

// --- Refusals ------------------------------------------------------------------------------------

void ExpectRefused(const absl::Status& status, const std::vector<FeatureId>& features) {
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  const auto detail = GetErrorDetail(status);
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, reason::kVertexLimit);
  EXPECT_EQ(detail->features, features);
}

// A higher limit is advised where a mesh can have that many vertices (MostVertices).
TEST(LeastVertices, AHigherLimitIsAdvisedWhereItHelps) {
  MeshOptions options = OptionsIn(2, kDefaultQuality2D);
  options.limits.max_vertices = 1000;
  const auto mesh = *DynamicMesh::Create(options);
  for (const auto& [target, helps] : {std::pair{0.01, true}, {1e-6, false}}) {
    const absl::Status status =
        mesh->Validate(AddAll(std::vector{Feature::SizeDisc(1, 0.5, 0.5, 0.4, target)}));
    ExpectRefused(status, {1});
    EXPECT_EQ(status.message().find("create the mesh with a higher limit") != std::string::npos,
              helps)
        << status;
  }
}

// By a mesh with content, and by its validation.
void ExpectRefusedByAll(const MeshOptions& options, const std::vector<Feature>& present,
                        const EditBatch& batch, const std::vector<FeatureId>& features) {
  const auto mesh = *DynamicMesh::Create(options);
  ASSERT_TRUE(mesh->Apply(AddAll(present)).ok());
  const MeshHash hash = mesh->hash();
  ExpectRefused(mesh->Validate(batch), features);
  if (testing::Test::HasFailure()) return;  // what is not refused may take very long
  ExpectRefused(mesh->Apply(batch).status(), features);
  EXPECT_EQ(mesh->hash(), hash);
  EXPECT_EQ(mesh->Features().size(), present.size());
}

TEST(LeastVertices, ATinyTargetIsRefusedByName) {
  const std::vector<Feature> present = {Feature::Point(1, 0.2, 0.3, 0.4)};
  ExpectRefusedByAll(OptionsIn(2, kDefaultQuality2D), present,
                     {Edit::Add(Feature::Point(2, 0.6, 0.6)),
                      Edit::Add(Feature::SizeDisc(7, 0.5, 0.5, 0.1, 1e-7))},
                     {7});
  ExpectRefusedByAll(OptionsIn(2, kDefaultQuality2D), present,
                     {Edit::Add(Feature::SizeBox(8, 0.1, 0.1, 0.9, 0.2, 1e-6))}, {8});
  const std::vector<Feature> corners = {Feature::Point(1, 0.1, 0.1), Feature::Point(2, 0.9, 0.1),
                                        Feature::Point(3, 0.5, 0.9)};
  ExpectRefusedByAll(OptionsIn(2, kDefaultQuality2D), corners,
                     {Edit::Add(Feature::SizePolygon(9, {{1, 2, 3}}, 1e-5))}, {9});
  ExpectRefusedByAll(
      OptionsIn(2, kDefaultQuality2D), present,
      {Edit::Add(Feature::SizeCapsule(9, {{0.1, 0.1}, {0.9, 0.9}, {0.2, 0.8}}, 0.01, 1e-6))}, {9});
  ExpectRefusedByAll(
      OptionsIn(3, 2.0), present,
      {Edit::Add(Feature::SizeCapsule(9, {{0.1, 0.1, 0.1}, {0.9, 0.9, 0.9}}, 0.02, 1e-5))}, {9});
  ExpectRefusedByAll(
      OptionsIn(3, 2.0), present,
      {Edit::Add(Feature::Size(7, {0.5, 0.5, 0.5}, {SizeShape::kDisc, 1e-5, 0.1, {}}))}, {7});
}

// Its area or volume is next to nothing: its length counts.
TEST(LeastVertices, ATinyTargetInAThinRegionIsRefusedByName) {
  const std::vector<Feature> corners = {Feature::Point(1, 0.1, 0.1), Feature::Point(2, 0.9, 0.1),
                                        Feature::Point(3, 0.9, 0.1 + 1e-12)};
  for (const double width : {0.0, 1e-15, 1e-10}) {
    ExpectRefusedByAll(OptionsIn(2, kDefaultQuality2D), corners,
                       {Edit::Add(Feature::SizeCapsule(9, {{0.1, 0.1}, {0.9, 0.9}}, width, 1e-9))},
                       {9});
    ExpectRefusedByAll(
        OptionsIn(3, 2.0), corners,
        {Edit::Add(Feature::SizeCapsule(9, {{0.1, 0.1, 0.1}, {0.9, 0.9, 0.9}}, width, 1e-9))}, {9});
    ExpectRefusedByAll(OptionsIn(2, kDefaultQuality2D), corners,
                       {Edit::Add(Feature::SizeBox(9, 0.1, 0.5, 0.9, 0.5 + width, 1e-9))}, {9});
    ExpectRefusedByAll(
        OptionsIn(3, 2.0), corners,
        {Edit::Add(Feature::Size(9, {0.1, 0.5, 0.5},
                                 {SizeShape::kBox, 1e-9, 0, {0.9, 0.5 + width, 0.5 + width}}))},
        {9});
  }
  ExpectRefusedByAll(OptionsIn(2, kDefaultQuality2D), corners,
                     {Edit::Add(Feature::SizePolygon(9, {{1, 2, 3}}, 1e-9))}, {9});
}

TEST(LeastVertices, ManyRegionsCountTogetherWhereTheyAreApart) {
  MeshOptions options = OptionsIn(2, kDefaultQuality2D);
  options.limits.max_vertices = 100'000;
  const auto mesh = *DynamicMesh::Create(options);
  EditBatch apart, same;
  for (FeatureId i = 0; i < 100; ++i) {
    const double x = 0.05 + 0.1 * static_cast<double>(i % 10),
                 y = 0.05 + 0.1 * static_cast<double>(i / 10);
    apart.push_back(Edit::Add(Feature::SizeDisc(i + 1, x, y, 0.03, 0.001)));
    same.push_back(Edit::Add(Feature::SizeDisc(i + 1, 0.5, 0.5, 0.03, 0.001)));
  }
  EXPECT_EQ(mesh->Validate(apart).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(mesh->Validate(same).ok());
  apart.resize(10);
  EXPECT_TRUE(mesh->Validate(apart).ok());
}

TEST(LeastVertices, ATinyMaxEdgeIsRefusedAtOnce) {
  for (const int dimension : {2, 3}) {
    for (const double max_edge : {1e-5, 1e-100, 1e-300, 5e-324}) {
      MeshOptions options = OptionsIn(dimension, 2);
      options.max_edge = max_edge;
      ApplyOptions apply;
      apply.max_operations = 1;  // none is run
      ExpectRefused(DynamicMesh::Create(options, apply).status(), {});
      ExpectRefused(BuildMesh({}, options).status(), {});
    }
  }
}

std::vector<Feature> Line(FeatureId first, double y, double from, double to, double z = 0) {
  return {Feature::Point(first, from, y, z), Feature::Point(first + 1, to, y, z),
          Feature::Segment(first + 2, first, first + 1)};
}

TEST(LeastVertices, LinesTooNearEachOtherAreRefusedByName) {
  for (const int dimension : {2, 3}) {
    const MeshOptions options = OptionsIn(dimension, 2);
    // The new one is longer, shorter, or beside a part of it.
    for (const auto& [from, to] : {std::pair(0.1, 0.9), {0.3, 0.7}, {0.0, 1.0}, {0.4, 1.0}}) {
      ExpectRefusedByAll(options, Line(1, 0.5, 0.1, 0.9), AddAll(Line(11, 0.5 + 1e-10, from, to)),
                         {13, 3});
    }
  }
}

std::vector<Feature> Ring(FeatureId first, const std::vector<std::array<double, 2>>& corners) {
  std::vector<Feature> features;
  std::vector<FeatureId> ring;
  for (const auto& [x, y] : corners) {
    ring.push_back(first + ring.size());
    features.push_back(Feature::Point(ring.back(), x, y));
  }
  features.push_back(Feature::Polygon(first + ring.size(), {ring}));
  return features;
}

// Few points, and a mesh that does not fit into gigabytes: so it is refused before it is begun.
TEST(LeastVertices, NearParallelEdgesAndNearDoublesAreRefused) {
  MeshOptions options = OptionsIn(2, kDefaultQuality2D);
  options.box = {{-10, -10, 0}, {12, 10, 0}};
  options.limits.max_vertices = 5'000'000;
  // Collinear points 4e-7 and 1.2e-6 apart, over a long edge.
  const std::vector<Feature> doubles = Ring(
      1, {{4e-7, -4e-7}, {4e-7, 0}, {0, 0}, {-1.2e-6, 0}, {-8.66, 0}, {-8.66, 1.34}, {-10, -4e-7}});
  // Two edges that are near over a part of their lengths, the nearest place far from the middles.
  std::vector<Feature> edges = {Feature::Point(1, 0, 0),      Feature::Point(2, 10, 0),
                                Feature::Segment(3, 1, 2),    Feature::Point(4, 9, 5e-8),
                                Feature::Point(5, 12, 1),     Feature::Segment(6, 4, 5),
                                Feature::Point(7, 8.4, 5e-8), Feature::Segment(8, 4, 7)};
  // Many short edges beside one long edge: none alone is the reason.
  std::vector<Feature> row = {Feature::Point(1, 0, 0), Feature::Point(2, 10, 0),
                              Feature::Segment(3, 1, 2)};
  for (FeatureId i = 0; i <= 50; ++i) {
    row.push_back(Feature::Point(10 + i, 1 + 0.1 * static_cast<double>(i), 2e-7));
    if (i > 0) row.push_back(Feature::Segment(100 + i, 9 + i, 10 + i));
  }
  for (const std::vector<Feature>& features : {doubles, edges, row}) {
    const absl::Status status = (*DynamicMesh::Create(options))->Validate(AddAll(features));
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    if (status.ok()) continue;
    EXPECT_EQ(GetErrorDetail(status)->reason, reason::kVertexLimit);
    EXPECT_EQ(GetErrorDetail(status)->features.size(), 2U);
  }
}

// A limit that the bound does not reach is found on the way: the error says where it is finest.
TEST(LeastVertices, TheErrorOfALimitNamesTheFinestPlace) {
  MeshOptions options = OptionsIn(2, kDefaultQuality2D);
  std::vector<Feature> features = Line(1, 0.5, 0.1, 0.9);
  for (const Feature& f : Line(11, 0.5 + 1e-4, 0.3, 0.7)) features.push_back(f);
  for (const Feature& f : Line(21, 0.8, 0.1, 0.9)) features.push_back(f);
  const auto whole = BuildMesh(features, options);
  ASSERT_TRUE(whole.ok());
  const auto expect_named = [](const absl::Status& status, const char* reason) {
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    const auto detail = GetErrorDetail(status);
    ASSERT_TRUE(detail.has_value());
    EXPECT_EQ(detail->reason, reason);
    EXPECT_EQ(std::set<FeatureId>(detail->features.begin(), detail->features.end()),
              (std::set<FeatureId>{3, 13}))
        << status;
    EXPECT_NE(std::string(status.message()).find("are 0.0001 apart"), std::string::npos) << status;
  };
  options.limits.max_vertices = whole->vertices.size() - 1;
  expect_named(BuildMesh(features, options).status(), reason::kVertexLimit);
  BuildOptions build;
  build.max_operations = 1000;
  expect_named(BuildMesh(features, options, build).status(), reason::kWorkLimit);
  // In a mesh, with the other line present: nothing changes.
  for (const bool in_parts : {true, false}) {
    const auto mesh = *DynamicMesh::Create(options);
    EditBatch first = AddAll(Line(21, 0.8, 0.1, 0.9)), second = AddAll(Line(11, 0.5001, 0.3, 0.7));
    EditBatch& with = in_parts ? first : second;
    for (const Edit& edit : AddAll(Line(1, 0.5, 0.1, 0.9))) with.push_back(edit);
    ASSERT_TRUE(mesh->Apply(first).ok());
    const MeshHash hash = mesh->hash();
    expect_named(mesh->Apply(second).status(), reason::kVertexLimit);
    EXPECT_EQ(mesh->hash(), hash);
    EXPECT_TRUE(mesh->Audit().problems.empty());
  }
  // Of a mesh that is large for another reason, no place is named.
  options = OptionsIn(2, kDefaultQuality2D);
  options.max_edge = 0.02;
  options.limits.max_vertices = 5000;
  const absl::Status other = BuildMesh(Line(1, 0.5, 0.1, 0.9), options).status();
  EXPECT_TRUE(other.ok() || GetErrorDetail(other)->features.empty()) << other;
}

TEST(LeastVertices, AMovedPointMayBringLinesTogether) {
  std::vector<Feature> present = Line(1, 0.5, 0.1, 0.9);
  const std::vector<Feature> other = Line(11, 0.5 + 1e-10, 0.1, 0.9);
  present.insert(present.end(), other.begin(), other.end());
  present[4].position[1] = 0.6;
  ExpectRefusedByAll(OptionsIn(2, 2), present, {Edit::Move(12, 0.9, 0.5 + 1e-10)}, {13, 3});
}

TEST(LeastVertices, AFineCombIsRefused) {
  MeshOptions options = OptionsIn(2, kDefaultQuality2D);
  EditBatch comb;
  for (FeatureId i = 0; i < 1000; ++i) {
    for (const Feature& f : Line(3 * i + 1, 0.3 + 1e-6 * static_cast<double>(i), 0.1, 0.9)) {
      comb.push_back(Edit::Add(f));
    }
  }
  const auto mesh = *DynamicMesh::Create(options);
  const absl::Status status = mesh->Validate(comb);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(GetErrorDetail(status)->features.size(), 2u);
}

TEST(LeastVertices, ThinSlabsAreRefusedByName) {
  const auto square = [](FeatureId first, double z) {
    return std::vector<Feature>{
        Feature::Point(first, 0.1, 0.1, z), Feature::Point(first + 1, 0.9, 0.1, z),
        Feature::Point(first + 2, 0.9, 0.9, z), Feature::Point(first + 3, 0.1, 0.9, z),
        Feature::Polygon(first + 4, {{first, first + 1, first + 2, first + 3}})};
  };
  for (const double thickness : {1e-6, 1e-9}) {
    ExpectRefusedByAll(OptionsIn(3, 2), square(1, 0.5), AddAll(square(11, 0.5 + thickness)),
                       {15, 5});
  }
}

// Only edges are near each other. Before they were counted, the search for anchors of the two
// facets took 35 seconds until it found the limit.
TEST(LeastVertices, ALidOverAHoleIsRefusedByName) {
  MeshOptions options = OptionsIn(3, 2);
  options.limits.max_vertices = 100'000;
  const std::vector<Feature> plate = {Feature::Point(1, 0.2, 0.2, 0.5),
                                      Feature::Point(2, 0.8, 0.2, 0.5),
                                      Feature::Point(3, 0.8, 0.8, 0.5),
                                      Feature::Point(4, 0.2, 0.8, 0.5),
                                      Feature::Point(5, 0.4, 0.4, 0.5),
                                      Feature::Point(6, 0.6, 0.4, 0.5),
                                      Feature::Point(7, 0.6, 0.6, 0.5),
                                      Feature::Point(8, 0.4, 0.6, 0.5),
                                      Feature::Polygon(10, {{1, 2, 3, 4}, {5, 6, 7, 8}})};
  const double z = 0.500001;
  ExpectRefusedByAll(
      options, plate,
      {Edit::Add(Feature::Point(30, 0.4, 0.4, z)), Edit::Add(Feature::Point(31, 0.6, 0.4, z)),
       Edit::Add(Feature::Point(32, 0.6, 0.6, z)), Edit::Add(Feature::Point(33, 0.4, 0.6, z)),
       Edit::Add(Feature::Polygon(34, {{30, 31, 32, 33}}))},
      {34, 10});
}

// The order of edits and the present features change the blamed feature, but not the verdict.
TEST(LeastVertices, AreAFunctionOfTheFeatures) {
  MeshOptions options = OptionsIn(2, kDefaultQuality2D);
  std::vector<Feature> features = Line(1, 0.5, 0.1, 0.9);
  for (const Feature& f : Line(11, 0.5 + 1e-10, 0.1, 0.9)) features.push_back(f);
  for (const Feature& f : Line(21, 0.7, 0.1, 0.9)) features.push_back(f);
  std::mt19937_64 random(kSeed);
  std::string message;
  for (int i = 0; i < 20; ++i) {
    const absl::Status status = plc::Plc2(options).Check(AddAll(features)).status();
    ExpectRefused(status, {3, 13});
    if (i == 0) message = std::string(status.message());
    EXPECT_EQ(status.message(), message);
    std::shuffle(features.begin(), features.end(), random);
  }
}

}  // namespace
}  // namespace dynmesh::least_vertices_test
