#include "client/cleaning/tolerance_field.h"

#include <algorithm>
#include <random>
#include <vector>

#include "gtest/gtest.h"

namespace dynmesh::cleaning {
namespace {

TEST(ToleranceField, IsTheLeastOneWithoutRepairs) {
  const ToleranceField field(0.5);
  EXPECT_EQ(field.At({1, 2, 3}), 0.5);
  EXPECT_EQ(field.most(), 0.5);
  EXPECT_EQ(field.MostIn({{-10, -10, -10}, {10, 10, 10}}), 0.5);
}

TEST(ToleranceField, DoublesNearAPlaceOnly) {
  ToleranceField field(0.01);
  field.RaiseAt({{{1, 0, 0}, 0}}, 12);
  EXPECT_EQ(field.At({1, 0, 0}), 0.02);
  EXPECT_EQ(field.At({1.1, 0.1, 0}), 0.02);
  EXPECT_EQ(field.At({1.5, 0, 0}), 0.01);
  EXPECT_EQ(field.MostIn({{0, 0, 0}, {0.9, 1, 1}}), 0.02);
  field.RaiseAt({{{1, 0, 0}, 0}}, 12);
  EXPECT_EQ(field.At({1, 0, 0}), 0.04);
  EXPECT_EQ(field.At({2, 0, 0}), 0.01);
  EXPECT_EQ(field.most_level(), 2);
}

TEST(ToleranceField, GoesAtOnceToWhatIsWantedUpToTheMostLevel) {
  ToleranceField field(0.01);
  field.RaiseAt({{{0, 0, 0}, 0.3}, {{100, 0, 0}, 1000}}, 8);
  EXPECT_EQ(field.At({0, 0, 0}), 0.32);
  EXPECT_EQ(field.At({100, 0, 0}), 0.01 * 256);
}

TEST(ToleranceField, IsRaisedAtEachPlaceWhateverTheirOrder) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> coordinate(0, 1);
  std::vector<StuckPlace> places;
  for (int i = 0; i < 200; ++i) {
    places.push_back({{coordinate(random), coordinate(random), coordinate(random)}, 0});
  }
  ToleranceField field(0.01), same(0.01);
  field.RaiseAt(places, 12);
  std::shuffle(places.begin(), places.end(), random);
  same.RaiseAt(places, 12);
  for (const StuckPlace& place : places) EXPECT_EQ(field.LevelAt(place.at), 1);
  for (int i = 0; i < 1000; ++i) {
    const Point3 p = {coordinate(random), coordinate(random), coordinate(random)};
    EXPECT_EQ(field.LevelAt(p), same.LevelAt(p));
  }
}

}  // namespace
}  // namespace dynmesh::cleaning
