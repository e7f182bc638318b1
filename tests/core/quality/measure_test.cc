// MeasureQuality against every simplex measured by itself.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "dynmesh/quality.h"
#include "gtest/gtest.h"

namespace dynmesh {
namespace {

// Simplices without connection, with corners of their own.
class Scene {
 public:
  explicit Scene(int dimension) : d_(static_cast<std::size_t>(dimension)) {
    mesh_.dimension = dimension;
  }
  // `corners`: d + 1 positions, one behind the other.
  void Add(const std::vector<double>& corners) {
    for (std::size_t k = 0; k <= d_; ++k) {
      mesh_.vertices.ids.push_back(mesh_.vertices.ids.size() * 0x9e3779b97f4a7c15ULL + 1);
      mesh_.simplices.push_back(mesh_.vertices.ids.back());
      for (std::size_t j = 0; j < d_; ++j) {
        mesh_.vertices.coordinates.push_back(corners[k * d_ + j]);
      }
      mesh_.vertices.containing_dimensions.push_back(static_cast<std::uint8_t>(d_));
      mesh_.vertices.owners.push_back(kNoFeature);
    }
  }
  void AddUnknown() {
    for (std::size_t k = 0; k <= d_; ++k) mesh_.simplices.push_back(~std::uint64_t{k});
  }
  const Mesh& mesh() const { return mesh_; }

 private:
  std::size_t d_;
  Mesh mesh_;
};

template <std::size_t kSteps>
void Count(double angle, std::array<std::uint64_t, kSteps>& histogram) {
  ++histogram[std::min<std::size_t>(kSteps - 1,
                                    static_cast<std::size_t>(angle / (180.0 / kSteps)))];
}

void ExpectEqual(const QualityReport& a, const QualityReport& b) {
  EXPECT_EQ(a.worst_radius_edge, b.worst_radius_edge);
  EXPECT_EQ(a.min_angle_deg, b.min_angle_deg);
  EXPECT_EQ(a.max_angle_deg, b.max_angle_deg);
  EXPECT_EQ(a.over_rho, b.over_rho);
  EXPECT_EQ(a.below_dihedral, b.below_dihedral);
  EXPECT_EQ(a.angle_histogram, b.angle_histogram);
  EXPECT_EQ(a.dihedral_histogram, b.dihedral_histogram);
  EXPECT_EQ(a.share_below_5_deg, b.share_below_5_deg);
  EXPECT_EQ(a.share_below_10_deg, b.share_below_10_deg);
  EXPECT_EQ(a.worst_dihedral, b.worst_dihedral);
}

// Of simplices with known vertices.
template <int D>
QualityReport Naive(const Mesh& mesh, const MeshOptions& options) {
  QualityReport report;
  report.min_angle_deg = 180;
  const std::vector<SimplexVerdict> verdicts = JudgeSimplices(mesh, options);
  const double* const x = mesh.vertices.coordinates.data();
  for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
    const double* const c = x + i * D * (D + 1);
    report.over_rho += IsOverRho(verdicts[i]);
    const auto add = [&](const auto& q) {
      report.worst_radius_edge = std::max(report.worst_radius_edge, q.radius_edge);
      report.min_angle_deg = std::min(report.min_angle_deg, q.min_angle_deg);
      report.max_angle_deg = std::max(report.max_angle_deg, q.max_angle_deg);
    };
    if constexpr (D == 2) {
      const TriangleQuality q = MeasureTriangle(c, c + 2, c + 4);
      add(q);
      for (const double angle : q.angles_deg) Count(angle, report.angle_histogram);
    } else {
      const TetrahedronQuality q = MeasureTetrahedron(c, c + 3, c + 6, c + 9);
      add(q);
      for (const double angle : q.angles_deg) Count(angle, report.dihedral_histogram);
      report.share_below_5_deg += q.min_angle_deg < 5;
      report.share_below_10_deg += q.min_angle_deg < 10;
      // Also of those over rho. What has no circumradius is flat.
      report.below_dihedral += options.min_dihedral > 0 && (std::isinf(q.radius_edge) ||
                                                            q.min_angle_deg < options.min_dihedral);
      WorstTetrahedron worst = {q.min_angle_deg, i, {0, 0, 0}};
      for (std::size_t k = 0; k < 12; ++k) worst.centroid[k % 3] += c[k] / 4;
      report.worst_dihedral.push_back(worst);
    }
  }
  std::stable_sort(report.worst_dihedral.begin(), report.worst_dihedral.end(),
                   [](const auto& a, const auto& b) { return a.angle_deg < b.angle_deg; });
  if (report.worst_dihedral.size() > kWorstDihedral) report.worst_dihedral.resize(kWorstDihedral);
  report.share_below_5_deg /= static_cast<double>(mesh.simplex_count());
  report.share_below_10_deg /= static_cast<double>(mesh.simplex_count());
  return report;
}

TEST(MeasureQuality, OfTrianglesIsThatOfEach) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const double scale : {1.0, 1e-3, 1e40, 1e-60, 1e120}) {
    Scene scene(2);
    for (int i = 0; i < 4000; ++i) {
      std::vector<double> corners;
      for (int k = 0; k < 6; ++k) corners.push_back(scale * unit(random));
      // Some flat, inverted, right-angled or with an angle on the border of a step.
      if (i % 50 == 0) corners = {0, 0, scale, scale, 2 * scale, 2 * scale};
      if (i % 50 == 1) corners = {0, 0, scale, 0, 0, scale};
      if (i % 50 == 2) {
        const double angle = std::numbers::pi / 18 * static_cast<double>(1 + random() % 16);
        corners = {0, 0, scale, 0, scale * std::cos(angle), scale * std::sin(angle)};
      }
      if (i % 50 == 3) corners[5] = corners[3] + 1e-12 * scale;
      scene.Add(corners);
    }
    for (const double rho : {1.0, 1.4, 20.0}) {
      MeshOptions options;
      options.quality = rho;
      ExpectEqual(MeasureQuality(scene.mesh(), options), Naive<2>(scene.mesh(), options));
    }
  }
}

