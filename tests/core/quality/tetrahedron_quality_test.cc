// Tetrahedra: against the textbook's formulas in 100 digits.
#include "core/quality/tetrahedron_quality.h"

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "dynmesh/quality.h"
#include "gtest/gtest.h"
#include "tests/core/mesh_data/made_up_mesh.h"

namespace dynmesh {
namespace {

using geometry::Point3;
using Corners = std::array<Point3, 4>;
using Real = boost::multiprecision::cpp_bin_float_100;
using RealVector = std::array<Real, 3>;

TetrahedronQuality Measure(const Corners& p) {
  return MeasureTetrahedron(p[0].c.data(), p[1].c.data(), p[2].c.data(), p[3].c.data());
}

RealVector From(const Point3& p, const Point3& q) {
  return {Real(q[0]) - p[0], Real(q[1]) - p[1], Real(q[2]) - p[2]};
}
Real Dot(const RealVector& a, const RealVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
RealVector Cross(const RealVector& a, const RealVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Real Determinant(const Corners& p) {
  return Dot(From(p[0], p[1]), Cross(From(p[0], p[2]), From(p[0], p[3])));
}

// The dihedral angle at edge pq between the faces with the other corners r and s: the angle between
// r - p and s - p without their components along q - p.
double NaiveDihedral(const Point3& p, const Point3& q, const Point3& r, const Point3& s) {
  const RealVector e = From(p, q);
  const auto across = [&](RealVector v) {
    const Real along = Dot(v, e) / Dot(e, e);
    for (std::size_t k = 0; k < 3; ++k) v[k] -= along * e[k];
    return v;
  };
  const RealVector a = across(From(p, r)), b = across(From(p, s));
  const Real cosine = Dot(a, b) / sqrt(Dot(a, a) * Dot(b, b));
  const Real pi = acos(Real(-1));
  return static_cast<double>(Real(acos(cosine) * 180 / pi));
}

// The 3D Heron formula: with the products of opposite edges x, y, z, 24 volume radius = sqrt((x + y
// + z) (x + y - z) (y + z - x) (z + x - y)).
Real NaiveRatio(const Corners& p) {
  const auto length = [&](int i, int j) {
    const RealVector e = From(p[static_cast<std::size_t>(i)], p[static_cast<std::size_t>(j)]);
    return Real(sqrt(Dot(e, e)));
  };
  const Real x = length(0, 1) * length(2, 3), y = length(0, 2) * length(1, 3),
             z = length(0, 3) * length(1, 2);
  const Real area = sqrt((x + y + z) * (x + y - z) * (y + z - x) * (z + x - y));
  Real shortest = length(0, 1);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < i; ++j) shortest = std::min(shortest, length(i, j));
  }
  return area / (4 * Determinant(p)) / shortest;
}

TEST(TetrahedronQuality, KnowsTheRegularOne) {
  const Corners p = {{{{1, 1, 1}}, {{-1, 1, -1}}, {{1, -1, -1}}, {{-1, -1, 1}}}};
  const TetrahedronQuality q = Measure(p);
  EXPECT_NEAR(q.radius_edge, std::sqrt(0.375), 1e-15);
  EXPECT_DOUBLE_EQ(q.shortest_edge, std::sqrt(8));
  for (const double angle : q.angles_deg) EXPECT_NEAR(angle, 70.528779365509308, 1e-12);
}

TEST(TetrahedronQuality, KnowsTheCornerOfABox) {
  const Corners p = {{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 2, 0}}, {{0, 0, 2}}}};
  const TetrahedronQuality q = Measure(p);
  EXPECT_DOUBLE_EQ(q.radius_edge, 1.5);
  EXPECT_EQ(q.shortest_edge, 1);
  for (std::size_t e = 0; e < 3; ++e) EXPECT_DOUBLE_EQ(q.angles_deg[e], 90);  // ab, ac, ad
  EXPECT_NEAR(q.angles_deg[5], std::atan2(1, std::sqrt(2)) * 45 / std::atan(1.0), 1e-12);  // cd
  EXPECT_EQ(q.max_angle_deg, *std::max_element(q.angles_deg.begin(), q.angles_deg.end()));
  EXPECT_EQ(q.min_angle_deg, *std::min_element(q.angles_deg.begin(), q.angles_deg.end()));
}

