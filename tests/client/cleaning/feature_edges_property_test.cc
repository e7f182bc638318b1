// Curved and rough surfaces, made coarse: judged by samples, by exact intersections of all pairs,
// and by a mesh's own validation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/cleaning/clean_surfaces.h"
#include "client/cleaning/feature_edges.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/client/cleaning/sampled_distance.h"
#include "tests/client/cleaning/surface_oracle.h"
#include "tests/client/cleaning/test_surfaces.h"
#include "tests/support/nightly.h"

namespace dynmesh::cleaning::feature_edges_property_test {
namespace {

constexpr double kTolerance = 1e-10;

struct Counts {
  std::map<std::size_t, std::size_t> edges;  // by number of faces
  long long euler = 0;
  double least_angle = 180;  // of faces, in degrees
};

Counts CountsOf(const PlainSurface& surface) {
  std::map<std::set<Place3>, std::size_t> edges;
  std::set<Place3> corners;
  Counts counts;
  for (const auto& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      ++edges[{t[i], t[(i + 1) % 3]}];
      corners.insert(t[i]);
      const Place3 u = Difference(t[(i + 1) % 3], t[i]), w = Difference(t[(i + 2) % 3], t[i]);
      const double angle = std::acos(Dot(u, w) / std::sqrt(Dot(u, u) * Dot(w, w)));
      counts.least_angle = std::min(counts.least_angle, angle * 180 / std::numbers::pi);
    }
  }
  for (const auto& [edge, count] : edges) ++counts.edges[count];
  counts.euler = static_cast<long long>(corners.size()) - static_cast<long long>(edges.size()) +
                 static_cast<long long>(surface.triangles.size());
  return counts;
}

// Is no edge passed twice in one direction?
bool IsOriented(const PlainSurface& surface) {
  std::set<std::pair<Place3, Place3>> edges;
  for (const auto& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (!edges.insert({t[i], t[(i + 1) % 3]}).second) return false;
    }
  }
  return true;
}

// Of edges with two faces, in degrees, at most.
double SharpestOf(const PlainSurface& surface) {
  std::map<std::set<Place3>, std::vector<Place3>> apexes;
  for (const auto& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      apexes[{t[i], t[(i + 1) % 3]}].push_back(t[(i + 2) % 3]);
    }
  }
  double most = 0;
  for (const auto& [edge, of] : apexes) {
    if (of.size() != 2) continue;
    const Place3 &a = *edge.begin(), d = Difference(*edge.rbegin(), a);
    const auto beside = [&](const Place3& p) {  // square to the edge
      const Place3 w = Difference(p, a);
      const double t = Dot(w, d) / Dot(d, d);
      return Place3{w[0] - t * d[0], w[1] - t * d[1], w[2] - t * d[2]};
    };
    const Place3 u = beside(of[0]), w = beside(of[1]);
    const double cosine = std::clamp(Dot(u, w) / std::sqrt(Dot(u, u) * Dot(w, w)), -1.0, 1.0);
    most = std::max(most, 180 - std::acos(cosine) * 180 / std::numbers::pi);
  }
  return most;
}

bool IsAccepted(const std::vector<Feature>& features) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = DefaultQuality(3);
  options.box = {{-2, -2, -2}, {2, 2, 2}};
  const auto mesh = DynamicMesh::Create(options);
  EditBatch batch;
  for (const Feature& f : features) batch.push_back(Edit::Add(f));
  const absl::Status status = (*mesh)->Validate(batch);
  EXPECT_TRUE(status.ok()) << status;
  return status.ok();
}

struct Case {
  std::string name;
  std::function<void(SurfaceMaker&, std::uint64_t seed)> make;
  double angle = 0, within = 0;
  double most_left = 0;  // of the triangles
  bool has_planes = false;
};