TEST(MeasureQuality, OfEqualTrianglesIsThatOfOne) {
  Scene scene(2);
  for (int i = 0; i < 300; ++i) scene.Add({0, 0, 3, 0, 1, 2});
  ExpectEqual(MeasureQuality(scene.mesh(), {}), Naive<2>(scene.mesh(), {}));
}

TEST(MeasureQuality, OfTetrahedraIsThatOfEach) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const double scale : {1.0, 1e-3, 1e20, 1e-30, 1e44}) {
    SCOPED_TRACE(scale);
    Scene scene(3);
    for (int i = 0; i < 4000; ++i) {
      std::vector<double> corners;
      for (int k = 0; k < 12; ++k) corners.push_back(scale * unit(random));
      if (i % 40 == 0) corners[11] = corners[8] = corners[5] = corners[2];  // flat
      if (i % 40 == 1) {
        corners = {0, 0, 0, scale, 0, 0, 0, scale, 0, 0, 0, scale};
      }
      if (i % 40 == 2) {  // an angle on the border of a step
        const double angle = std::numbers::pi / 36 * static_cast<double>(1 + random() % 34);
        corners = {
            0, 0, 0, scale, 0, 0, 0, scale, 0, 0, scale * std::cos(angle), scale * std::sin(angle)};
      }
      if (i % 40 == 3) {  // a sliver
        corners = {0, 0, 0, scale, 0, 0, scale, scale, 0, 0, scale, scale * unit(random) * 1e-3};
      }
      scene.Add(corners);
    }
    for (const double rho : {0.9, 2.0, 50.0}) {
      for (const double bound : {0.0, 4.9}) {  // not one of the angles above
        MeshOptions options;
        options.dimension = 3;
        options.quality = rho;
        options.min_dihedral = bound;
        const QualityReport naive = Naive<3>(scene.mesh(), options);
        QualityReport report = MeasureQuality(scene.mesh(), options);
        report.below_dihedral += report.exempt_dihedral;
        ExpectEqual(report, naive);
        EXPECT_EQ(report.below_dihedral > 0, bound > 0);
      }
    }
  }
}

TEST(MeasureQuality, ASimplexWithUnknownVerticesIsFlat) {
  for (const int dimension : {2, 3}) {
    Scene scene(dimension);
    for (int i = 0; i < 200; ++i) scene.AddUnknown();
    MeshOptions options;
    options.dimension = dimension;
    const QualityReport report = MeasureQuality(scene.mesh(), options);
    EXPECT_EQ(report.over_rho, 200U);
    EXPECT_EQ(report.min_angle_deg, 0);
    EXPECT_EQ(report.max_angle_deg, 180);
    EXPECT_TRUE(report.worst_dihedral.empty());
  }
}

}  // namespace
}  // namespace dynmesh
