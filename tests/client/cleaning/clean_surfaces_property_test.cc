// Random soups, cleaned: judged by an exact oracle and by the mesh's own validation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "client/cleaning/clean_surfaces.h"
#include "core/plc/rules.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "tests/client/cleaning/sampled_distance.h"
#include "tests/client/cleaning/surface_oracle.h"
#include "tests/client/cleaning/surface_soups.h"
#include "tests/support/nightly.h"

namespace dynmesh::cleaning {
namespace {

MeshOptions OptionsOf(const std::vector<Feature>& features) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = DefaultQuality(3);
  options.box = {{0, 0, 0}, {0, 0, 0}};
  for (const Feature& f : features) {
    if (f.kind != FeatureKind::kPoint) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      options.box.lo[k] = std::min(options.box.lo[k], f.position[k]);
      options.box.hi[k] = std::max(options.box.hi[k], f.position[k]);
    }
  }
  return options;
}

// What the mesh says: "", "small angle", or the message.
std::string VerdictOn(const std::vector<Feature>& features, const MeshOptions& options) {
  const auto mesh = DynamicMesh::Create(options);
  if (!mesh.ok()) return std::string(mesh.status().message());
  EditBatch batch;
  for (const Feature& f : features) batch.push_back(Edit::Add(f));
  const absl::Status status = (*mesh)->Validate(batch);
  if (status.ok()) return "";
  const auto detail = GetErrorDetail(status);
  if (detail && detail->reason == reason::kSmallAngle) return "small angle";
  return std::string(status.message());
}

struct Soup {
  std::string name;
  std::function<void(SoupMaker&)> make;
  // How far things may move, if more than some tolerances: faces that meet at less than 1.4e-6,
  // faces that are not flat, and the rounding errors of this test at needles.
  double reach = 0;
};

const std::vector<Soup>& Soups() {
  static const std::vector<Soup> soups = {
      {"two triangles", [](SoupMaker& m) { m.Triangles(2, 1); }},
      {"ten triangles", [](SoupMaker& m) { m.Triangles(10, 0.7); }},
      {"hundred triangles", [](SoupMaker& m) { m.Triangles(100, 0.2); }},
      {"thirty large ones", [](SoupMaker& m) { m.Triangles(30, 0.6); }},
      {"lattice", [](SoupMaker& m) { m.LatticeTriangles(25, 3); }},
      {"small lattice", [](SoupMaker& m) { m.LatticeTriangles(20, 2); }},
      {"axis-parallel", [](SoupMaker& m) { m.AxisParallel(40, 4); }},
      {"near coplanar 1e-6", [](SoupMaker& m) { m.NearCoplanar(15, 1e-6); }, 1e-5},
      {"near coplanar 1e-11", [](SoupMaker& m) { m.NearCoplanar(15, 1e-11); }, 1e-5},
      {"near coplanar 1e-13", [](SoupMaker& m) { m.NearCoplanar(15, 1e-13); }, 1e-5},
      {"needles 1e-3", [](SoupMaker& m) { m.Needles(20, 1e-3); }, 1e-8},
      {"needles 1e-8", [](SoupMaker& m) { m.Needles(20, 1e-8); }, 1e-8},
      {"needles 1e-12", [](SoupMaker& m) { m.Needles(20, 1e-12); }, 1e-8},
      {"boxes", [](SoupMaker& m) { m.Boxes(6, 0); }},
      {"boxes with cracks", [](SoupMaker& m) { m.Boxes(6, 1e-13); }},
      {"boxes askew", [](SoupMaker& m) { m.Boxes(5, 1e-3); }, 3e-3},
      {"repeated",
       [](SoupMaker& m) {
         m.Triangles(10, 0.5);
         m.Repeat(10);
       }},
      {"all",
       [](SoupMaker& m) {
         m.Triangles(10, 0.5);
         m.LatticeTriangles(10, 1);
         m.AxisParallel(10, 1);
         m.Needles(4, 1e-10);
         m.Repeat(5);
       },
       1e-8},
  };
  return soups;
}

SurfaceCleanOptions CleanOptionsOf(const MeshOptions& options) {
  SurfaceCleanOptions clean;
  clean.tolerance = 8 * plc::CloseLimit(options);
  return clean;
}

constexpr int kSeeds = 4;

