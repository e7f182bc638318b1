// Surfaces that are finer than their shape needs get fewer faces: within the distance, accepted,
// closed as before, and from the shape alone.
#include "client/preparation/thinning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <set>
#include <string>

#include "client/preparation/farthest.h"
#include "client/preparation/prepare.h"
#include "dynmesh/dynamic_mesh.h"
#include "gtest/gtest.h"
#include "tests/client/preparation/solids.h"
#include "tests/support/nightly.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::preparation {
namespace {

using test::Solid;

// Round the z axis: the heights and radii of its rings, with `sides` points each. The radii at both
// ends are 0.
Solid TurnedSolid(const std::vector<std::array<double, 2>>& rings, std::size_t sides) {
  Solid solid;
  for (std::size_t r = 1; r + 1 < rings.size(); ++r) {
    for (std::size_t i = 0; i < sides; ++i) {
      const double angle =
          2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(sides);
      solid.points.push_back(
          {rings[r][1] * std::cos(angle), rings[r][1] * std::sin(angle), rings[r][0]});
    }
  }
  const std::size_t bottom = solid.points.size(), top = bottom + 1;
  solid.points.push_back({0, 0, rings.front()[0]});
  solid.points.push_back({0, 0, rings.back()[0]});
  const std::size_t last = (rings.size() - 3) * sides;
  for (std::size_t i = 0; i < sides; ++i) {
    const std::size_t j = (i + 1) % sides;
    solid.faces.push_back({bottom, j, i});
    solid.faces.push_back({top, last + i, last + j});
    for (std::size_t at = 0; at < last; at += sides) {
      solid.faces.push_back({at + i, at + j, at + sides + j});
      solid.faces.push_back({at + i, at + sides + j, at + sides + i});
    }
  }
  return solid;
}

Solid FineSphere(std::size_t bands, std::size_t sides) {
  std::vector<std::array<double, 2>> rings;
  for (std::size_t r = 0; r <= bands; ++r) {
    const double angle = std::numbers::pi * static_cast<double>(r) / static_cast<double>(bands);
    rings.push_back({-std::cos(angle), r == 0 || r == bands ? 0 : std::sin(angle)});
  }
  return TurnedSolid(rings, sides);
}

// Radius 1, height 2.
Solid Cylinder(std::size_t sides) { return TurnedSolid({{-1, 0}, {-1, 1}, {1, 1}, {1, 0}}, sides); }

class ThinningTest : public ::testing::Test {
 protected:
  Prepared Of(const Solid& solid, PrepareOptions options = {}, bool keep_facets = false) {
    path_ = folder_.Write("s.off", solid.Off());
    io::GeometryOptions reading;
    reading.keep_facets = keep_facets;
    absl::StatusOr<Prepared> prepared = Prepare(path_, reading, options);
    EXPECT_TRUE(prepared.ok()) << prepared.status();
    return prepared.ok() ? *std::move(prepared) : Prepared();
  }
  void ExpectNearAndAccepted(const Solid& solid, const Prepared& prepared) {
    const Report& report = prepared.report;
    EXPECT_LE(report.farthest, report.within * (1 + 1e-9));
    const std::vector<Feature> given = solid.Features();
    const double most = 1.01 * report.within;  // joining moves by roundings
    EXPECT_TRUE(FarthestBound(given, prepared.geometry.features, 3, most / 8, most));
    EXPECT_TRUE(FarthestBound(prepared.geometry.features, given, 3, most / 8, most));
    const auto mesh = DynamicMesh::Create(prepared.geometry.options);
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    const absl::Status accepted = (*mesh)->Validate(AddAll(prepared.geometry.features));
    EXPECT_TRUE(accepted.ok()) << accepted;
  }
  static std::size_t Polygons(const Prepared& prepared) {
    return static_cast<std::size_t>(
        std::ranges::count(prepared.geometry.features, FeatureKind::kPolygon, &Feature::kind));
  }

