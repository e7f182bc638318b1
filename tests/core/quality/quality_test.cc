#include "dynmesh/quality.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gtest/gtest.h"
#include "tests/core/mesh_data/made_up_mesh.h"

namespace dynmesh {
namespace {

TriangleQuality Measure(double ax, double ay, double bx, double by, double cx, double cy) {
  const double a[2] = {ax, ay};
  const double b[2] = {bx, by};
  const double c[2] = {cx, cy};
  return MeasureTriangle(a, b, c);
}

TEST(TriangleQuality, KnowsTheRightIsoscelesTriangle) {
  const TriangleQuality q = Measure(0, 0, 1, 0, 0, 1);
  EXPECT_DOUBLE_EQ(q.radius_edge, std::numbers::sqrt2 / 2);
  EXPECT_DOUBLE_EQ(q.shortest_edge, 1);
  EXPECT_DOUBLE_EQ(q.min_angle_deg, 45);
  EXPECT_DOUBLE_EQ(q.max_angle_deg, 90);
  EXPECT_DOUBLE_EQ(q.angles_deg[0], 90);
}

TEST(TriangleQuality, KnowsTheEquilateralTriangle) {
  const TriangleQuality q = Measure(0, 0, 2, 0, 1, std::numbers::sqrt3);
  EXPECT_NEAR(q.radius_edge, 1 / std::numbers::sqrt3, 1e-15);
  EXPECT_NEAR(q.min_angle_deg, 60, 1e-12);
  EXPECT_NEAR(q.max_angle_deg, 60, 1e-12);
}

TEST(TriangleQuality, OfFlatOrInvertedTrianglesIsInfinite) {
  EXPECT_TRUE(std::isinf(Measure(0, 0, 0, 1, 1, 0).radius_edge));
  EXPECT_TRUE(std::isinf(Measure(0, 0, 1, 1, 2, 2).radius_edge));
  EXPECT_TRUE(std::isinf(Measure(3, 3, 3, 3, 3, 3).radius_edge));
  EXPECT_TRUE(std::isinf(Measure(0, 0, 1, std::nan(""), 0, 1).radius_edge));
}

TEST(TriangleQuality, IsTheSameAtEveryScaleToTheBit) {
  const TriangleQuality one = Measure(0.1, 0.2, 0.7, 0.3, 0.4, 0.9);
  for (int k = -240; k <= 240; k += 16) {
    const double s = std::scalbn(1.0, k);
    const TriangleQuality q = Measure(0.1 * s, 0.2 * s, 0.7 * s, 0.3 * s, 0.4 * s, 0.9 * s);
    EXPECT_EQ(q.radius_edge, one.radius_edge) << k;
    EXPECT_EQ(q.min_angle_deg, one.min_angle_deg) << k;
    EXPECT_EQ(q.shortest_edge, one.shortest_edge * s) << k;
  }
}

TEST(TriangleQuality, LosesNothingFarFromTheOrigin) {
  // Corners on a grid of 2^-20 around 2^30: the differences are exact.
  const double far = std::scalbn(1.0, 30);
  const double u = std::scalbn(1.0, -20);
  const TriangleQuality near = Measure(0, 0, 5 * u, u, 2 * u, 7 * u);
  const TriangleQuality there = Measure(far, far, far + 5 * u, far + u, far + 2 * u, far + 7 * u);
  EXPECT_EQ(near.radius_edge, there.radius_edge);
  EXPECT_EQ(near.min_angle_deg, there.min_angle_deg);
}

TEST(TriangleQuality, AgreesWithLongDoublesOnThinTriangles) {
  auto random = testing::MakeRandom();
  std::uniform_real_distribution<double> coordinate(0, 1);
  for (int round = 0; round < 20'000; ++round) {
    double p[3][2];
    for (auto& c : p) c[0] = coordinate(random), c[1] = coordinate(random) * 1e-6;
    using Real = long double;
    const Real ux = Real{p[1][0]} - p[0][0], uy = Real{p[1][1]} - p[0][1];
    const Real vx = Real{p[2][0]} - p[0][0], vy = Real{p[2][1]} - p[0][1];
    const Real cross = ux * vy - uy * vx;
    // If long doubles cannot represent the cross product either, they are no oracle.
    if (cross < 1e-11L) continue;
    Real e[3] = {std::hypot(ux, uy), std::hypot(vx, vy), std::hypot(ux - vx, uy - vy)};
    std::sort(e, e + 3);
    const double expected = static_cast<double>(e[1] * e[2] / (2 * cross));
    const TriangleQuality q = MeasureTriangle(p[0], p[1], p[2]);
    ASSERT_NEAR(q.radius_edge / expected, 1, 1e-9);
    // R / e = 1 / (2 sin of the least angle).
    const double sine = std::sin(q.min_angle_deg * std::numbers::pi / 180);
    ASSERT_NEAR(2 * sine * q.radius_edge, 1, 1e-9);
    ASSERT_NEAR(q.angles_deg[0] + q.angles_deg[1] + q.angles_deg[2], 180, 1e-9);
  }
}

TEST(CoordinateUnit, IsTheSpacingOfDoublesAtTheLargestCoordinate) {
  const double a[3] = {0.5, -3.9, 1};
  EXPECT_EQ(CoordinateUnit(a), std::nextafter(3.9, 4) - 3.9);
  const double b[1] = {4.0};
  EXPECT_EQ(CoordinateUnit(b), std::nextafter(4.0, 8) - 4.0);
  const double zero[2] = {0, -0.0};
  EXPECT_EQ(CoordinateUnit(zero), 0);
  EXPECT_EQ(CoordinateUnit({}), 0);
}

TEST(QualitySlack, FollowsItsFormula) {
  const double u = std::scalbn(1.0, -52);
  EXPECT_DOUBLE_EQ(QualitySlack(1, u), 2e-9 + 8 * u);
  // e^2 = 2.25 and 3.99: the power of two is 2; 1.96: it is 1; 4: it is 4.
  EXPECT_DOUBLE_EQ(QualitySlack(1.5, 1e-3), 2e-9 + 8e-3 / std::numbers::sqrt2);
  EXPECT_DOUBLE_EQ(QualitySlack(1.4, 1e-3), 2e-9 + 8e-3);
  EXPECT_DOUBLE_EQ(QualitySlack(2, 1e-3), 2e-9 + 4e-3);
  EXPECT_DOUBLE_EQ(QualitySlack(std::scalbn(1.0, -600), 0), 2e-9);
  // Pairs at 2^-40 in a unit box: coordinates are off by about 1 in 4096.
  EXPECT_NEAR(QualitySlack(std::scalbn(1.0, -40), u), 8.0 / 4096, 1e-8);
}

TEST(MeasureQuality, CountsWhatIsOverRho) {
  // Two triangles of a 3 x 4 rectangle: ratio 2.5 / 3, angles 36.87, 53.13, 90.
  Mesh mesh;
  mesh.vertices.ids = {1, 2, 3, 4};
  mesh.vertices.coordinates = {0, 0, 4, 0, 4, 3, 0, 3};
  mesh.vertices.containing_dimensions = {0, 0, 0, 0};
  mesh.vertices.owners = {1, 2, 3, 4};
  mesh.simplices = {1, 2, 3, 1, 3, 4};
  MeshOptions options;
  options.quality = 0.84;
  QualityReport report = MeasureQuality(mesh, options);
  EXPECT_DOUBLE_EQ(report.worst_radius_edge, 2.5 / 3);
  EXPECT_NEAR(report.min_angle_deg, 36.8698976458440, 1e-12);
  EXPECT_DOUBLE_EQ(report.max_angle_deg, 90);
  EXPECT_EQ(report.over_rho, 0U);
  EXPECT_EQ(report.exempt, 0U);
  EXPECT_EQ(report.angle_histogram[3], 2U);
  EXPECT_EQ(report.angle_histogram[5], 2U);
  EXPECT_EQ(report.angle_histogram[8] + report.angle_histogram[9], 2U);
  options.quality = 0.83;
  EXPECT_EQ(MeasureQuality(mesh, options).over_rho, 2U);
  mesh.simplices[2] = 77;  // a missing vertex
  report = MeasureQuality(mesh, options);
  EXPECT_TRUE(std::isinf(report.worst_radius_edge));
}

TEST(MeasureQuality, OfNothingIsNothing) {
  const QualityReport report = MeasureQuality(Mesh(), MeshOptions());
  EXPECT_EQ(report.worst_radius_edge, 0);
  EXPECT_EQ(report.over_rho, 0U);
}

}  // namespace
}  // namespace dynmesh
