// Cures: they keep the vertices of refinement, no tetrahedron at a vertex of a cure is bad, and
// hardly any sliver is left. tests/differential tests that edits lead to the same result as from
// scratch.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/geometry/circumball.h"
#include "core/meshing/refinement.h"
#include "tests/support/dihedral.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing::cure_test {
namespace {

using geometry::Point3;
using Untraced = Refinement<3, sac::UntracedEngine>;
using test::LeastDihedral;
using test::Random;

MeshOptions Options(double degrees) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = 2;
  options.min_dihedral = degrees;
  return options;
}

struct Meshed {
  std::vector<Point3> refined, cures;  // vertices, sorted
  int slivers = 0, left = 0;           // before cures and after
};

// Meshes the points; checks each tetrahedron at a vertex of a cure.
Meshed MeshPoints(const std::vector<Point3>& points, double degrees) {
  delaunay::DelaunayTetrahedralization triangulation;
  Untraced refinement(Options(degrees), &triangulation);
  FeatureSlot feature = 1;
  for (const Point3& p : points) refinement.AddPoint(p, feature++);
  EXPECT_TRUE(refinement.Propagate([] { return false; }));
  Meshed meshed;
  delaunay::DelaunayTetrahedralization before, after;
  for (auto* each : {&before, &after}) refinement.complex().ResetToDomain(each);
  refinement.elements().ForEachVertex([&](VertexIndex v, const auto& vertex) {
    (IsOfCure(vertex) ? meshed.cures : meshed.refined).push_back(vertex.p);
    if (v < 8) return;
    if (!IsOfCure(vertex)) before.Insert(v, vertex.p, 0);
    after.Insert(v, vertex.p, 0);
  });
  std::sort(meshed.refined.begin(), meshed.refined.end());
  std::sort(meshed.cures.begin(), meshed.cures.end());
  const auto corners_of = [&](const auto& of, auto t) {
    std::array<Point3, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) corners[k] = of.position(of.vertices(t)[k]);
    return corners;
  };
  const double bound = degrees == 0 ? 10 : degrees;
  before.ForEachSimplex(
      [&](auto t) { meshed.slivers += LeastDihedral(corners_of(before, t)) < bound; });
  after.ForEachSimplex([&](auto t) {
    const std::array<Point3, 4> p = corners_of(after, t);
    const bool is_left = LeastDihedral(p) < bound;
    meshed.left += is_left;
    const auto& v = after.vertices(t);
    if (std::ranges::none_of(v, [&](VertexIndex u) { return IsOfCure(refinement.vertex(u)); })) {
      return;
    }
    EXPECT_FALSE(is_left);
    double shortest2 = INFINITY;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) {
        shortest2 = std::min(shortest2, geometry::SquaredDistance(p[i], p[j]));
      }
    }
    EXPECT_LE(geometry::ExactCircumball(p[0], p[1], p[2], p[3]).r2, 4 * (1 + 1e-6) * shortest2);
  });
  return meshed;
}

std::vector<Point3> Uniform(int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Point3> points;
  for (int i = 0; i < count; ++i) {
    const double x = random.Unit(), y = random.Unit();
    points.push_back({{x, y, random.Unit()}});
  }
  return points;
}

TEST(Cure, HardlyAnySliverOfUniformPointsIsLeft) {
  const std::vector<Point3> points = Uniform(2000, 17);
  const Meshed off = MeshPoints(points, 0);
  EXPECT_TRUE(off.cures.empty());
  EXPECT_GT(off.slivers, 300);
  for (const double degrees : {5.0, 10.0, 15.0}) {
    SCOPED_TRACE(degrees);
    const Meshed on = MeshPoints(points, degrees);
    EXPECT_EQ(on.refined, off.refined);
    EXPECT_FALSE(on.cures.empty());
    EXPECT_LT(on.cures.size(), on.slivers);
    EXPECT_LE(on.left, degrees == 15 ? 3 : 1);
    if (degrees == 10) {
      EXPECT_LE(on.cures.size(), 0.12 * static_cast<double>(off.refined.size()));
    }
  }
}

// A grid: ties everywhere, and nothing to cure inside.
TEST(Cure, OfAGrid) {
  std::vector<Point3> points;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      for (int k = 0; k < 6; ++k) points.push_back({{i / 5.0, j / 5.0, k / 5.0}});
    }
  }
  const Meshed off = MeshPoints(points, 0), on = MeshPoints(points, 10);
  EXPECT_EQ(on.refined, off.refined);
  EXPECT_EQ(on.left, 0);
}

}  // namespace
}  // namespace dynmesh::meshing::cure_test
