// Features made of faces, and merged; for the tests of merge_coplanar.
#ifndef DYNMESH_TESTS_CORE_COPLANAR_MERGE_COPLANAR_UTIL_H_
#define DYNMESH_TESTS_CORE_COPLANAR_MERGE_COPLANAR_UTIL_H_

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <set>
#include <vector>

#include "core/coplanar/merge_coplanar.h"
#include "dynmesh/feature.h"
#include "tests/core/coplanar/face_soup.h"
#include "tests/support/seed.h"

namespace dynmesh::coplanar {

inline std::mt19937 NewRandom() { return std::mt19937(test::NewSeed()); }

// As the points of a FaceSoup.
inline std::vector<Feature> Points(const std::vector<testing::Place>& places) {
  testing::FaceSoup soup;
  soup.points = places;
  return soup.Features();
}

// Adds a polygon for each face.
inline std::vector<Feature> With(std::vector<Feature> features, const std::vector<Rings>& faces) {
  for (const Rings& rings : faces) {
    features.push_back(Feature::Polygon(features.size() + 1, rings));
  }
  return features;
}

inline std::vector<Feature> Without(std::vector<Feature> features, const std::set<FeatureId>& ids) {
  std::erase_if(features, [&](const Feature& f) { return ids.contains(f.id); });
  return features;
}

inline std::vector<Feature> Merged(const std::vector<Feature>& features, double tolerance = 0) {
  const auto merged = MergeCoplanar(features, tolerance);
  EXPECT_TRUE(merged.ok()) << merged.status();
  return merged.ok() ? *merged : std::vector<Feature>();
}

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_TESTS_CORE_COPLANAR_MERGE_COPLANAR_UTIL_H_