TEST(TetrahedronQuality, OfFlatOrInvertedOnesIsInfinite) {
  const auto is_flat = [](const Corners& p) {
    const TetrahedronQuality q = Measure(p);
    return std::isinf(q.radius_edge) && q.min_angle_deg == 0 && q.max_angle_deg == 180;
  };
  const Point3 a = {{0, 0, 0}}, b = {{1, 0, 0}}, c = {{0, 1, 0}}, d = {{0, 0, 1}};
  EXPECT_FALSE(is_flat({a, b, c, d}));
  EXPECT_TRUE(is_flat({a, c, b, d}));
  EXPECT_TRUE(is_flat({a, b, c, {{0.7, 0.1, 0}}}));
  EXPECT_TRUE(is_flat({a, b, c, c}));
  EXPECT_TRUE(is_flat({a, a, a, a}));
  EXPECT_TRUE(is_flat({a, b, c, {{0, 0, std::nan("")}}}));
  EXPECT_TRUE(is_flat({a, b, c, {{0, 0, INFINITY}}}));
  // A plane that contains doubles only by chance; and one step off it, up and down.
  const Point3 p = {{0.1, 0.2, 0.1 + 0.2}}, q = {{0.3, 0.5, 0.3 + 0.5}};
  const Point3 r = {{0.7, 0.1, 0.7 + 0.1}};
  const Point3 s = {{0.2, 0.4, 0.2 + 0.4}};
  const Corners one = {p, q, r, s}, other = {q, p, r, s};
  ASSERT_NE(Determinant(one), 0);
  EXPECT_NE(is_flat(one), is_flat(other));
  EXPECT_EQ(is_flat(one), Determinant(one) < 0);
}

TEST(TetrahedronQuality, IsTheSameAtEveryScaleToTheBit) {
  const Corners one = {
      {{{0.1, 0.2, 0.3}}, {{0.7, 0.3, 0.1}}, {{0.4, 0.9, 0.2}}, {{0.5, 0.4, 0.8}}}};
  const TetrahedronQuality expected = Measure(one);
  ASSERT_FALSE(std::isinf(expected.radius_edge));
  for (int k = -240; k <= 240; k += 16) {
    Corners p = one;
    for (Point3& corner : p) {
      for (double& x : corner.c) x = std::scalbn(x, k);
    }
    const TetrahedronQuality q = Measure(p);
    EXPECT_EQ(q.radius_edge, expected.radius_edge) << k;
    EXPECT_EQ(q.angles_deg, expected.angles_deg) << k;
    EXPECT_EQ(q.shortest_edge, std::scalbn(expected.shortest_edge, k)) << k;
  }
}

// Thinner and thinner: d above the middle of a, b, c as high as 1 to 10^-18; slivers, four
// corners around a circle.
Corners AnyCorners(testing::Random& random, int kind) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double height = std::pow(10, -18 * unit(random));
  Corners p;
  for (Point3& corner : p) corner = {{unit(random), unit(random), unit(random)}};
  if (kind == 1) {
    for (Point3& corner : p) corner[2] *= height;
  } else if (kind == 2) {
    for (std::size_t k = 0; k < 4; ++k) {
      const double at = std::acos(0.0) * (static_cast<double>(k) + 0.2 * unit(random));
      p[k] = {{std::cos(at), std::sin(at), k % 2 == 0 ? 0 : height}};
    }
  } else if (kind == 3) {  // a needle
    for (Point3& corner : p) corner[1] *= height, corner[2] *= height;
  }
  if (random() % 2 == 0) {  // aslant, so that products cancel
    for (Point3& corner : p) corner[2] += 0.3 * corner[0] + 0.7 * corner[1];
    for (Point3& corner : p) corner[0] += 0.4 * corner[2];
  }
  if (Determinant(p) < 0) std::swap(p[0], p[1]);
  return p;
}

