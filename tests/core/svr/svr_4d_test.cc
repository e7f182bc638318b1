// SVR in 4D: all points are vertices, every simplex is good, and Delaunay by exact rationals.
#include <gmpxx.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "tests/core/svr/svr_of_points.h"
#include "tests/support/nightly.h"
#include "tests/support/point_layouts.h"

namespace dynmesh::svr::svr_4d_test {
namespace {

constexpr double kQuality = 2;

// The points' cube is in the middle of the domain.
Options<4> OptionsIn4D(int border_cells) {
  Options<4> options;
  options.border_cells = border_cells;
  options.lo.c.fill(0.5 - 0.5 * border_cells);
  options.hi.c.fill(0.5 + 0.5 * border_cells);
  options.quality = kQuality;
  return options;
}

// Twice the coordinates of the centre from p[0], times the determinant; in rationals.
struct ExactBall {
  std::array<mpq_class, 4> centre;  // from corner 0
  mpq_class r2;
};
ExactBall BallOf(const std::array<geometry::Point<4>, 5>& p) {
  std::array<std::array<mpq_class, 5>, 4> m;
  for (std::size_t i = 0; i < 4; ++i) {
    m[i][4] = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      m[i][k] = mpq_class(p[i + 1].c[k]) - mpq_class(p[0].c[k]);
      m[i][4] += m[i][k] * m[i][k] / 2;
    }
  }
  for (std::size_t column = 0; column < 4; ++column) {
    std::size_t pivot = column;
    while (m[pivot][column] == 0) ++pivot;
    std::swap(m[pivot], m[column]);
    for (std::size_t i = 0; i < 4; ++i) {
      if (i == column) continue;
      const mpq_class factor = m[i][column] / m[column][column];
      for (std::size_t k = column; k < 5; ++k) m[i][k] -= factor * m[column][k];
    }
  }
  ExactBall ball;
  for (std::size_t k = 0; k < 4; ++k) {
    ball.centre[k] = m[k][4] / m[k][k];
    ball.r2 += ball.centre[k] * ball.centre[k];
  }
  return ball;
}

// By Delaunay's lemma the vertices beyond the sides of each simplex suffice.
void ExpectDelaunayByRationals(const Kernel<4>& mesh, int every) {
  int checked = 0, number = 0;
  mesh.ForEachSimplex([&](SimplexIndex s) {
    if (number++ % every != 0) return;
    std::array<geometry::Point<4>, 5> p;
    for (std::size_t i = 0; i < 5; ++i) p[i] = mesh.position(mesh.vertices(s)[i]);
    const ExactBall ball = BallOf(p);
    for (int i = 0; i <= 4; ++i) {
      const auto beyond = mesh.Opposite({s, i});
      const VertexIndex v = mesh.vertices(beyond.simplex)[static_cast<std::size_t>(beyond.index)];
      if (v == Kernel<4>::kInfinite) continue;
      mpq_class d2 = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        const mpq_class d =
            mpq_class(mesh.position(v).c[k]) - mpq_class(p[0].c[k]) - ball.centre[k];
        d2 += d * d;
      }
      ASSERT_GE(d2, ball.r2);
      ++checked;
    }
  });
  EXPECT_GT(checked, 1000);
}

template <class Location = VoronoiLocation<4, true>>
void ExpectGoodMesh(test::Layout layout, int n, int every, int border_cells = 4) {
  SCOPED_TRACE(std::string(NameOf(layout)) + " " + std::to_string(n));
  const auto points = test::PointsOf<4>(layout, n, 3);
  SvrOfPoints<4, Location> of(OptionsIn4D(border_cells), points);
  ASSERT_TRUE(of.svr.Run([] { return false; }));
  // Also of those with a circumcenter outside of the domain.
  double worst = 0;
  of.mesh.ForEachSimplex([&](SimplexIndex s) {
    worst = std::max(worst, delaunay::BallOf(of.mesh, s).r2 / SquaredShortestEdge<4>(of.mesh, s));
  });
  EXPECT_LE(std::sqrt(worst), kQuality * (1 + 1e-5));
  std::string why;
  EXPECT_TRUE(of.mesh.Check(&why)) << why;
  std::set<geometry::Point<4>> inserted;
  for (VertexIndex v = 0; v < of.mesh.vertex_count(); ++v) {
    if (of.input.IsInput(v)) inserted.insert(of.mesh.position(v));
  }
  EXPECT_TRUE(std::ranges::equal(inserted, points));
  ExpectDelaunayByRationals(of.mesh, every);
}

TEST(Svr4D, MeshesOfThousandPointsAreGoodAndDelaunay) {
  ExpectGoodMesh(test::Layout::kUniform, 1000, 10);
}
// DYNMESH_NIGHTLY=1: 22,000 vertices, 626,000 simplices, every tenth by rationals.
TEST(Svr4D, AMeshOfTenThousandPointsIsGoodAndDelaunay) {
  if (!test::IsNightly()) GTEST_SKIP() << "nightly only";
  ExpectGoodMesh(test::Layout::kUniform, 10'000, 10, 6);
}
TEST(Svr4D, OtherLayoutsAreGoodAndDelaunay) {
  for (const test::Layout layout :
       {test::Layout::kClustered, test::Layout::kGrid, test::Layout::kLine,
        test::Layout::kTwoScales, test::Layout::kPair}) {
    ExpectGoodMesh(layout, 100, 10);
  }
}
TEST(Svr4D, OtherPointLocationsAreGoodAndDelaunay) {
  ExpectGoodMesh<SimplexLocation<4>>(test::Layout::kClustered, 60, 10);
  ExpectGoodMesh<BallLocation<4>>(test::Layout::kUniform, 60, 10);
}

}  // namespace
}  // namespace dynmesh::svr::svr_4d_test
