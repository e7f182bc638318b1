// The exact shape of tetrahedra against rational arithmetic.
#include "core/geometry/tetrahedron_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/core/geometry/random_points.h"
#include "tests/core/geometry/rational_vectors.h"

namespace dynmesh::geometry::tetrahedron_shape_test {
namespace {

using testing::Det;
using testing::Dot;
using testing::From;
using testing::Kind;
using testing::Q;
using testing::QVector;
using testing::SignOf;

// (circumradius / shortest edge)^2, by the centre x relative to a, from its definition:
// |x| = |x - u| = |x - v| = |x - w|. REQUIRES: not flat.
Q SlowSquaredRatio(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const QVector u = From(a, b), v = From(a, c), w = From(a, d);
  const QVector right = {Dot(u, u) / 2, Dot(v, v) / 2, Dot(w, w) / 2};
  const Q det = Det(u, v, w);
  QVector x;
  for (std::size_t k = 0; k < 3; ++k) {
    QVector uu = u, vv = v, ww = w;
    uu[k] = right[0], vv[k] = right[1], ww[k] = right[2];
    x[k] = Det(uu, vv, ww) / det;
  }
  const QVector edges[6] = {u, v, w, From(b, c), From(b, d), From(c, d)};
  Q shortest = Dot(u, u);
  for (const QVector& e : edges) shortest = std::min(shortest, Dot(e, e));
  return Dot(x, x) / shortest;
}

bool IsNear(const Q& value, const Q& truth, double tolerance) {
  const Q error = value < truth ? Q(truth - value) : Q(value - truth);
  const Q magnitude = truth < 0 ? Q(-truth) : truth;
  return error <= magnitude * Q(tolerance);
}

class TetrahedronShapeOn : public ::testing::TestWithParam<Kind> {};

TEST_P(TetrahedronShapeOn, AgreesWithRationals) {
  const std::uint64_t seed = testing::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  testing::PointSource<3> source(GetParam(), seed);
  int flat = 0, full = 0;
  for (int i = 0; i < 1000; ++i) {
    const Point3 a = source.Next(), b = source.Next(), c = source.Next(), d = source.Next();
    const Q det = Det(From(a, b), From(a, c), From(a, d));
    const TetrahedronShape shape = ShapeOf(a, b, c, d);
    ASSERT_TRUE(IsNear(Q(shape.determinant), det, 0x1p-49)) << "round " << i;
    if (det == 0) {
      ++flat;
      ASSERT_TRUE(std::isinf(shape.radius_edge));
      ASSERT_EQ(CompareRadiusEdge(a, b, c, d, 1e300), 1);
      continue;
    }
    ++full;
    const Q square = SlowSquaredRatio(a, b, c, d);
    if (std::isinf(shape.radius_edge)) {
      ASSERT_GT(square, Q(1e308) * Q(1e308)) << "round " << i;
    } else {
      ASSERT_TRUE(IsNear(Q(shape.radius_edge) * Q(shape.radius_edge), square, 0x1p-48));
    }
    // At bounds next to the ratio, and at one far away.
    double bound = std::min(shape.radius_edge, 0x1p52);
    for (int k = 0; k < 3; ++k) bound = std::nextafter(bound, 0);
    for (int k = -3; k <= 3; ++k, bound = std::min(std::nextafter(bound, INFINITY), 0x1p52)) {
      ASSERT_EQ(CompareRadiusEdge(a, b, c, d, bound), SignOf(square - Q(bound) * Q(bound)));
    }
    ASSERT_EQ(CompareRadiusEdge(a, b, c, d, 2), SignOf(square - 4));
    ASSERT_EQ(CompareRadiusEdge(b, a, c, d, 2), SignOf(square - 4));  // turned over
    ASSERT_EQ(CompareRadiusEdge(a, b, c, d, 0.5), 1);
  }
  EXPECT_GT(full, 200);
  if (GetParam() == Kind::kGrid || GetParam() == Kind::kBigGrid) {
    EXPECT_GT(flat, 20);
  }
}

INSTANTIATE_TEST_SUITE_P(All, TetrahedronShapeOn, ::testing::ValuesIn(testing::kAllKinds));

TEST(TetrahedronShape, RatiosThatAreDoublesAreMetExactly) {
  // A corner of a box: the ball is the box's.
  for (const double scale : {0x1p-240, 0x1p-3, 1.0, 3.0, 0x1p200}) {
    const Point3 a = {{0, 0, 0}}, b = {{scale, 0, 0}}, c = {{0, 2 * scale, 0}},
                 d = {{0, 0, 2 * scale}};
    EXPECT_EQ(ShapeOf(a, b, c, d).radius_edge, 1.5);
    EXPECT_EQ(CompareRadiusEdge(a, b, c, d, 1.5), 0);
    EXPECT_EQ(CompareRadiusEdge(a, b, c, d, std::nextafter(1.5, 2)), -1);
    EXPECT_EQ(CompareRadiusEdge(a, b, c, d, std::nextafter(1.5, 1)), 1);
  }
}

}  // namespace
}  // namespace dynmesh::geometry::tetrahedron_shape_test