TEST(TetrahedronQuality, AgreesWithAHundredDigits) {
  auto random = testing::MakeRandom();
  for (int round = 0; round < 4000; ++round) {
    const int kind = round % 4;
    const Corners p = AnyCorners(random, kind);
    if (Determinant(p) == 0) continue;
    const TetrahedronQuality q = Measure(p);
    const double ratio = static_cast<double>(NaiveRatio(p));
    ASSERT_NEAR(q.radius_edge / ratio, 1, 1e-10) << "kind " << kind;
    const double expected[6] = {
        NaiveDihedral(p[0], p[1], p[2], p[3]), NaiveDihedral(p[0], p[2], p[1], p[3]),
        NaiveDihedral(p[0], p[3], p[1], p[2]), NaiveDihedral(p[1], p[2], p[0], p[3]),
        NaiveDihedral(p[1], p[3], p[0], p[2]), NaiveDihedral(p[2], p[3], p[0], p[1])};
    for (std::size_t e = 0; e < 6; ++e) {
      if (kind == 3) continue;  // no guarantee
      ASSERT_NEAR(q.angles_deg[e], expected[e], 1e-9) << "kind " << kind << ", edge " << e;
    }
    ASSERT_EQ(q.min_angle_deg, *std::min_element(q.angles_deg.begin(), q.angles_deg.end()));
    ASSERT_EQ(q.max_angle_deg, *std::max_element(q.angles_deg.begin(), q.angles_deg.end()));
  }
}

TEST(TetrahedronQuality, IsOverBoundExactly) {
  auto random = testing::MakeRandom();
  int differ = 0;
  for (int round = 0; round < 2000; ++round) {
    const Corners p = AnyCorners(random, round % 3);
    if (Determinant(p) == 0) continue;
    const TetrahedronQuality q = Measure(p);
    if (q.radius_edge > 1e12) continue;
    const Real ratio = NaiveRatio(p);
    double bound = static_cast<double>(ratio);
    for (int k = 0; k < 2; ++k) bound = std::nextafter(bound, 0);
    for (int k = -2; k <= 2; ++k, bound = std::nextafter(bound, INFINITY)) {
      ASSERT_EQ(quality::IsOverBound(p, q, bound), ratio > bound);
      differ += (q.radius_edge > bound) != (ratio > bound);
    }
    for (const double factor : {1 - 1e-9, 1 + 1e-9, 0.5, 2.0}) {
      ASSERT_EQ(quality::IsOverBound(p, q, q.radius_edge * factor), factor < 1);
    }
  }
  EXPECT_GT(differ, 100);  // else doubles would do
}

// Unrelated tetrahedra, each with corners of its own.
Mesh Heap(testing::Random& random, std::size_t count) {
  Mesh mesh;
  mesh.dimension = 3;
  for (std::size_t i = 0; i < count; ++i) {
    const Corners p = AnyCorners(random, i % 8 < 3 ? static_cast<int>(i % 8) : 0);
    for (const Point3& corner : p) {
      mesh.vertices.ids.push_back(mesh.vertices.size() + 1);
      mesh.vertices.coordinates.insert(mesh.vertices.coordinates.end(), corner.c.begin(),
                                       corner.c.end());
      mesh.vertices.containing_dimensions.push_back(3);
      mesh.vertices.owners.push_back(kNoFeature);
      mesh.simplices.push_back(mesh.vertices.ids.back());
    }
  }
  return mesh;
}

