// Pieces of two simplices that have corners, edges and planes in common, as old and new ones do.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "core/transfer/clipper.h"
#include "tests/core/geometry/random_points.h"

namespace dynmesh::transfer {
namespace {

template <std::size_t D>
PatchSimplex<D> SimplexOf(const Corners<D>& corners) {
  PatchSimplex<D> simplex{};
  simplex.corners = corners;
  simplex.measure = Measure<D>(corners);
  return simplex;
}

template <std::size_t D>
struct Common {
  bool any = false;
  Piece<D> piece{};
  typename Overlay<D>::Mass own{};
  std::uint32_t open = 0;
  Common(const PatchSimplex<D>& from, const PatchSimplex<D>& to) {
    any = Clipper<D>(to).Clip(from, piece, own, open);
  }
  double mass(std::size_t a, std::size_t b) const { return any ? piece.mass[a * (D + 1) + b] : 0; }
};

// With corners on a small grid, where rounding decides which side of a plane they are on.
template <std::size_t D>
PatchSimplex<D> DrawOnGrid(std::mt19937_64& random) {
  for (;;) {
    Corners<D> corners;
    for (auto& corner : corners) {
      for (double& x : corner) x = 0.1 * static_cast<double>(random() % 4);
    }
    const PatchSimplex<D> simplex = SimplexOf<D>(corners);
    if (simplex.measure > 1e-6) return simplex;
  }
}

template <std::size_t D>
void CompareOrders() {
  std::mt19937_64 random(geometry::testing::NewSeed());
  for (int trial = 0; trial < 20'000; ++trial) {
    const PatchSimplex<D> a = DrawOnGrid<D>(random), b = DrawOnGrid<D>(random);
    const Common<D> ab(a, b), ba(b, a);
    const double slack = 1e-12 * std::min(a.measure, b.measure);
    for (std::size_t i = 0; i <= D; ++i) {
      for (std::size_t j = 0; j <= D; ++j) ASSERT_NEAR(ab.mass(i, j), ba.mass(j, i), slack);
    }
  }
}

TEST(Clip, APieceIsTheSameWhicheverIsClippedByTheOther) {
  CompareOrders<2>();
  CompareOrders<3>();
}

TEST(Clip, APieceHasNoSideWhereItHasAnEdgeOrACornerOnly) {
  // In coordinates that round.
  const auto turned = [](double x, double y, double z) {
    return Vec<3>{0.3 * x - 0.7 * y + 0.1 * z, 0.9 * x + 0.4 * y - 0.2 * z, 0.2 * x + z / 3};
  };
  const Corners<3> old = {turned(0, 0, 0), turned(1, 0, 0), turned(0, 1, 0), turned(0, 0, 1)};
  // In common with it: a face, an edge, a corner.
  Corners<3> inner = old;
  for (std::size_t k = 3; k > 0; --k) {
    const double x = 0.2 + 0.1 * (k == 1), y = 0.2 + 0.2 * (k == 2), z = 0.2 + 0.1 * (k == 3);
    inner[k] = turned(x, y, z);
    const PatchSimplex<3> from = SimplexOf<3>(old), to = SimplexOf<3>(inner);
    ASSERT_GT(to.measure, 1e-4);
    const Common<3> common(from, to);
    ASSERT_TRUE(common.any);
    EXPECT_EQ(common.open, k == 3 ? 0b1000U : 0U);
    EXPECT_NEAR(common.piece.measure(), to.measure, 1e-15);
  }

  const Common<2> plane(SimplexOf<2>({{{0.1, 0.1}, {0.9, 0.3}, {0.2, 0.7}}}),
                        SimplexOf<2>({{{0.1, 0.1}, {0.9, 0.3}, {0.4, 0.4}}}));
  ASSERT_TRUE(plane.any);
  EXPECT_EQ(plane.open, 0b100U);
}

TEST(Clip, SimplicesWithAFaceBetweenThemHaveNothingInCommon) {
  const Corners<3> old = {{{0.1, 0.1, 0.1}, {0.8, 0.2, 0.1}, {0.3, 0.9, 0.2}, {0.3, 0.3, 0.7}}};
  Corners<3> beyond = old;
  beyond[3] = {0.4, 0.3, -0.6};
  std::swap(beyond[0], beyond[1]);
  ASSERT_GT(ScaledMeasure(beyond), 0);
  EXPECT_FALSE(Common<3>(SimplexOf<3>(old), SimplexOf<3>(beyond)).any);
}

}  // namespace
}  // namespace dynmesh::transfer
