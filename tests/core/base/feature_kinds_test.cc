#include "core/base/feature_kinds.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace dynmesh::feature_kinds_test {
namespace {

// One of each kind, in the order of AllKinds, and one of no kind.
std::vector<Feature> Examples() {
  std::vector<Feature> all = {Feature::Point(1, 0.25, 0.5), Feature::Segment(2, 11, 12),
                              Feature::Polygon(3, {{11, 12, 13}, {14, 15, 16}}),
                              Feature::SizePolygon(4, {{17, 18, 19}}, 0.125)};
  all.push_back(all.front());
  all.back().kind = static_cast<FeatureKind>(77);
  return all;
}

std::string Describe(const Feature& f) {
  return Visit(
      f, [](const APoint& p) { return "point " + std::to_string(p.position[1]).substr(0, 3); },
      [](const ASegment& s) { return "segment " + std::to_string(s.ends[1]); },
      [](const APolygon& p) { return "polygon " + std::to_string(p.rings.size()); },
      [](const ASize& s) {
        return "size " + std::to_string(s.sizing.target).substr(0, 5) + " " +
               std::to_string(s.rings.size());
      });
}

TEST(FeatureKinds, VisitCallsTheCaseOfTheKind) {
  std::vector<std::string> said;
  for (const Feature& f : Examples()) said.push_back(Describe(f));
  EXPECT_EQ(said,
            (std::vector<std::string>{"point 0.5", "segment 12", "polygon 2", "size 0.125 1", ""}));
}

TEST(FeatureKinds, IgnoredKindsDoNothing) {
  std::vector<FeatureId> visited;
  for (const Feature& f : Examples()) {
    Visit(
        f, [&](const APolygon& p) { visited.push_back(p.id); }, Ignore<APoint, ASegment>,
        [&](const ASize& s) { visited.push_back(s.id); });
  }
  EXPECT_EQ(visited, (std::vector<FeatureId>{3, 4}));
}

TEST(FeatureKinds, IsOneOfTheChosenKinds) {
  std::vector<FeatureId> found;
  for (const Feature& f : Examples()) {
    EXPECT_EQ(IsPoint(f), (Is<APoint>(f, Not<ASegment, APolygon, ASize>)));
    if (Is<ASize, ASegment>(f, Not<APoint, APolygon>)) found.push_back(f.id);
  }
  EXPECT_EQ(found, (std::vector<FeatureId>{2, 4}));
  EXPECT_EQ((CountOf<ASize, ASegment>(Examples(), Not<APoint, APolygon>)), 2);
}

TEST(FeatureKinds, EveryPointThatAFeatureNamesIsUsed) {
  std::vector<FeatureId> points;
  for (const Feature& f : Examples()) {
    ForEachPointOf(f, [&](FeatureId id) { points.push_back(id); });
  }
  EXPECT_EQ(points, (std::vector<FeatureId>{11, 12, 11, 12, 13, 14, 15, 16, 17, 18, 19}));
}

}  // namespace
}  // namespace dynmesh::feature_kinds_test