TEST(MeasureQuality, OfAMeshOfSpaceCountsWhatIsThere) {
  auto random = testing::MakeRandom();
  const Mesh mesh = Heap(random, 500);
  MeshOptions options;
  options.dimension = 3;
  options.quality = 2;
  const double unit = CoordinateUnit(mesh.vertices.coordinates);
  const QualityReport report = MeasureQuality(mesh, options);
  const std::vector<SimplexVerdict> verdicts = JudgeSimplices(mesh, options);
  ASSERT_EQ(verdicts.size(), 500U);
  QualityReport expected;
  expected.min_angle_deg = 180;
  int below_5 = 0, below_10 = 0;
  for (std::size_t i = 0; i < 500; ++i) {
    const double* const x = &mesh.vertices.coordinates[12 * i];
    const TetrahedronQuality q = MeasureTetrahedron(x, x + 3, x + 6, x + 9);
    const bool over = q.radius_edge > 2 * (1 + QualitySlack(q.shortest_edge, unit));
    EXPECT_EQ(verdicts[i], over ? SimplexVerdict::kOverRho : SimplexVerdict::kGood);
    expected.over_rho += over;
    expected.worst_radius_edge = std::max(expected.worst_radius_edge, q.radius_edge);
    expected.min_angle_deg = std::min(expected.min_angle_deg, q.min_angle_deg);
    expected.max_angle_deg = std::max(expected.max_angle_deg, q.max_angle_deg);
    below_5 += q.min_angle_deg < 5;
    below_10 += q.min_angle_deg < 10;
    for (const double angle : q.angles_deg) {
      std::size_t bin = 0;
      while (bin < 35 && angle >= 5.0 * static_cast<double>(bin + 1)) ++bin;
      ++expected.dihedral_histogram[bin];
    }
  }
  EXPECT_GT(expected.over_rho, 10U);
  EXPECT_LT(expected.over_rho, 490U);
  EXPECT_EQ(report.over_rho, expected.over_rho);
  EXPECT_EQ(report.exempt, 0U);
  EXPECT_EQ(report.exempt_by_guard, 0U);
  EXPECT_EQ(report.worst_radius_edge, expected.worst_radius_edge);
  EXPECT_EQ(report.min_angle_deg, expected.min_angle_deg);
  EXPECT_EQ(report.max_angle_deg, expected.max_angle_deg);
  EXPECT_EQ(report.dihedral_histogram, expected.dihedral_histogram);
  EXPECT_EQ(report.share_below_5_deg, below_5 / 500.0);
  EXPECT_EQ(report.share_below_10_deg, below_10 / 500.0);
  EXPECT_GT(below_5, 0);
  EXPECT_LT(below_5, below_10);
}

TEST(MeasureQuality, AllowsTheSlackInSpaceAndNoMore) {
  Mesh mesh;
  mesh.dimension = 3;
  mesh.vertices.ids = {1, 2, 3, 4};
  mesh.vertices.coordinates = {0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 2};  // ratio 1.5
  mesh.vertices.containing_dimensions = {0, 0, 0, 0};
  mesh.vertices.owners = {1, 2, 3, 4};
  mesh.simplices = {1, 2, 3, 4};
  MeshOptions options;
  options.dimension = 3;
  const double slack = QualitySlack(1, CoordinateUnit(mesh.vertices.coordinates));
  options.quality = 1.5 / (1 + 0.99 * slack);
  EXPECT_EQ(MeasureQuality(mesh, options).over_rho, 0U);
  options.quality = 1.5 / (1 + 1.01 * slack);
  EXPECT_EQ(MeasureQuality(mesh, options).over_rho, 1U);
  EXPECT_EQ(JudgeSimplices(mesh, options), std::vector{SimplexVerdict::kOverRho});
  options.quality = 2;
  mesh.simplices[2] = 77;  // a missing vertex
  const QualityReport report = MeasureQuality(mesh, options);
  EXPECT_TRUE(std::isinf(report.worst_radius_edge));
  EXPECT_EQ(report.over_rho, 1U);
  mesh.simplices.clear();
  EXPECT_EQ(MeasureQuality(mesh, options).min_angle_deg, 0);
}

