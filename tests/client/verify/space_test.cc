// `verify` must accept every good 3D mesh, and measure it as the library does.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "client/verify/verify.h"
#include "client/verify/verify_internal.h"
#include "dynmesh/quality.h"
#include "gtest/gtest.h"
#include "tests/client/verify/good_files.h"
#include "tests/client/verify/report_text.h"

namespace dynmesh::cli {
namespace {

using io::IndexedMesh;
TEST(VerifySpace, AcceptsGoodMeshes) {
  const std::uint64_t seed = NewSeed();
  for (std::uint64_t i = 0; i < 10; ++i) {
    const GoodFiles good = MakeGoodFiles(seed + i, 20 + static_cast<int>(30 * i), i % 2 == 0);
    const VerifyReport report = VerifyMesh(good.files, kAnyQuality, &good.features);
    EXPECT_TRUE(report.Passed()) << Describe(report);
    EXPECT_EQ(report.checks.size(), 12U);
    EXPECT_EQ(report.dimension, 3);
    EXPECT_GT(report.subfacets, 50U);
    EXPECT_EQ(report.simplices, good.files.mesh.tetrahedra.size());
  }
}

TEST(VerifySpace, MeasuresAsTheLibraryDoes) {
  const GoodFiles good = MakeGoodFiles(NewSeed(), 150);
  const VerifyReport report = VerifyMesh(good.files, 1.5, nullptr);
  MeshOptions options;
  options.dimension = 3;
  options.quality = 1.5;
  const QualityReport expected = MeasureQuality(io::ToMesh(good.files.mesh), options);
  EXPECT_NEAR(report.worst_radius_edge / expected.worst_radius_edge, 1, 1e-9);
  EXPECT_NEAR(report.min_angle_deg, expected.min_angle_deg, 1e-6);
  EXPECT_NEAR(report.max_angle_deg, expected.max_angle_deg, 1e-6);
  EXPECT_EQ(report.over_rho, expected.over_rho);
  EXPECT_GT(report.over_rho, 0U);
  EXPECT_EQ(FailedChecks(report), std::set<std::string>{"quality"});
}

// The corner of a cube pressed flat: its least angle is atan(h sqrt 2).
io::MeshFiles PressedFlat(double height) {
  io::MeshFiles files;
  files.mesh.dimension = 3;
  files.mesh.vertices = {{0, 0, 0, 1, 0}, {1, 0, 0, 2, 0}, {0, 1, 0, 3, 0}, {0, 0, 0, 4, height}};
  files.mesh.tetrahedra = {{0, 1, 2, 3}};
  return files;
}

TEST(VerifySpace, JudgesAKnownDihedralAngleExactly) {
  for (const double height : {0.1, 0.2, 1e-3, 1e-8}) {
    const io::MeshFiles files = PressedFlat(height);
    const long double exact = std::atan(height * std::sqrt(2.0L)) * 180 / std::acos(-1.0L);
    double bound = static_cast<double>(exact);
    for (int k = 0; k < 3; ++k) bound = std::nextafter(bound, 0);
    for (int k = -3; k <= 3; ++k, bound = std::nextafter(bound, HUGE_VAL)) {
      const VerifyReport report = VerifyMesh(files, kAnyQuality, nullptr, bound);
      EXPECT_EQ(report.below_dihedral, exact < bound ? 1U : 0U) << height << ", " << k;
      EXPECT_EQ(FailedChecks(report).contains("dihedral"), exact < bound);
    }
    EXPECT_EQ(VerifyMesh(files, kAnyQuality, nullptr, 20).below_dihedral, 1U);
    EXPECT_EQ(VerifyMesh(files, kAnyQuality, nullptr, 0).below_dihedral, 0U);
    EXPECT_EQ(VerifyMesh(files, kAnyQuality, nullptr).below_dihedral, 0U);
    EXPECT_NEAR(VerifyMesh(files, kAnyQuality, nullptr).min_angle_deg, bound, 1e-9);
  }
  const VerifyReport report = VerifyMesh(PressedFlat(0), kAnyQuality, nullptr, 1e-9);
  EXPECT_EQ(report.below_dihedral, 1U);
  EXPECT_NE(Describe(VerifyMesh(PressedFlat(0.1), kAnyQuality, nullptr, 10))
                .find("dihedral: tetrahedron 1 has a dihedral angle of 8.04946"),
            std::string::npos);
}

TEST(VerifySpace, CountsBelowADihedralAngleAsTheLibraryDoes) {
  const std::uint64_t seed = NewSeed();
  for (std::uint64_t i = 0; i < 6; ++i) {
    const GoodFiles good = MakeGoodFiles(seed + i, 60, i % 2 == 0);
    const Mesh mesh = io::ToMesh(good.files.mesh);
    MeshOptions options;
    options.dimension = 3;
    options.quality = kAnyQuality;
    for (const double bound : {1e-6, 1.0, 5.0, 10.0, 20.0}) {
      options.min_dihedral = bound;
      const QualityReport expected = MeasureQuality(mesh, options);
      const VerifyReport report = VerifyMesh(good.files, kAnyQuality, &good.features, bound);
      EXPECT_EQ(report.checks.size(), 13U);
      EXPECT_EQ(report.below_dihedral, expected.below_dihedral) << bound;
      if (report.below_dihedral == 0) {
        EXPECT_TRUE(report.Passed());
        continue;
      }
      EXPECT_EQ(FailedChecks(report), std::set<std::string>{"dihedral"});
      // The worst is named first, with its position; of several equally bad ones, any.
      const auto check = std::find_if(report.checks.begin(), report.checks.end(),
                                      [](const auto& c) { return c.name == "dihedral"; });
      const std::string before = " has a dihedral angle of ";
      const std::size_t at = check->examples[0].find(before);
      ASSERT_NE(at, std::string::npos) << check->examples[0];
      EXPECT_NEAR(std::stod(check->examples[0].substr(at + before.size())), report.min_angle_deg,
                  1e-12);
      EXPECT_NEAR(report.min_angle_deg, expected.worst_dihedral[0].angle_deg, 1e-6);
      EXPECT_NE(check->examples[0].find(" degrees, around "), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace dynmesh::cli
