// `verify` of meshes with polygons: labels of triangles, owners of edges.
#include <algorithm>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "client/verify/verify.h"
#include "client/verify/verify_internal.h"
#include "gtest/gtest.h"
#include "tests/client/verify/good_mesh.h"
#include "tests/client/verify/report_text.h"
#include "tests/support/seed.h"

namespace dynmesh::cli::regions_test {
namespace {

using testing::GoodMesh;
using testing::MakePolygonMesh;

constexpr double kAnyQuality = 1e9;

TEST(VerifyRegions, AcceptsGoodMeshesWithPolygons) {
  const std::uint64_t seed = test::NewSeed();
  for (std::uint64_t i = 0; i < 10; ++i) {
    const GoodMesh good = MakePolygonMesh(seed + i, static_cast<int>(60 * i));
    EXPECT_EQ(good.files.mesh.regions.count(), 6U);
    const VerifyReport report = VerifyMesh(good.files, kAnyQuality, &good.features);
    EXPECT_TRUE(report.Passed()) << Describe(report);
  }
}

// The number of the region of these polygons.
std::uint32_t NumberOf(const GoodMesh& good, const std::vector<FeatureId>& polygons) {
  const auto& rows = good.files.mesh.regions.polygons;
  const auto it = std::find(rows.begin(), rows.end(), polygons);
  EXPECT_NE(it, rows.end());
  return static_cast<std::uint32_t>(it - rows.begin()) + 1;
}

// The first triangle in these polygons.
std::uint32_t& LabelOf(GoodMesh& good, const std::vector<FeatureId>& polygons) {
  auto& numbers = good.files.mesh.regions.numbers;
  const std::uint32_t number = polygons.empty() ? 0 : NumberOf(good, polygons);
  return *std::find(numbers.begin(), numbers.end(), number);
}

Feature& FeatureOf(GoodMesh& good, FeatureId id) {
  return *std::find_if(good.features.begin(), good.features.end(),
                       [&](const Feature& f) { return f.id == id; });
}

io::IndexedMesh::Edge& EdgeOf(GoodMesh& good, FeatureId owner) {
  auto& edges = good.files.mesh.edges;
  return *std::find_if(edges.begin(), edges.end(), [&](const auto& e) { return e.owner == owner; });
}

// With a polygon (5, 3) the edge between two polygons that share it is 3's.
struct Damage {
  const char* name;
  std::function<void(GoodMesh&)> apply;
  std::set<std::string> checks;
};

using testing::kFilling, testing::kHoleSegment, testing::kNested, testing::kParts, testing::kRing,
    testing::kRoof, testing::kTip;

std::vector<Damage> Damages() {
  return {
      {"wrong label", [](GoodMesh& g) { LabelOf(g, {kRing}) = NumberOf(g, {kRoof}); }, {"regions"}},
      {"missing label", [](GoodMesh& g) { LabelOf(g, {kRing}) = 0; }, {"regions"}},
      {"label where no polygon is",
       [](GoodMesh& g) { LabelOf(g, {}) = NumberOf(g, {kRing}); },
       {"regions"}},
      {"hole labelled as the ring around it",
       [](GoodMesh& g) { LabelOf(g, {kFilling}) = NumberOf(g, {kRing}); },
       {"regions"}},
      {"inner polygon forgotten",
       [](GoodMesh& g) {
         LabelOf(g, {kFilling, kNested}) = NumberOf(g, {kFilling});
       },
       {"regions"}},
      {"outer polygon forgotten",
       [](GoodMesh& g) {
         g.files.mesh.regions.polygons[NumberOf(g, {kFilling, kNested}) - 1] = {kNested};
       },
       {"regions"}},
      {"too many polygons",
       [](GoodMesh& g) {
         LabelOf(g, {kFilling, kNested}) = NumberOf(g, {kFilling, kNested, kTip});
       },
       {"regions"}},
      {"no labels at all", [](GoodMesh& g) { g.files.mesh.regions = {}; }, {"regions"}},
      {"polygon that is not in the mesh",
       [](GoodMesh& g) {
         g.features.push_back(Feature::Polygon(77, {{200, 201, 202, 203}}));
       },
       {"regions"}},
      {"sizing polygons label nothing",
       [](GoodMesh& g) {
         g.features.push_back(Feature::SizePolygon(77, {{200, 201, 202, 203}}, 100));
       },
       {}},
      {"hole that is not in the input",
       [](GoodMesh& g) { FeatureOf(g, kRing).rings.pop_back(); },
       {"regions"}},
      {"a part that the mesh does not have",
       [](GoodMesh& g) { FeatureOf(g, kParts).rings[1].pop_back(); },
       {"input", "regions"}},
      {"polygon through triangles",
       [](GoodMesh& g) {
         g.features.push_back(Feature::Polygon(77, {{100, 202, 400}}));
       },
       {"input", "regions"}},
      {"polygon with a corner that is no point",
       [](GoodMesh& g) { FeatureOf(g, kTip).rings[0].push_back(777); },
       {"input", "regions"}},
      {"shared edge with the other polygon's marker",
       [](GoodMesh& g) { EdgeOf(g, kFilling).owner = kRing; },
       {"input"}},
      {"segment's edge with the polygon's marker",
       [](GoodMesh& g) { EdgeOf(g, kHoleSegment).owner = kFilling; },
       {"input"}},
      {"polygon's edge without a marker",
       [](GoodMesh& g) { EdgeOf(g, kTip).owner = kNoFeature; },
       {"input"}},
      {"edge inside with a polygon's marker",
       [](GoodMesh& g) { EdgeOf(g, kNoFeature).owner = kRing; },
       {"input"}},
      {"edge with the marker of a polygon that owns none",
       [](GoodMesh& g) {
         g.features.push_back(Feature::Polygon(kBoxFeature - 5, {{100, 101, 102, 103}}));
         EdgeOf(g, kNoFeature).owner = kBoxFeature - 5;
       },
       {"input", "regions"}},
      {"the segment taken away",
       [](GoodMesh& g) {
         std::erase_if(g.features, [](const Feature& f) { return f.id == kHoleSegment; });
       },
       {"input"}},
  };
}

TEST(VerifyRegions, FindsEveryKindOfDamage) {
  for (const Damage& damage : Damages()) {
    GoodMesh mesh = MakePolygonMesh(11, 100);
    damage.apply(mesh);
    const VerifyReport report = VerifyMesh(mesh.files, kAnyQuality, &mesh.features);
    std::set<std::string> failed = FailedChecks(report);
    failed.erase("hash");
    EXPECT_EQ(failed, damage.checks) << damage.name << "\n" << Describe(report);
  }
}

TEST(VerifyRegions, FindsEveryChangedLabel) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937_64 random(seed);
  const GoodMesh good = MakePolygonMesh(seed, 100);
  for (int round = 0; round < 100; ++round) {
    io::IndexedMesh mesh = good.files.mesh;
    auto& number = mesh.regions.numbers[random() % mesh.regions.numbers.size()];
    const auto other = static_cast<std::uint32_t>(random() % (mesh.regions.count() + 1));
    const std::uint64_t expected = other == number ? 0 : 1;
    number = other;
    EXPECT_EQ(CheckRegions(mesh, good.features).failures, expected);
  }
}

// A triangle without doubles other than its corners.
TEST(VerifyRegions, KnowWhereTheSmallestTriangleIs) {
  constexpr double kTiny = std::numeric_limits<double>::denorm_min();
  io::IndexedMesh mesh;
  mesh.vertices = {{0, 0, 0, 1}, {kTiny, 0, 0, 2}, {0, kTiny, 0, 3}, {kTiny, kTiny, 0, 4}};
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  const std::vector<Feature> features = {Feature::Point(1, 0, 0), Feature::Point(2, kTiny, 0),
                                         Feature::Point(3, 0, kTiny),
                                         Feature::Polygon(4, {{1, 2, 3}})};
  EXPECT_EQ(CheckRegions(mesh, features).failures, 1U);
  mesh.regions.polygons = {{4}};
  mesh.regions.numbers = {1, 0};
  EXPECT_EQ(CheckRegions(mesh, features).failures, 0U);
  mesh.regions.numbers = {0, 1};
  EXPECT_EQ(CheckRegions(mesh, features).failures, 2U);
}

// A quarter of the triangles of a large mesh in a comb of many teeth. Built by hand, as only the
// labels matter: a square grid, cut along one diagonal.
TEST(VerifyRegions, OfALargeMeshAndLongPolygonsAreQuick) {
  constexpr std::uint32_t kSide = 256;
  constexpr FeatureId kComb = 1'000'000;
  GoodMesh good;
  io::IndexedMesh& mesh = good.files.mesh;
  for (std::uint32_t y = 0; y <= kSide; ++y) {
    for (std::uint32_t x = 0; x <= kSide; ++x) {
      mesh.vertices.push_back(
          {static_cast<double>(x), static_cast<double>(y), 0, y * 1000 + x + 1});
      good.features.push_back(Feature::Point(y * 1000 + x + 1, x, y));
    }
  }
  mesh.regions.polygons = {{kComb}};
  Rings teeth;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const std::uint32_t v = y * (kSide + 1) + x;
      mesh.triangles.push_back({v, v + 1, v + kSide + 2});
      mesh.triangles.push_back({v, v + kSide + 2, v + kSide + 1});
      const bool tooth = x % 2 == 1 && y % 2 == 1;
      mesh.regions.numbers.insert(mesh.regions.numbers.end(), 2, tooth ? 1 : 0);
      const auto id = [&](std::uint32_t dx, std::uint32_t dy) {
        return FeatureId{(y + dy) * 1000 + x + dx + 1};
      };
      if (tooth) teeth.push_back({id(0, 0), id(1, 0), id(1, 1), id(0, 1)});
    }
  }
  good.features.push_back(Feature::Polygon(kComb, teeth));
  EXPECT_EQ(CheckRegions(mesh, good.features).failures, 0U);
  mesh.regions.numbers[77'777] ^= 1;
  EXPECT_EQ(CheckRegions(mesh, good.features).failures, 1U);
}

}  // namespace
}  // namespace dynmesh::cli::regions_test