const std::vector<Case>& Cases() {
  static const std::vector<Case> cases = {
      {"sphere", [](SurfaceMaker& m, std::uint64_t) { m.AddSphere(14); }, 40, 0.02, 0.3},
      {"sphere, far", [](SurfaceMaker& m, std::uint64_t) { m.AddSphere(10); }, 60, 0.2, 0.1},
      {"sphere, small angle", [](SurfaceMaker& m, std::uint64_t) { m.AddSphere(10); }, 20, 0.2,
       0.9},
      {"cylinder", [](SurfaceMaker& m, std::uint64_t) { m.AddCylinder(48, true); }, 40, 0.02, 0.25,
       true},
      {"open cylinder", [](SurfaceMaker& m, std::uint64_t) { m.AddCylinder(48, false); }, 40, 0.02,
       0.25, true},
      {"smooth terrain", [](SurfaceMaker& m, std::uint64_t s) { m.AddTerrain(32, 0.0005, s); }, 30,
       0.004, 0.4},
      {"rough terrain", [](SurfaceMaker& m, std::uint64_t s) { m.AddTerrain(32, 0.01, s); }, 50,
       0.02, 0.6},
      {"rough terrain, far", [](SurfaceMaker& m, std::uint64_t s) { m.AddTerrain(24, 0.03, s); },
       80, 0.1, 0.8},
  };
  return cases;
}

TEST(FeatureEdges, SurfacesStayNearClosedAndWithoutNeedles) {
  const std::uint64_t seeds = test::IsNightly() ? 20 : 1;
  int oriented = 0;
  for (const Case& c : Cases()) {
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      SCOPED_TRACE(c.name + ", seed " + std::to_string(seed));
      SurfaceMaker maker;
      c.make(maker, seed);
      const std::vector<Feature> input = maker.Features();
      FeatureEdgeOptions options;
      options.angle = c.angle;
      options.within = c.within;
      options.tolerance = kTolerance;
      const auto kept = KeepFeatureEdges(input, options);
      ASSERT_TRUE(kept.ok()) << kept.status();
      const PlainSurface was = PlainOf(input), now = PlainOf(kept->features);
      EXPECT_LT(now.triangles.size(), c.most_left * static_cast<double>(was.triangles.size()));
      EXPECT_EQ(FaultOf(now), "");
      const double there = FarthestFrom(now, was), back = FarthestFrom(was, now);
      EXPECT_LE(there, c.within * (1 + 1e-9));
      EXPECT_LE(back, c.within * (1 + 1e-9));
      const Counts before = CountsOf(was), after = CountsOf(now);
      EXPECT_EQ(after.euler, before.euler);
      EXPECT_EQ(after.edges.contains(1), before.edges.contains(1));
      EXPECT_FALSE(after.edges.contains(3));
      EXPECT_GE(after.least_angle, std::min(c.has_planes ? 10.0 : 20.0, before.least_angle) - 1e-9);
      oriented += IsOriented(was) ? 1 : 0;
      EXPECT_TRUE(!IsOriented(was) || IsOriented(now));
      if (kept->sharp_edges == 0) {
        EXPECT_LE(SharpestOf(now), c.angle + 1e-9);
      }
      EXPECT_TRUE(IsAccepted(kept->features));
      // What is there, was there.
      const std::set<Place3> places(was.points.begin(), was.points.end());
      for (const Place3& p : now.points) EXPECT_TRUE(places.contains(p));
      // Cleaning changes nothing.
      SurfaceCleanOptions clean;
      clean.tolerance = kTolerance;
      const auto cleaned = CleanSurfaces(kept->features, clean);
      ASSERT_TRUE(cleaned.ok()) << cleaned.status();
      EXPECT_TRUE(cleaned->changes.empty());
      EXPECT_EQ(cleaned->features, kept->features);
      for (const std::uint64_t shuffle : {seed + 98, seed + 7}) {
        const auto shuffled = KeepFeatureEdges(Shuffled(input, shuffle), options);
        ASSERT_TRUE(shuffled.ok()) << shuffled.status();
        EXPECT_TRUE(FacesOf(shuffled->features) == FacesOf(kept->features)) << shuffle;
      }
      std::cout << c.name << ", seed " << seed << ": " << was.triangles.size() << " become "
                << now.triangles.size() << ", " << kept->sharp_edges << " sharp edges, within "
                << std::max(there, back) << " of " << c.within << ", least angle "
                << after.least_angle << "\n";
    }
  }
  EXPECT_GT(oriented, 3);
}

}  // namespace
}  // namespace dynmesh::cleaning::feature_edges_property_test
