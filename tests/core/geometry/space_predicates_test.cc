// The exact 3D predicates: against rational arithmetic, by their algebraic laws, and by the
// guarantee of the perturbation: one tetrahedralisation of any set.
#include "core/geometry/space_predicates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "tests/core/geometry/random_points.h"
#include "tests/core/geometry/rational_vectors.h"

namespace dynmesh::geometry::space_predicates_test {
namespace {

using testing::Det;
using testing::Dot;
using testing::From;
using testing::Kind;
using testing::Q;
using testing::QVector;
using testing::SignOf;

int SlowOrientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  return SignOf(Det(From(a, b), From(a, c), From(a, d)));
}

// By the centre of the sphere, from its definition: |x - a| = |x - b| = |x - c| = |x - d|.
// REQUIRES: a, b, c, d not coplanar.
int SlowInSphere(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                 const Point3& e) {
  const QVector u = From(a, b), v = From(a, c), w = From(a, d);
  const QVector right = {Dot(u, u) / 2, Dot(v, v) / 2, Dot(w, w) / 2};
  // Cramer's rule for the centre x relative to a: u.x, v.x, w.x = right.
  const Q det = Det(u, v, w);
  QVector x;
  for (std::size_t k = 0; k < 3; ++k) {
    QVector uu = u, vv = v, ww = w;
    uu[k] = right[0], vv[k] = right[1], ww[k] = right[2];
    x[k] = Det(uu, vv, ww) / det;
  }
  const QVector f = From(a, e);
  const QVector to_e = {f[0] - x[0], f[1] - x[1], f[2] - x[2]};
  return SignOf(Dot(x, x) - Dot(to_e, to_e));
}

class SpacePredicatesOn : public ::testing::TestWithParam<Kind> {
 protected:
  SpacePredicatesOn() : seed_(testing::NewSeed()), source_(GetParam(), seed_) {}
  std::uint64_t seed_;
  testing::PointSource<3> source_;
};

TEST_P(SpacePredicatesOn, AllSignsAgreeWithRationals) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  int spheres = 0;
  for (int i = 0; i < 4000; ++i) {
    Point3 a = source_.Next(), b = source_.Next(), c = source_.Next(), d = source_.Next();
    const Point3 e = source_.Next();
    const int side = SlowOrientation(a, b, c, d);
    ASSERT_EQ(Orientation(a, b, c, d), side) << "round " << i;
    ASSERT_EQ(internal::OrientationExact(a, b, c, d), side) << "round " << i;
    const int filtered = internal::OrientationFilter(a, b, c, d);
    ASSERT_TRUE(filtered == internal::kUnsure || filtered == side) << "round " << i;
    ASSERT_EQ(InDiametralBall(a, b, c), Dot(From(c, a), From(c, b)) < 0) << "round " << i;
    if (side == 0) continue;
    if (side < 0) std::swap(a, b);
    ++spheres;
    const int inside = SlowInSphere(a, b, c, d, e);
    ASSERT_EQ(internal::InSphereExact(a, b, c, d, e), inside) << "round " << i;
    const int maybe = internal::InSphereFilter(a, b, c, d, e);
    ASSERT_TRUE(maybe == internal::kUnsure || maybe == inside) << "round " << i;
  }
  EXPECT_GT(spheres, 1000);
}

