#include "client/cli/mesh_statistics.h"

#include <array>
#include <numeric>
#include <utility>

#include "gtest/gtest.h"

namespace dynmesh::cli {
namespace {

// A right isosceles triangle, one with angles 30, 60 and 90 degrees, a flat one.
io::IndexedMesh ThreeTriangles() {
  io::IndexedMesh mesh;
  mesh.vertices = {{0, 0, 0, 1}, {1, 0, 0, 2}, {0, 1, 0, 3}, {0, 1.8, 2, 0}, {2, 0, 2, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};
  mesh.edges = {{0, 1, 7}, {1, 2, kNoFeature}};
  return mesh;
}

TEST(MeshStatistics, CountAnglesByDegree) {
  const MeshStatistics s = ComputeStatistics(ThreeTriangles(), 1.2);
  EXPECT_EQ(s.vertices, 5U);
  EXPECT_EQ(s.simplices, 3U);
  EXPECT_EQ(s.subsegments, 1U);
  // atan(1 / 1.8) is 29.05 degrees.
  EXPECT_EQ(s.least_angles[0], 1U);
  EXPECT_EQ(s.least_angles[29], 1U);
  EXPECT_EQ(s.least_angles[44] + s.least_angles[45], 1U);
  EXPECT_EQ(std::accumulate(s.least_angles.begin(), s.least_angles.end(), 0U), 3U);
  EXPECT_EQ(s.angles[0], 2U);
  EXPECT_EQ(s.angles[60], 1U);
  EXPECT_EQ(s.angles[89] + s.angles[90], 2U);
  EXPECT_EQ(s.angles[179], 1U);
  EXPECT_EQ(std::accumulate(s.angles.begin(), s.angles.end(), 0U), 9U);
  EXPECT_NEAR(s.median_min_angle_deg, 29.05, 0.01);
}

TEST(MeshStatistics, CountTrianglesAndAreaByRegion) {
  io::IndexedMesh mesh = ThreeTriangles();
  MeshStatistics s = ComputeStatistics(mesh, 1.2);
  ASSERT_EQ(s.regions.size(), 1U);
  EXPECT_EQ(s.regions[0].simplices, 3U);
  EXPECT_DOUBLE_EQ(s.regions[0].size, 1.4);
  EXPECT_EQ(StatisticsText(s).find("no polygon"), std::string::npos);
  mesh.regions.polygons = {{4}, {4, 18446744073709551614ULL}};
  mesh.regions.numbers = {2, 0, 2};
  s = ComputeStatistics(mesh, 1.2);
  ASSERT_EQ(s.regions.size(), 3U);
  EXPECT_EQ(s.regions[0].simplices, 1U);
  EXPECT_DOUBLE_EQ(s.regions[0].size, 0.9);
  EXPECT_EQ(s.regions[1].simplices, 0U);
  EXPECT_EQ(s.regions[2].simplices, 2U);
  EXPECT_DOUBLE_EQ(s.regions[2].size, 0.5);
  EXPECT_NE(StatisticsText(s).find("0.5  4 18446744073709551614\n"), std::string::npos);
  EXPECT_NE(StatisticsText(s).find("0.9  no polygon\n"), std::string::npos);
  EXPECT_NE(
      StatisticsJson(s).find("\"regions\": [{\"polygons\": [], \"simplices\": 1, \"area\": 0.9}, "
                             "{\"polygons\": [\"4\"], \"simplices\": 0, \"area\": 0}, "
                             "{\"polygons\": [\"4\", \"18446744073709551614\"], "
                             "\"simplices\": 2, \"area\": 0.5}]"),
      std::string::npos)
      << StatisticsJson(s);
}

TEST(MeshStatistics, OfSpaceCountDihedralAnglesAndVolume) {
  // The corner of a cube, and a regular tetrahedron.
  io::IndexedMesh mesh;
  mesh.dimension = 3;
  mesh.vertices = {{0, 0, 0, 1, 0}, {1, 0, 0, 2, 0}, {0, 1, 0, 3, 0}, {0, 0, 0, 4, 0},
                   {1, 1, 0, 5, 0}, {1, 0, 0, 6, 0}, {0, 1, 0, 7, 0}};
  mesh.vertices[3].z = 1, mesh.vertices[5].z = 1, mesh.vertices[6].z = 1;
  mesh.tetrahedra = {{0, 1, 2, 3}, {0, 4, 6, 5}};
  mesh.faces = {{{0, 1, 2}, 9}, {{0, 1, 3}, kBoxFeature}};
  const MeshStatistics s = ComputeStatistics(mesh, 2);
  EXPECT_EQ(s.dimension, 3);
  EXPECT_EQ(s.simplices, 2U);
  EXPECT_EQ(s.subfacets, 1U);
  ASSERT_EQ(s.least_angles.size(), 75U);
  EXPECT_EQ(s.least_angles[54], 1U);  // 54.74 degrees
  EXPECT_EQ(s.least_angles[70], 1U);  // 70.53
  ASSERT_EQ(s.angles.size(), 180U);
  EXPECT_EQ(s.angles[54], 3U);
  EXPECT_EQ(s.angles[70], 6U);
  EXPECT_EQ(s.angles[89] + s.angles[90], 3U);
  ASSERT_EQ(s.regions.size(), 1U);
  EXPECT_DOUBLE_EQ(s.regions[0].size, 1.0 / 6 + 1.0 / 3);
  EXPECT_NE(StatisticsText(s).find("dihedral angles"), std::string::npos);
  EXPECT_NE(StatisticsJson(s).find("\"volume\": 0.5"), std::string::npos);
  EXPECT_TRUE(StatisticsHistograms(s)[1].marks.empty());
}

TEST(MeshStatistics, OfSpaceNameTheWorstTetrahedra) {
  // A regular tetrahedron, and the corner of a cube pressed flat: atan(0.2 sqrt 2), 15.79 degrees.
  io::IndexedMesh mesh;
  mesh.dimension = 3;
  mesh.vertices = {{0, 0, 0, 1, 0}, {1, 1, 0, 5, 0}, {1, 0, 0, 6, 1},  {0, 1, 0, 7, 1},
                   {1, 0, 0, 2, 0}, {0, 1, 0, 3, 0}, {0, 0, 0, 4, 0.2}};
  mesh.tetrahedra = {{0, 1, 3, 2}, {0, 4, 5, 6}};
  for (const auto& [bound, below] : {std::pair(0.0, 0U), {15.79, 0U}, {15.8, 1U}}) {
    const MeshStatistics s = ComputeStatistics(mesh, 100, bound);
    EXPECT_EQ(s.quality.below_dihedral, below) << bound;
    ASSERT_EQ(s.worst_dihedral.size(), 2U);
    EXPECT_NEAR(s.worst_dihedral[0].angle_deg, 15.7931691, 1e-6);
    EXPECT_EQ(s.worst_dihedral[0].vertices, (std::array<std::uint64_t, 4>{1, 5, 6, 7}));
    EXPECT_NEAR(s.worst_dihedral[1].angle_deg, 70.528779, 1e-6);
    const std::string json = StatisticsJson(s), text = StatisticsText(s);
    EXPECT_NE(json.find("\"worst_dihedral\": [{\"angle_deg\": 15.79"), std::string::npos) << json;
    EXPECT_NE(json.find("\"at\": [0.25, 0.25, 0.05], \"vertices\": [1, 5, 6, 7]}, {"),
              std::string::npos)
        << json;
    EXPECT_EQ(json.find("\"below_dihedral\": ") != std::string::npos, bound > 0);
    EXPECT_EQ(text.find("below dihedral ") != std::string::npos, bound > 0);
    EXPECT_NE(text.find("     15.7932  0.25 0.25 0.05 "), std::string::npos) << text;
    EXPECT_NE(text.find("  1 5 6 7\n"), std::string::npos) << text;
  }
}

TEST(MeshStatistics, OfNothingAreZero) {
  const MeshStatistics s = ComputeStatistics({}, 1.0);
  EXPECT_EQ(s.simplices, 0U);
  EXPECT_EQ(s.median_min_angle_deg, 0);
  EXPECT_EQ(StatisticsHistograms(s).size(), 2U);
  EXPECT_NE(StatisticsText(s).find("triangles"), std::string::npos);
}

TEST(MeshStatistics, MarkTheBoundsOfRho) {
  EXPECT_NEAR(LeastAngle(1), 30, 1e-12);
  EXPECT_NEAR(LeastAngle(kDefaultQuality2D), 20.705, 1e-3);
  const auto histograms = StatisticsHistograms(ComputeStatistics(ThreeTriangles(), 1));
  ASSERT_EQ(histograms.size(), 2U);
  EXPECT_EQ(histograms[0].counts.size(), 60U);
  EXPECT_EQ(histograms[1].counts.size(), 180U);
  ASSERT_EQ(histograms[1].marks.size(), 2U);
  EXPECT_NEAR(histograms[1].marks[1].value, 120, 1e-9);
}

}  // namespace
}  // namespace dynmesh::cli
