// All that is in conflict, one at a time, and against validation that ends at the first one.
#include "core/plc/conflicts.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <set>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"
#include "tests/support/seed.h"

namespace dynmesh::plc::conflicts_test {
namespace {

using Ids = std::set<FeatureId>;

MeshOptions Options() {
  MeshOptions options;
  options.dimension = 3;
  options.quality = DefaultQuality(3);
  options.box = {{0, 0, 0}, {1, 1, 1}};
  return options;
}

Ids Found(const std::vector<Feature>& features, const Ids& looked_at, const Ids& fresh) {
  Ids told;
  FindConflicts(
      Options(), features, [&](FeatureId id) { return looked_at.contains(id); },
      [&](FeatureId id) { return fresh.contains(id); },
      [&](FeatureId id) { EXPECT_TRUE(told.insert(id).second) << id; });
  return told;
}

Ids Found(const std::vector<Feature>& features, const Ids& looked_at) {
  return Found(features, looked_at, looked_at);
}

Ids IdsOf(const std::vector<Feature>& features) {
  Ids ids;
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
    const Ids told = Found(features, IdsOf(features));
    EXPECT_EQ(told.empty(), is_legal) << "run " << run << ": " << status;
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
    const Ids all = Found(features, IdsOf(features));
    Ids some, of_all;
    for (const Feature& f : features) {
      if (f.kind == FeatureKind::kPolygon && random() % 10 == 0) some.insert(f.id);
      if (some.contains(f.id) && all.contains(f.id)) of_all.insert(f.id);
    }
    EXPECT_EQ(Found(features, some), of_all) << "run " << run;
    found += of_all.size();
  }
  EXPECT_GT(found, 100U);
}

// What all new ones have in conflict together is what each has by itself.
TEST(Conflicts, OnlyThoseWithANewFeatureAreFound) {
  std::mt19937 random(static_cast<std::mt19937::result_type>(test::NewSeed()));
  std::size_t found = 0, left_out = 0;
  for (int run = 0; run < 60; ++run) {
    const std::vector<Feature> features = Scene(random, 25);
    Ids looked_at, fresh, wanted;
    for (const Feature& f : features) {
      if (random() % 2 == 0) looked_at.insert(f.id);
      if (random() % 5 == 0) fresh.insert(f.id);
    }
    for (const FeatureId id : fresh) wanted.merge(Found(features, looked_at, {id}));
    EXPECT_EQ(Found(features, looked_at, fresh), wanted) << "run " << run;
    found += wanted.size();
    left_out += Found(features, looked_at, IdsOf(features)).size() - wanted.size();
  }
  EXPECT_GT(found, 100U);
  EXPECT_GT(left_out, 20U);
}

// Needles side by side at one corner, each pair at an angle too small.
TEST(Conflicts, OfAFanAllAreFound) {
  std::vector<Feature> features = {Feature::Point(1, 0.1, 0.1, 0.1)};
  constexpr FeatureId kNeedles = 300;
  for (FeatureId i = 0; i <= kNeedles; ++i) {
    features.push_back(Feature::Point(2 + i, 0.5 + 1e-3 * static_cast<double>(i), 0.1 + 1e-6, 0.1));
  }
  Ids needles;
  for (FeatureId i = 0; i < kNeedles; ++i) {
    features.push_back(Feature::Polygon(1000 + i, {{1, 2 + i, 3 + i}}));
    needles.insert(1000 + i);
  }
  EXPECT_EQ(Found(features, needles), needles);
}

TEST(Conflicts, FeaturesThatAreIllegalByThemselvesAreTold) {
  std::vector<Feature> features = {Feature::Point(1, 0, 0, 0), Feature::Point(2, 1, 0, 0),
                                   Feature::Point(3, 1, 1, 0), Feature::Point(4, 0, 1, 0.1),
                                   Feature::Polygon(5, {{1, 2, 3, 4}})};
  EXPECT_EQ(Found(features, IdsOf(features)), Ids{5});
  features.back() = Feature::Polygon(5, {{1, 2, 1}});
  EXPECT_EQ(Found(features, IdsOf(features)), Ids{5});
}

// An edge of two polygons is one of both.
TEST(Conflicts, AnEdgeIsReportedAsEachOfItsPolygons) {
  const std::vector<Feature> features = {
      Feature::Point(1, 0.2, 0.2, 0.2), Feature::Point(2, 0.8, 0.2, 0.2),
      Feature::Point(3, 0.5, 0.8, 0.2), Feature::Point(4, 0.5, 0.2, 0.8),
      Feature::Point(5, 0.5, 0.2, 0.2), Feature::Polygon(6, {{1, 2, 3}}),
      Feature::Polygon(7, {{1, 2, 4}})};
  EXPECT_EQ(Found(features, {5, 6, 7}), (Ids{5, 6, 7}));
  EXPECT_EQ(Found(features, {6}), Ids{6});
  EXPECT_EQ(Found(features, {6, 7}, {5}), (Ids{6, 7}));
}

}  // namespace
}  // namespace dynmesh::plc::conflicts_test