TEST_P(SpacePredicatesOn, PermutationsOfThePointsGiveTheSameAnswers) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  for (int i = 0; i < 4000; ++i) {
    Point3 a = source_.Next(), b = source_.Next(), c = source_.Next(), d = source_.Next();
    const Point3 e = source_.Next();
    const int side = Orientation(a, b, c, d);
    ASSERT_EQ(Orientation(b, c, a, d), side);
    ASSERT_EQ(Orientation(b, a, d, c), side);
    ASSERT_EQ(Orientation(b, a, c, d), -side);
    ASSERT_EQ(Orientation(a, b, d, c), -side);
    if (side == 0 || e == a || e == b || e == c || e == d) continue;
    if (side < 0) std::swap(a, b);
    const bool inside = InSphere(a, b, c, d, e);
    ASSERT_EQ(InSphere(b, c, a, d, e), inside) << "round " << i;
    ASSERT_EQ(InSphere(b, a, d, c, e), inside) << "round " << i;
    // The tetrahedron beyond face abc, if e is there, has the same result for d.
    if (Orientation(a, c, b, e) > 0) {
      ASSERT_EQ(InSphere(a, c, b, e, d), inside) << "round " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, SpacePredicatesOn, ::testing::ValuesIn(testing::kAllKinds));

using Face = std::array<Point3, 3>;

// Rotated so that the least comes first: equal faces seen from one side are equal.
Face Canonical(Face f) {
  std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
  return f;
}

// Every four points with nothing inside their sphere make a tetrahedron. Together they are
// one triangulation of the hull: every face has one owner on either side, or is on the hull.
void ExpectOneTriangulation(const std::vector<Point3>& points) {
  std::map<Face, int> faces;  // seen from inside, counter-clockwise
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      for (std::size_t k = j + 1; k < n; ++k) {
        for (std::size_t l = k + 1; l < n; ++l) {
          std::array<Point3, 4> t = {points[i], points[j], points[k], points[l]};
          const int side = Orientation(t[0], t[1], t[2], t[3]);
          if (side == 0) continue;
          if (side < 0) std::swap(t[0], t[1]);
          const bool empty = std::all_of(points.begin(), points.end(), [&](const Point3& p) {
            return std::find(t.begin(), t.end(), p) != t.end() ||
                   !InSphere(t[0], t[1], t[2], t[3], p);
          });
          if (!empty) continue;
          ++faces[Canonical({t[0], t[1], t[2]})];
          ++faces[Canonical({t[0], t[2], t[3]})];
          ++faces[Canonical({t[0], t[3], t[1]})];
          ++faces[Canonical({t[1], t[3], t[2]})];
        }
      }
    }
  }
  ASSERT_FALSE(faces.empty());
  for (const auto& [f, count] : faces) {
    ASSERT_EQ(count, 1) << "tetrahedra overlap";
    if (faces.contains(Canonical({f[1], f[0], f[2]}))) continue;
    for (const Point3& p : points) {
      ASSERT_GE(Orientation(f[0], f[1], f[2], p), 0) << "a gap beside a face";
    }
  }
}

TEST(SpacePerturbation, MakesDelaunayUniqueOnDegenerateSets) {
  const std::uint64_t seed = testing::NewSeed();
  int sets = 0;
  for (const Kind kind : testing::kAllKinds) {
    for (std::uint64_t round = 0; round < 25; ++round) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " kind " +
                   std::to_string(static_cast<int>(kind)) + " round " + std::to_string(round));
      testing::PointSource<3> source(kind, seed + round);
      std::set<Point3> distinct;
      for (std::uint64_t i = 0; i < 5 + round % 9; ++i) distinct.insert(source.Next());
      const std::vector<Point3> points(distinct.begin(), distinct.end());
      bool flat = true;
      for (std::size_t i = 3; i < points.size() && flat; ++i) {
        for (std::size_t j = 2; j < i && flat; ++j) {
          for (std::size_t k = 1; k < j && flat; ++k) {
            flat = Orientation(points[0], points[k], points[j], points[i]) == 0;
          }
        }
      }
      if (flat) continue;
      ++sets;
      ASSERT_NO_FATAL_FAILURE(ExpectOneTriangulation(points));
    }
  }
  EXPECT_GT(sets, 100);
}

// The corners of a cube, and of a lattice: everything is cospherical and coplanar.
TEST(SpacePerturbation, MakesDelaunayUniqueOnCubes) {
  for (const int side : {2, 3}) {
    std::vector<Point3> points;
    for (int i = 0; i < side * side * side; ++i) {
      points.push_back({{double(i % side), double(i / side % side), double(i / side / side)}});
    }
    ASSERT_NO_FATAL_FAILURE(ExpectOneTriangulation(points));
  }
}

}  // namespace
}  // namespace dynmesh::geometry::space_predicates_test