// The corner of a cube pressed flat has its least angle, atan(h sqrt 2), at the long edges.
TEST(MeasureQuality, TellsWhatIsBelowAKnownDihedralAngle) {
  const double height = 0.1, angle = std::atan(height * std::sqrt(2.0)) * 45 / std::atan(1.0);
  Mesh mesh;
  mesh.dimension = 3;
  mesh.vertices.ids = {1, 2, 3, 4, 5};
  mesh.vertices.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, height, 0, 0, 1};
  mesh.vertices.containing_dimensions = {0, 0, 0, 0, 0};
  mesh.vertices.owners = {1, 2, 3, 4, 5};
  mesh.simplices = {1, 2, 3, 5, 1, 2, 3, 4};
  MeshOptions options;
  options.dimension = 3;
  options.quality = 100;
  using enum SimplexVerdict;
  QualityReport report = MeasureQuality(mesh, options);
  EXPECT_EQ(report.below_dihedral, 0U);
  ASSERT_EQ(report.worst_dihedral.size(), 2U);
  EXPECT_NEAR(report.worst_dihedral[0].angle_deg, angle, 1e-9);
  EXPECT_EQ(report.worst_dihedral[0].index, 1U);
  EXPECT_EQ(report.worst_dihedral[0].centroid, (std::array<double, 3>{0.25, 0.25, height / 4}));
  EXPECT_EQ(report.worst_dihedral[1].index, 0U);
  options.min_dihedral = angle - 1e-8;
  EXPECT_EQ(MeasureQuality(mesh, options).below_dihedral, 0U);
  EXPECT_EQ(JudgeSimplices(mesh, options), (std::vector{kGood, kGood}));
  options.min_dihedral = angle + 1e-8;
  report = MeasureQuality(mesh, options);
  EXPECT_EQ(report.below_dihedral, 1U);
  EXPECT_EQ(report.over_rho, 0U);
  EXPECT_EQ(report.exempt, 0U);
  EXPECT_EQ(JudgeSimplices(mesh, options), (std::vector{kGood, kBelowDihedral}));
  EXPECT_FALSE(IsExempt(kBelowDihedral) || IsOverRho(kBelowDihedral));
  options.quality = 2;  // its ratio is more: reported, and still counted
  report = MeasureQuality(mesh, options);
  EXPECT_EQ(report.below_dihedral, 1U);
  EXPECT_EQ(report.over_rho, 1U);
  EXPECT_EQ(JudgeSimplices(mesh, options), (std::vector{kGood, kOverRho}));
  std::swap(mesh.simplices[0], mesh.simplices[1]);  // turned inside out
  EXPECT_EQ(MeasureQuality(mesh, options).below_dihedral, 2U);
  mesh.simplices[0] = 77;  // a missing vertex
  report = MeasureQuality(mesh, options);
  EXPECT_EQ(report.below_dihedral, 2U);
  EXPECT_EQ(report.worst_dihedral.size(), 1U);
}

TEST(MeasureQuality, FindsTheWorstTetrahedraInOrder) {
  auto random = testing::MakeRandom();
  for (const std::size_t count : {0, 1, 9, 10, 11, 300}) {
    Mesh mesh = Heap(random, count);
    for (std::size_t i = 0; i + 1 < count; i += 7) {  // some twice
      std::copy_n(&mesh.vertices.coordinates[12 * i], 12, &mesh.vertices.coordinates[12 * i + 12]);
    }
    MeshOptions options;
    options.dimension = 3;
    options.min_dihedral = 10;
    std::vector<std::pair<double, std::uint64_t>> expected;
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double* const x = &mesh.vertices.coordinates[12 * i];
      expected.emplace_back(MeasureTetrahedron(x, x + 3, x + 6, x + 9).min_angle_deg, i);
      below += expected.back().first < 10;
    }
    std::sort(expected.begin(), expected.end());
    const QualityReport report = MeasureQuality(mesh, options);
    EXPECT_EQ(report.below_dihedral, below);
    ASSERT_EQ(report.worst_dihedral.size(), std::min(count, kWorstDihedral));
    for (std::size_t k = 0; k < report.worst_dihedral.size(); ++k) {
      EXPECT_EQ(report.worst_dihedral[k].angle_deg, expected[k].first) << k;
      EXPECT_EQ(report.worst_dihedral[k].index, expected[k].second) << k;
    }
    const std::vector<SimplexVerdict> verdicts = JudgeSimplices(mesh, options);
    for (std::size_t i = 0; i < count; ++i) below -= verdicts[i] == SimplexVerdict::kBelowDihedral;
    EXPECT_LE(below, report.over_rho);
  }
}

TEST(JudgeSimplices, TakesAnyCoordinates) {
  auto random = testing::MakeRandom();
  for (int round = 0; round < 500; ++round) {
    Mesh mesh = Heap(random, 1);
    for (double& x : mesh.vertices.coordinates) {
      const int how = static_cast<int>(random() % 4);
      if (how == 0) x = std::scalbn(x, static_cast<int>(random() % 2100) - 1070);
      if (how == 1) x = -std::scalbn(x, static_cast<int>(random() % 700) - 350);
      if (random() % 20 == 0) x = random() % 2 == 0 ? INFINITY : std::nan("");
    }
    MeshOptions options;
    options.dimension = 3;
    options.min_dihedral = 10;
    ASSERT_EQ(JudgeSimplices(mesh, options).size(), 1U);
    ASSERT_EQ(MeasureQuality(mesh, options).worst_dihedral.size(), 1U);
  }
}

}  // namespace
}  // namespace dynmesh