TEST(CleanSurfaces, SoupsMeetInCornersAndEdgesOnly) {
  std::map<std::string, int> of_all;
  for (const Soup& soup : Soups()) {
    std::map<std::string, int> verdicts;
    std::size_t before = 0, after = 0;
    double widest = 1;
    const int seeds = test::IsNightly() ? 50 * kSeeds : kSeeds;
    for (int seed = 1; seed <= seeds; ++seed) {
      SCOPED_TRACE(soup.name + ", seed " + std::to_string(seed));
      SoupMaker maker(static_cast<std::uint64_t>(seed));
      soup.make(maker);
      const std::vector<Feature> input = maker.Features();
      const MeshOptions mesh_options = OptionsOf(input);
      const SurfaceCleanOptions options = CleanOptionsOf(mesh_options);
      const auto cleaned = CleanSurfaces(input, options);
      ASSERT_TRUE(cleaned.ok()) << cleaned.status();
      const PlainSurface plain = PlainOf(cleaned->features), was = PlainOf(input);
      EXPECT_EQ(FaultOf(plain), "");
      const double tolerance = cleaned->tolerance;
      const double reach = std::max(8 * tolerance, soup.reach);
      EXPECT_LT(FarthestFrom(plain, was), reach);
      PlainSurface with_area = was;
      std::erase_if(with_area.triangles, [&](const auto& t) { return HeightOf(t) < reach; });
      EXPECT_LT(FarthestFrom(with_area, plain), reach);
      ++verdicts[VerdictOn(cleaned->features, mesh_options)];
      before += was.triangles.size();
      after += plain.triangles.size();
      widest = std::max(widest, tolerance / options.tolerance);
      const auto again = CleanSurfaces(cleaned->features, options);
      ASSERT_TRUE(again.ok()) << again.status();
      EXPECT_EQ(again->features, cleaned->features);
      EXPECT_TRUE(again->changes.empty());
      const auto shuffled = CleanSurfaces(Shuffled(input, 99), options);
      ASSERT_TRUE(shuffled.ok()) << shuffled.status();
      EXPECT_TRUE(FacesOf(shuffled->features) == FacesOf(cleaned->features));
      // With edges of needles contracted.
      SurfaceCleanOptions contracting = options;
      contracting.most_contraction = 1e3 * options.tolerance;
      const auto contracted = CleanSurfaces(input, contracting);
      ASSERT_TRUE(contracted.ok()) << contracted.status();
      EXPECT_EQ(FaultOf(PlainOf(contracted->features)), "");
      const double moved = reach + 4 * contracting.most_contraction;
      EXPECT_LT(FarthestFrom(PlainOf(contracted->features), was), moved);
      const auto other_order = CleanSurfaces(Shuffled(input, 98), contracting);
      ASSERT_TRUE(other_order.ok()) << other_order.status();
      EXPECT_TRUE(FacesOf(other_order->features) == FacesOf(contracted->features));
    }
    std::cout << soup.name << ": " << before << " triangles become " << after
              << ", tolerance doubled to " << widest << " times at most;";
    for (const auto& [verdict, count] : verdicts) {
      std::cout << " " << (verdict.empty() ? "accepted" : verdict) << ": " << count << ";";
      of_all[verdict] += count;
    }
    std::cout << "\n";
  }
  for (const auto& [verdict, count] : of_all) {
    EXPECT_TRUE(verdict.empty() || verdict == "small angle") << verdict << ": " << count;
  }
}

TEST(CleanSurfaces, AThousandTrianglesAreNoWork) {
  for (std::uint64_t seed = 1; seed <= (test::IsNightly() ? 4 : 1); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SoupMaker maker(seed);
    maker.Triangles(1000, 0.15);
    const std::vector<Feature> input = maker.Features();
    const auto cleaned = CleanSurfaces(input, CleanOptionsOf(OptionsOf(input)));
    ASSERT_TRUE(cleaned.ok()) << cleaned.status();
    const PlainSurface plain = PlainOf(cleaned->features);
    EXPECT_GT(plain.triangles.size(), 5000U);
    EXPECT_EQ(FaultOf(plain), "");
    std::cout << "seed " << seed << ": " << plain.triangles.size() << " triangles, "
              << cleaned->rounds << " rounds\n";
  }
}

}  // namespace
}  // namespace dynmesh::cleaning