  test::TempFolder folder_;
  std::string path_;
};

TEST_F(ThinningTest, AFineSphereGetsFewerFacesWithinTheDistance) {
  const Solid sphere = FineSphere(60, 120);
  const Prepared prepared = Of(sphere);
  EXPECT_TRUE(prepared.report.is_thinned);
  EXPECT_FALSE(prepared.report.is_mended);
  EXPECT_LT(Polygons(prepared), sphere.faces.size() / 2);
  EXPECT_EQ(prepared.report.open_edges_after, 0U);
  ExpectNearAndAccepted(sphere, prepared);
  const Prepared coarser = Of(sphere, {0.05});
  EXPECT_LT(Polygons(coarser), Polygons(prepared) / 4);
  ExpectNearAndAccepted(sphere, coarser);
}

TEST_F(ThinningTest, ACoarseSphereStays) {
  const Prepared prepared = Of(FineSphere(8, 12));
  EXPECT_FALSE(prepared.report.is_thinned);
  EXPECT_EQ(prepared.report.farthest, 0);
  EXPECT_EQ(prepared.geometry.features, io::ReadGeometry(path_)->features);
}

TEST_F(ThinningTest, FacesAreKeptOnRequest) {
  const Solid sphere = FineSphere(60, 120);
  const Prepared prepared = Of(sphere, {}, /*keep_facets=*/true);
  EXPECT_FALSE(prepared.report.is_thinned);
  EXPECT_EQ(Polygons(prepared), sphere.faces.size());
}

TEST_F(ThinningTest, TheRimOfACylinderStaysARim) {
  const Solid cylinder = Cylinder(400);
  const Prepared prepared = Of(cylinder);
  EXPECT_TRUE(prepared.report.is_thinned);
  ExpectNearAndAccepted(cylinder, prepared);
  // Each end is one polygon still, of fewer corners, which are some of those that it had.
  std::map<FeatureId, std::array<double, 3>> at;
  const std::set<std::array<double, 3>> given(cylinder.points.begin(), cylinder.points.end());
  std::size_t ends = 0;
  for (const Feature& f : prepared.geometry.features) {
    if (f.kind == FeatureKind::kPoint) {
      at[f.id] = f.position;
      EXPECT_TRUE(given.contains(f.position));
    } else if (f.rings.front().size() > 20) {
      ++ends;
      EXPECT_LT(f.rings.front().size(), 300U);
      const double z = at.at(f.rings.front().front())[2];
      EXPECT_EQ(std::abs(z), 1);
      for (const FeatureId id : f.rings.front()) EXPECT_EQ(at.at(id)[2], z);
    }
  }
  EXPECT_EQ(ends, 2U);
}

TEST_F(ThinningTest, AnOpenSurfaceKeepsItsBorderWithinTheDistance) {
  Solid half = FineSphere(60, 120);
  std::erase_if(half.faces, [&](const auto& face) {
    return std::ranges::any_of(face, [&](std::size_t i) { return half.points[i][2] < -1e-9; });
  });
  std::vector<std::size_t> number(half.points.size(), half.points.size());
  Solid used;
  for (auto& face : half.faces) {
    for (std::size_t& corner : face) {
      if (number[corner] == half.points.size()) {
        number[corner] = used.points.size();
        used.points.push_back(half.points[corner]);
      }
      corner = number[corner];
    }
  }
  used.faces = half.faces;
  const Prepared prepared = Of(used);
  EXPECT_TRUE(prepared.report.is_thinned);
  EXPECT_EQ(prepared.report.open_edges, 120U);
  ExpectNearAndAccepted(used, prepared);
  // With a larger distance its border is thinned, too.
  const Prepared coarser = Of(used, {0.05});
  ASSERT_EQ(coarser.report.open_loops.size(), 1U);
  EXPECT_EQ(coarser.report.open_edges_after, coarser.report.open_loops[0].corners.size());
  EXPECT_LT(coarser.report.open_edges_after, 120U);
  // Filled, it is a polygon, and nothing is open.
  const Prepared filled = Of(used, {.fill_holes = 7.0});
  EXPECT_TRUE(filled.report.is_thinned);
  EXPECT_EQ(filled.report.open_edges_after, 0U) << filled.report.unfilled;
}

// By chance: a turned body with smooth and sharp parts, whose points are a little off.
Solid RandomBody(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<std::array<double, 2>> rings = {{0, 0}};
  double z = 0, radius = 0.3 + unit(random);
  const auto bands = 4 + static_cast<int>(30 * unit(random));
  rings.push_back({0, radius});
  for (int i = 0; i < bands; ++i) {
    z += unit(random) < 0.1 ? 0.5 : 0.01 + 0.02 * unit(random);
    radius = std::max(0.1, radius + (unit(random) < 0.1 ? 0.3 : 0.01) * (unit(random) - 0.5));
    rings.push_back({z, radius});
  }
  rings.push_back({z, 0});
  Solid body = TurnedSolid(rings, 20 + static_cast<std::size_t>(100 * unit(random)));
  const double noise = unit(random) < 0.5 ? 0 : 1e-6;
  for (auto& point : body.points) {
    for (double& x : point) x += noise * (unit(random) - 0.5);
  }
  return body;
}

TEST(ThinningProperty, BodiesAreAcceptedAndNearWhateverTheirOrder) {
  std::mt19937_64 random(test::NewSeed());
  const int runs = test::IsNightly() ? 300 : 12;
  const test::TempFolder folder;
  int thinned = 0;
  for (int run = 0; run < runs; ++run) {
    Solid body = RandomBody(random);
    const auto prepare = [&](const Solid& solid) {
      return Prepare(folder.Write("s.off", solid.Off()), {}, {});
    };
    const auto prepared = prepare(body);
    ASSERT_TRUE(prepared.ok()) << run << prepared.status();
    const Report& report = prepared->report;
    if (!report.is_thinned) continue;
    ++thinned;
    EXPECT_EQ(report.open_edges_after, 0U) << run;
    const double most = 1.01 * report.within;
    const std::vector<Feature> given = body.Features();
    const std::vector<Feature>& features = prepared->geometry.features;
    EXPECT_TRUE(FarthestBound(given, features, 3, most / 8, most)) << run;
    EXPECT_TRUE(FarthestBound(features, given, 3, most / 8, most)) << run;
    const auto mesh = DynamicMesh::Create(prepared->geometry.options);
    ASSERT_TRUE(mesh.ok()) << run << mesh.status();
    const absl::Status accepted = (*mesh)->Validate(AddAll(features));
    EXPECT_TRUE(accepted.ok()) << run << accepted;
    const auto places = [](const Prepared& of) {
      std::multiset<std::array<double, 3>> points;
      for (const Feature& f : of.geometry.features) {
        if (f.kind == FeatureKind::kPoint) points.insert(f.position);
      }
      return points;
    };
    std::ranges::shuffle(body.faces, random);
    for (auto& face : body.faces) std::ranges::rotate(face, face.begin() + 1);
    const auto other = prepare(body);
    ASSERT_TRUE(other.ok()) << run << other.status();
    EXPECT_EQ(places(*other), places(*prepared)) << run;
  }
  EXPECT_GT(thinned, runs / 4);
}

}  // namespace
}  // namespace dynmesh::preparation
