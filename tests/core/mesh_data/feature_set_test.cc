// Sets of features against a map, and edits between two of them against applying these.
#include "core/mesh_data/feature_set.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <random>

#include "absl/strings/str_cat.h"
#include "tests/support/seed.h"

namespace dynmesh::mesh_data {
namespace {

using Model = std::map<FeatureId, Feature>;

std::vector<Feature> Listed(const Model& model) {
  std::vector<Feature> all;
  for (const auto& [id, feature] : model) all.push_back(feature);
  return all;
}

// Of few values, so that two are often the same.
Feature RandomFeature(FeatureId id, std::mt19937_64& random) {
  const auto few = [&] { return static_cast<double>(random() % 3); };
  switch (random() % 5) {
    case 0:
      return Feature::Point(id, few(), few(), few());
    case 1:
      return Feature::Segment(id, 1 + random() % 3, 4);
    case 2:
      return Feature::Polygon(id, {{1, 2, 3 + random() % 2}});
    case 3:
      return Feature::SizeDisc(id, few(), few(), few(), 1);
    default:
      return Feature::SizePolygon(id, {{1, 2, 3 + random() % 2}}, 1 + few());
  }
}

TEST(FeatureSet, ActsAsAMapAndIsMadeOfAnyOther) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  std::mt19937_64 random(seed);
  FeatureSet set;
  Model model;
  std::vector<std::vector<Feature>> past = {{}};
  for (int step = 0; step < 200; ++step) {
    EditBatch batch;
    for (std::size_t i = random() % 8; i > 0; --i) {
      Feature feature = RandomFeature(1 + random() % 12, random);
      if (random() % 2 == 0) feature.label = {static_cast<std::int64_t>(random() % 3), ""};
      const auto it = model.find(feature.id);
      if (it != model.end() && random() % 3 == 0) {
        batch.push_back(Edit::SetLabel(feature.id, *feature.label));
        it->second.label = feature.label;
        continue;
      }
      if (it == model.end()) {
        batch.push_back(Edit::Add(feature));
        model.emplace(feature.id, feature);
      } else if (random() % 3 == 0) {
        batch.push_back(Edit::Remove(feature.id));
        model.erase(it);
      } else if (it->second.kind == FeatureKind::kPoint && random() % 2 == 0) {
        batch.push_back(Edit::Move(feature.id, 5, 6, 7));
        it->second.position = {5, 6, 7};
      } else {
        batch.push_back(Edit::Set(feature));
        const OptionalLabel label = it->second.label;
        it->second = feature;
        if (!feature.label) it->second.label = label;
      }
    }
    ASSERT_TRUE(set.Apply(batch).ok());
    ASSERT_EQ(set.size(), model.size());
    const std::vector<Feature> now = set.Sorted();
    ASSERT_EQ(now, Listed(model));

    const std::vector<Feature>& then = past[random() % past.size()];
    const EditBatch back = EditsBetween(now, then);
    std::size_t same = 0;
    for (const Feature& f : then) same += model.contains(f.id) && model.at(f.id) == f;
    EXPECT_EQ(back.empty(), now == then);
    // No edit of what is the same, one of each other; two where a set is to clear the label.
    std::size_t either = model.size(), cleared = 0;
    for (const Feature& f : then) {
      either += !model.contains(f.id);
      if (!model.contains(f.id) || f.label || !model.at(f.id).label) continue;
      Feature bare = model.at(f.id);
      bare.label = {};
      cleared += bare != f;
    }
    EXPECT_EQ(back.size(), either - same + cleared);
    FeatureSet other = set;
    ASSERT_TRUE(other.Apply(back).ok());
    ASSERT_EQ(other.Sorted(), then);
    past.push_back(now);
  }
}

TEST(FeatureSet, RefusesWhatCannotAct) {
  FeatureSet set;
  ASSERT_TRUE(set.Apply({Edit::Add(Feature::Point(1, 0, 0))}).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(set.Apply({Edit::Add(Feature::Point(1, 0, 0))})));
  EXPECT_TRUE(absl::IsNotFound(set.Apply({Edit::Set(Feature::Point(2, 0, 0))})));
  EXPECT_TRUE(absl::IsNotFound(set.Apply({Edit::Move(2, 0, 0)})));
  EXPECT_TRUE(absl::IsNotFound(set.Apply({Edit::Remove(2)})));
  EXPECT_TRUE(absl::IsNotFound(set.Apply({Edit::SetLabel(2, {})})));
  EXPECT_EQ(set.size(), 1u);
}

}  // namespace
}  // namespace dynmesh::mesh_data
