// All conflicts at once, against all pairs, and against validation that ends at the first one.
#include "core/plc/conflicts.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"
#include "tests/support/seed.h"

namespace dynmesh::plc::conflicts_test {
namespace {

using Pairs = std::set<std::pair<FeatureId, FeatureId>>;

MeshOptions Options() {
  MeshOptions options;
  options.dimension = 3;
  options.quality = DefaultQuality(3);
  options.box = {{0, 0, 0}, {1, 1, 1}};
  return options;
}

Pairs Found(const std::vector<Feature>& features, const std::set<FeatureId>& looked_at) {
  Pairs pairs;
  FindConflicts(
      Options(), features, [&](FeatureId id) { return looked_at.contains(id); },
      [&](FeatureId f, FeatureId g) { pairs.insert(std::minmax(f, g)); });
  return pairs;
}

std::set<FeatureId> IdsOf(const std::vector<Feature>& features) {
  std::set<FeatureId> ids;
  for (const Feature& f : features) ids.insert(f.id);
  return ids;
}

// Triangles, some with common corners and edges, and segments; small ones, so that some are legal.
std::vector<Feature> Scene(std::mt19937& random, std::size_t triangles) {
  std::vector<Feature> features;
  std::uniform_real_distribution<double> place(0.2, 0.8), step(-0.2, 0.2);
  std::vector<FeatureId> points;
  FeatureId id = 0;
  const auto point = [&](double x, double y, double z) {
    features.push_back(Feature::Point(++id, x, y, z));
    return id;
  };
  for (std::size_t i = 0; i < triangles; ++i) {
    const double x = place(random), y = place(random), z = place(random);
    std::vector<FeatureId> ring;
    for (int k = 0; k < 3; ++k) {
      const bool is_shared = points.size() > 3 && random() % 4 == 0;
      const FeatureId corner = is_shared
                                   ? points[random() % points.size()]
                                   : point(x + step(random), y + step(random), z + step(random));
      ring.push_back(corner);
    }
    points.insert(points.end(), ring.begin(), ring.end());
    if (std::set<FeatureId>(ring.begin(), ring.end()).size() < 3) continue;
    if (random() % 5 == 0) {
      features.push_back(Feature::Segment(++id, ring[0], ring[1]));
    } else {
      features.push_back(Feature::Polygon(++id, {ring}));
    }
  }
  return features;
}

TEST(Conflicts, AreThereIfAndOnlyIfValidationRefuses) {
  std::mt19937 random(static_cast<std::mt19937::result_type>(test::NewSeed()));
  int good = 0, bad = 0;
  for (int run = 0; run < 400; ++run) {
    const std::vector<Feature> features = Scene(random, 1 + random() % 8);
    const Plc3 complex(Options());
    const absl::Status status = complex.Check(AddAll(features)).status();
    // How many vertices a mesh needs is no conflict.
    const bool is_legal = status.ok() || absl::IsResourceExhausted(status);
    const Pairs pairs = Found(features, IdsOf(features));
    EXPECT_EQ(pairs.empty(), is_legal) << "run " << run << ": " << status;
    ++(is_legal ? good : bad);
  }
  EXPECT_GT(good, 20);
  EXPECT_GT(bad, 20);
}

// Features that are not looked at and far away are left out; what is found is not.
TEST(Conflicts, OfSomeAreThoseOfAllThatConcernThem) {
  std::mt19937 random(static_cast<std::mt19937::result_type>(test::NewSeed()));
  std::size_t found = 0;
  for (int run = 0; run < 100; ++run) {
    const std::vector<Feature> features = Scene(random, 40);
    const Pairs all = Found(features, IdsOf(features));
    std::set<FeatureId> some;
    for (const Feature& f : features) {
      if (f.kind == FeatureKind::kPolygon && random() % 10 == 0) some.insert(f.id);
    }
    const Pairs of_some = Found(features, some);
    for (const auto& pair : of_some) EXPECT_TRUE(all.contains(pair));
    for (const auto& [f, g] : all) {
      if (!some.contains(f) && !some.contains(g)) continue;
      ++found;
      EXPECT_TRUE(of_some.contains({f, g})) << "run " << run << ": " << f << ", " << g;
    }
  }
  EXPECT_GT(found, 100U);
}

TEST(Conflicts, FeaturesThatAreIllegalByThemselvesAreTold) {
  std::vector<Feature> features = {Feature::Point(1, 0, 0, 0), Feature::Point(2, 1, 0, 0),
                                   Feature::Point(3, 1, 1, 0), Feature::Point(4, 0, 1, 0.1),
                                   Feature::Polygon(5, {{1, 2, 3, 4}})};
  EXPECT_EQ(Found(features, IdsOf(features)), (Pairs{{5, 5}}));
  features.back() = Feature::Polygon(5, {{1, 2, 1}});
  EXPECT_EQ(Found(features, IdsOf(features)), (Pairs{{5, 5}}));
}

// An edge of two polygons is one of both.
TEST(Conflicts, AnEdgeIsReportedAsEachOfItsPolygons) {
  const std::vector<Feature> features = {
      Feature::Point(1, 0.2, 0.2, 0.2), Feature::Point(2, 0.8, 0.2, 0.2),
      Feature::Point(3, 0.5, 0.8, 0.2), Feature::Point(4, 0.5, 0.2, 0.8),
      Feature::Point(5, 0.5, 0.2, 0.2), Feature::Polygon(6, {{1, 2, 3}}),
      Feature::Polygon(7, {{1, 2, 4}})};
  const Pairs pairs = Found(features, {5});
  EXPECT_TRUE(pairs.contains({5, 6}));
  EXPECT_TRUE(pairs.contains({5, 7}));
}

}  // namespace
}  // namespace dynmesh::plc::conflicts_test
