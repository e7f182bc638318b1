// BuildOptions::only_inside: what the polygons enclose is as good as ever, and the rest has fewer
// vertices.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/part.h"
#include "dynmesh/quality.h"
#include "dynmesh/slot_mesh.h"
#include "tests/support/point_layouts.h"
#include "tests/support/surfaces.h"

namespace dynmesh::only_inside_test {
namespace {

MeshOptions Options(double min_dihedral = 10) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = kDefaultQuality3D;
  options.min_dihedral = min_dihedral;
  options.box = {{0, 0, 0}, {4, 4, 4}};
  return options;
}

Mesh Build(const std::vector<Feature>& features, const MeshOptions& options, bool only_inside) {
  BuildOptions build;
  build.only_inside = only_inside;
  const auto mesh = BuildMesh(features, options, build);
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return mesh.ok() ? *mesh : Mesh();
}

Mesh InsideOf(const Mesh& mesh) {
  const auto slots = SlotMesh::FromMesh(mesh);
  EXPECT_TRUE(slots.ok()) << slots.status();
  const auto part = MeshPart(*slots, {.inside = true}).ToMesh(*slots);
  EXPECT_TRUE(part.ok()) << part.status();
  return part.ok() ? *part : Mesh();
}

// A sphere of triangles between meridians, its corners moved in and out.
std::vector<Feature> BumpySphere(FeatureId first, std::array<double, 3> centre, double radius,
                                 std::uint64_t seed) {
  constexpr int kRows = 7, kAround = 12;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> bump(0.8, 1.2);
  std::vector<Feature> features;
  const auto add = [&](double up, double turn) {
    const double r = radius * bump(random), out = r * std::sin(up);
    features.push_back(Feature::Point(first++, centre[0] + out * std::cos(turn),
                                      centre[1] + out * std::sin(turn),
                                      centre[2] + r * std::cos(up)));
    return first - 1;
  };
  const FeatureId top = add(0, 0), bottom = add(std::numbers::pi, 0), rows = first;
  for (int i = 1; i < kRows; ++i) {
    for (int k = 0; k < kAround; ++k) {
      add(std::numbers::pi * i / kRows, 2 * std::numbers::pi * (k + 0.5 * (i % 2)) / kAround);
    }
  }
  const auto at = [&](int i, int k) {
    return rows + static_cast<FeatureId>((i - 1) * kAround + (k + kAround) % kAround);
  };
  const auto triangle = [&](FeatureId a, FeatureId b, FeatureId c) {
    features.push_back(Feature::Polygon(first++, {{a, b, c}}));
  };
  for (int k = 0; k < kAround; ++k) {
    triangle(top, at(1, k), at(1, k + 1));
    triangle(bottom, at(kRows - 1, k + 1), at(kRows - 1, k));
    for (int i = 1; i + 1 < kRows; ++i) {
      const int shift = i % 2;  // row i is half a step further if i is odd
      triangle(at(i, k), at(i + 1, k + shift), at(i, k + 1));
      triangle(at(i + 1, k), at(i + 1, k + 1), at(i, k + 1 - shift));
    }
  }
  return features;
}

void ExpectGoodInside(const std::vector<Feature>& features, const MeshOptions& options,
                      std::uint64_t* saved) {
  const Mesh whole = Build(features, options, false), mesh = Build(features, options, true);
  EXPECT_EQ(mesh.hash, ComputeHash(mesh));
  const QualityReport before = MeasureQuality(InsideOf(whole), options, features),
                      after = MeasureQuality(InsideOf(mesh), options, features);
  EXPECT_EQ(after.over_rho, after.exempt);
  EXPECT_LE(after.over_rho, before.over_rho + before.over_rho / 20 + 1);
  EXPECT_LE(after.below_dihedral, before.below_dihedral);
  // All of it keeps rho.
  const QualityReport all = MeasureQuality(mesh, options, features);
  EXPECT_EQ(all.over_rho, all.exempt);
  EXPECT_LE(mesh.vertices.size(), whole.vertices.size());
  *saved += whole.vertices.size() - mesh.vertices.size();
  // The order of features does not matter.
  std::vector<Feature> shuffled = features;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937_64(7));
  EXPECT_EQ(Build(shuffled, options, true).hash, mesh.hash);
}

TEST(OnlyInside, NoSliverStaysInside) {
  std::uint64_t saved = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    ExpectGoodInside(BumpySphere(1, {2, 2, 2}, 0.9, seed), Options(), &saved);
  }
  EXPECT_GT(saved, 30u);
}

TEST(OnlyInside, OfBoxesInBoxes) {
  std::uint64_t saved = 0;
  std::vector<Feature> features = test::BoxSurface(1, {1, 1, 1}, {2.7, 2.1, 1.6});
  const auto add = [&](const std::vector<Feature>& more) {
    features.insert(features.end(), more.begin(), more.end());
  };
  add(test::BoxSurface(101, {1.2, 1.3, 1.2}, {1.5, 1.6, 1.4}));
  add(test::BoxSurface(201, {1, 1, 2}, {1.05, 1.7, 2.6}));
  ExpectGoodInside(features, Options(20), &saved);
}

// Then all of it counts.
TEST(OnlyInside, IsTheSameWhereNothingIsEnclosed) {
  std::vector<Feature> open = BumpySphere(1, {2, 2, 2}, 0.9, 3);
  open.pop_back();
  EXPECT_EQ(Build(open, Options(), true).hash, Build(open, Options(), false).hash);
  std::vector<Feature> points;
  for (const auto& p : test::PointsOf<3>(test::Layout::kUniform, 200, 3)) {
    points.push_back(Feature::Point(points.size() + 1, p[0], p[1], p[2]));
  }
  MeshOptions unit = Options();
  unit.box = {{0, 0, 0}, {1, 1, 1}};
  EXPECT_EQ(Build(points, unit, true).hash, Build(points, unit, false).hash);
}

TEST(OnlyInside, IsIgnoredInThePlane) {
  std::vector<Feature> features = {Feature::Point(1, 0.2, 0.2), Feature::Point(2, 0.8, 0.2),
                                   Feature::Point(3, 0.5, 0.9), Feature::Polygon(4, {{1, 2, 3}})};
  MeshOptions plane;
  EXPECT_EQ(Build(features, plane, true).hash, Build(features, plane, false).hash);
}

}  // namespace
}  // namespace dynmesh::only_inside_test
