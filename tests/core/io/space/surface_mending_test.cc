// Points, faces twice and faces without area of surface files.
#include "core/io/space/surface_mending.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "core/io/space/surface_files.h"
#include "tests/core/coplanar/face_soup.h"
#include "tests/support/seed.h"

namespace dynmesh::io {
namespace {

FileFeatures Read(const std::string& text) {
  auto input = ParseObjText(TextReader("a.obj", text), FaceRules::kMended);
  EXPECT_TRUE(input.ok()) << input.status();
  return *std::move(input);
}

const std::string kSquare = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";

TEST(SurfaceMending, EqualPointsAreOneAndNothingElseChanges) {
  FileFeatures file = Read(kSquare + "v 2 0 0\nv -0 2 -0\nf 1 2 3\nf 3 1 6\nl 1 5\nl 1 2\n");
  const SurfaceMends mends = MendSurface(0, file);
  EXPECT_EQ(mends.equal_points, 2U);
  EXPECT_EQ(mends.near_points + mends.faces_twice + mends.faces_without_area, 0U);
  const std::vector<Feature> expected = {
      Feature::Point(1, 0, 0, 0),       Feature::Point(2, 2, 0, 0),
      Feature::Point(3, 2, 2, 0),       Feature::Point(4, 0, 2, 0),
      Feature::Segment(7, 1, 2),        Feature::Polygon(9, {{1, 2, 3}}),
      Feature::Polygon(10, {{3, 1, 4}})};
  EXPECT_EQ(file.features, expected);
  EXPECT_EQ(file.Where(10), "a.obj:8");
}

TEST(SurfaceMending, NearPointsAreOneAtThePlaceOfMostFaces) {
  FileFeatures file =
      Read(kSquare + "v 1e-17 0 0\nv 0 -1e-17 0\nf 1 2 3\nf 5 3 4\nf 5 2 4\nl 6 3\n");
  const SurfaceMends mends = MendSurface(1e-12, file);
  EXPECT_EQ(mends.near_points, 2U);
  EXPECT_EQ(file.features[0], Feature::Point(1, 1e-17, 0, 0));
  EXPECT_EQ(file.features[4].ends[0], 1U);
}

TEST(SurfaceMending, OfFacesWithTheSameEdgesTheFirstStays) {
  FileFeatures file = Read(kSquare + "f 1 2 3 4\nf 4 3 2 1\nf 2 1 4 3\nf 1 3 2 4\n");
  EXPECT_EQ(MendSurface(0, file).faces_twice, 2U);
  ASSERT_EQ(file.features.size(), 6U);
  EXPECT_EQ(file.features[4].id, 5U);
  EXPECT_EQ(file.features[5].id, 8U);  // other edges
}

TEST(SurfaceMending, AFaceWithoutAreaGoesAndTheLongEdgeGetsItsCorners) {
  FileFeatures file = Read(kSquare +
                           "v 1 0 0\nv 0.5 0 0\nv 1 -1 1\nf 1 2 3 4\nf 1 5 2\nf 1 6 5\nf 1 6 7\nf "
                           "6 5 7\nf 5 2 7\nf 1 1 2\n");
  EXPECT_EQ(MendSurface(0, file).faces_without_area, 3U);
  ASSERT_EQ(file.features.size(), 11U);
  EXPECT_EQ(file.features[7].rings, (Rings{{1, 6, 5, 2, 3, 4}}));
}

TEST(SurfaceMending, AFaceThatVisitsAPlaceTwiceBecomesFacesThatTouch) {
  FileFeatures file = Read(kSquare + "v 2 2 0\nv 3 2 0\nv 3 3 0\nf 1 2 3 6 7 5 4\n");
  MendSurface(0, file);
  ASSERT_EQ(file.features.size(), 8U);
  EXPECT_EQ(file.Where(file.features[7].id), "a.obj:8");
}

// Triangles with points of their own, some twice, in any order.
TEST(SurfaceMending, DoesNotDependOnTheOrder) {
  std::mt19937 rng(test::NewSeed());
  testing::FaceSoup soup;
  soup.points = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 1}};
  soup.AddQuad(0, 1, 2, 3);
  soup.Cut(20, rng);
  const std::size_t whole = soup.faces.size();
  for (int i = 0; i < 10; ++i) {  // without area
    const auto face = soup.faces[rng() % whole];
    soup.faces.push_back({face[0], face[1], face[0]});
    soup.faces.push_back(face);
  }
  testing::FaceSoup apart;
  for (const auto& face : soup.faces) {
    auto& own = apart.faces.emplace_back();
    for (const std::size_t c : face) {
      own.push_back(apart.points.size());
      apart.points.push_back(soup.points[c]);
    }
  }
  std::multiset<testing::Shape> first;
  for (int i = 0; i < 4; ++i) {
    apart.Shuffle(rng);
    FileFeatures file;
    file.features = apart.Features();
    file.lines.resize(file.features.size(), 1);
    const SurfaceMends mends = MendSurface(1e-9, file);
    EXPECT_EQ(mends.faces_without_area, 10U);
    EXPECT_EQ(mends.faces_twice, 10U);
    const auto shapes = testing::ShapesOf(file.features);
    EXPECT_EQ(shapes.size(), whole);
    if (i == 0) first = shapes;
    EXPECT_EQ(shapes, first);
  }
}

}  // namespace
}  // namespace dynmesh::io
