// The point location structures of SVR against all points and all simplices: after each insertion,
// in SVR and without it, every uninserted point is where the structure says, and nowhere else, and
// a query finds a point if there is one.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/svr/voronoi_location.h"
#include "tests/core/svr/svr_of_points.h"
#include "tests/core/svr/variants/ball_location.h"
#include "tests/core/svr/variants/ball_predicates.h"
#include "tests/core/svr/variants/simplex_location.h"
#include "tests/support/point_layouts.h"

namespace dynmesh::svr::location_test {
namespace {

using geometry::Point;
using test::Layout;

template <class L>
constexpr bool kIsBall = false;
template <int D>
constexpr bool kIsBall<BallLocation<D>> = true;
template <class L>
constexpr bool kIsVoronoi = false;
template <int D, bool kShells>
constexpr bool kIsVoronoi<VoronoiLocation<D, kShells>> = true;

template <int D>
std::array<const Point<D>*, D + 1> CornersOf(const Kernel<D>& mesh, SimplexIndex s) {
  std::array<const Point<D>*, D + 1> corners;
  for (int i = 0; i <= D; ++i) corners[i] = &mesh.position(mesh.vertices(s)[i]);
  return corners;
}
template <int D>
bool IsIn(const Kernel<D>& mesh, SimplexIndex s, const Point<D>& p) {
  for (int i = 0; i <= D; ++i) {
    auto corners = CornersOf<D>(mesh, s);
    corners[i] = &p;
    if (geometry::OrientationOf<D>(corners) < 0) return false;
  }
  return true;
}

template <int D>
std::set<VertexIndex> VerticesOf(const Kernel<D>& mesh) {
  std::set<VertexIndex> vertices;
  mesh.ForEachSimplex(
      [&](SimplexIndex s) { vertices.insert(mesh.vertices(s).begin(), mesh.vertices(s).end()); });
  return vertices;
}

// `waiting`: the uninserted points.
template <int D, class Location>
void ExpectListed(const Kernel<D>& mesh, const Location& location, std::span<const Point<D>> points,
                  const std::vector<VertexIndex>& waiting) {
  ASSERT_EQ(location.left(), waiting.size());
  const std::set<VertexIndex> vertices = VerticesOf<D>(mesh);
  for (const VertexIndex p : waiting) {
    const auto distance2 = [&](VertexIndex v) {
      return geometry::SquaredDistance(points[p], mesh.position(v));
    };
    double least = INFINITY;
    for (const VertexIndex v : vertices) least = std::min(least, distance2(v));
    ASSERT_LE(distance2(location.OwnerOf(p)), least * (1 + 1e-14));
  }
  std::set<VertexIndex> crowded;
  if constexpr (kIsVoronoi<Location>) {
    for (const VertexIndex p : waiting) crowded.insert(location.OwnerOf(p));
  } else {
    std::vector<std::pair<SimplexIndex, VertexIndex>> listed, expected;
    for (SimplexIndex s = 0; s < mesh.simplex_limit() + 100; ++s) {
      location.ForEachIn(s, [&](VertexIndex p) { listed.emplace_back(s, p); });
    }
    if constexpr (kIsBall<Location>) {
      mesh.ForEachSimplex([&](SimplexIndex s) {
        for (const VertexIndex p : waiting) {
          if (geometry::InBall<D>(CornersOf<D>(mesh, s), points[p])) expected.emplace_back(s, p);
        }
      });
    } else {
      for (const auto& [s, p] : listed) {
        ASSERT_FALSE(mesh.IsInfinite(s));
        if (IsIn<D>(mesh, s, points[p])) expected.emplace_back(s, p);
      }
      std::vector<VertexIndex> each;
      for (const auto& [s, p] : listed) each.push_back(p);
      std::sort(each.begin(), each.end());
      ASSERT_EQ(each, waiting);
    }
    for (const auto& [s, p] : expected) {
      crowded.insert(mesh.vertices(s).begin(), mesh.vertices(s).end());
    }
    std::sort(listed.begin(), listed.end());
    std::sort(expected.begin(), expected.end());
    ASSERT_EQ(listed, expected);
  }
  for (const VertexIndex v : vertices) {
    ASSERT_EQ(location.IsCrowded(v), crowded.contains(v)) << "vertex " << v;
    if (!location.IsCrowded(v)) continue;
    ASSERT_TRUE(std::ranges::binary_search(waiting, location.AnyOf(v)));
  }
}

template <int D, class Location>
void ExpectFound(const Kernel<D>& mesh, Location& location, std::span<const Point<D>> points,
                 const std::vector<VertexIndex>& waiting) {
  mesh.ForEachSimplex([&](SimplexIndex s) {
    const Ball<D> ball = BallOf(mesh, s);
    if (!std::isfinite(ball.r2)) return;
    for (const double k : {0.3, 0.9, 0.99}) {
      const double radius = k * std::sqrt(ball.r2);
      const auto is_in = [&](VertexIndex p) {
        return geometry::SquaredDistance(points[p], ball.centre) < radius * radius;
      };
      const VertexIndex found = location.FindIn(s, ball, radius);
      ASSERT_EQ(found != kNone, std::ranges::any_of(waiting, is_in));
      if (found == kNone) continue;
      ASSERT_TRUE(std::ranges::binary_search(waiting, found));
      ASSERT_TRUE(is_in(found));
    }
  });
}

template <class T>
class LocationTest : public ::testing::Test {};
using Cases = ::testing::Types<
    Case<2, VoronoiLocation<2, true>>, Case<2, VoronoiLocation<2, false>>,
    Case<2, SimplexLocation<2>>, Case<2, BallLocation<2>>, Case<3, VoronoiLocation<3, true>>,
    Case<3, VoronoiLocation<3, false>>, Case<3, SimplexLocation<3>>, Case<3, BallLocation<3>>,
    Case<4, VoronoiLocation<4, true>>, Case<4, SimplexLocation<4>>, Case<4, BallLocation<4>>>;
TYPED_TEST_SUITE(LocationTest, Cases);

// Before each item of work; in 4D before one of 10.
TYPED_TEST(LocationTest, PointsAreListedWhereTheyAreAtEachStepOfSvr) {
  constexpr int D = TypeParam::kDimension;
  Options<D> options;
  options.border_cells = 4;
  options.lo.c.fill(-1.5);
  options.hi.c.fill(2.5);
  for (const Layout layout :
       {Layout::kUniform, Layout::kGrid, Layout::kCircleAndLine, Layout::kTwoScales}) {
    if (D == 4 && layout != Layout::kUniform) continue;
    SCOPED_TRACE(NameOf(layout));
    const auto points = test::PointsOf<D>(layout, D == 2 ? 60 : D == 3 ? 16 : 40, 9);
    SvrOfPoints<D, typename TypeParam::Location> of(options, points);
    int step = 0, checked = 0;
    of.svr.Run([&] {
      if (this->HasFatalFailure()) return true;
      if (D == 4 && step++ % 10 != 0) return false;
      std::vector<VertexIndex> waiting;
      for (const VertexIndex p : of.input.Waiting()) {
        if (!of.mesh.Contains(p)) waiting.push_back(p);
      }
      ExpectListed<D>(of.mesh, of.svr.location(), of.input.positions(), waiting);
      if (!waiting.empty()) ++checked;
      return false;
    });
    EXPECT_EQ(of.svr.location().left(), 0u);
    EXPECT_GT(checked, D == 4 ? 5 : 15);
  }
}

// The mesh is the triangulation of the points alone: with flat simplices, whose centres are
// outside, and in grids points on common sides, on common spheres and on the border.
TYPED_TEST(LocationTest, PointsAreListedAndFoundInAnyTriangulation) {
  constexpr int D = TypeParam::kDimension;
  for (const Layout layout :
       {Layout::kUniform, Layout::kGrid, Layout::kCircleAndLine, Layout::kClustered}) {
    SCOPED_TRACE(NameOf(layout));
    const int count = D == 2 ? 80 : D == 3 ? 50 : layout == Layout::kGrid ? 81 : 14;
    auto inner = test::PointsOf<D>(layout, count, 10);
    std::shuffle(inner.begin(), inner.end(), std::mt19937_64(11));
    Point<D> lo, hi;
    lo.c.fill(0), hi.c.fill(1);
    if (layout == Layout::kGrid) {  // its outer points are on the border
      lo = hi = inner[0];
      for (const Point<D>& p : inner) {
        for (int k = 0; k < D; ++k) lo[k] = std::min(lo[k], p[k]), hi[k] = std::max(hi[k], p[k]);
      }
    }
    Positions<D> points;
    std::array<VertexIndex, std::size_t{1} << D> corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      Point<D> p;
      for (int k = 0; k < D; ++k) p[k] = (i >> k & 1) != 0 ? hi[k] : lo[k];
      points.push_back(p);
      corners[i] = static_cast<VertexIndex>(i);
    }
    if constexpr (D == 2) std::swap(points[2], points[3]);  // counter-clockwise
    std::erase_if(inner, [&](const Point<D>& p) { return std::ranges::count(points, p) != 0; });
    for (const Point<D>& p : inner) points.push_back(p);

    Kernel<D> mesh;
    mesh.Reset(lo, hi, corners);
    typename TypeParam::Location location(mesh, points);
    std::vector<VertexIndex> waiting;
    for (auto p = static_cast<VertexIndex>(corners.size()); p < points.size(); ++p) {
      location.Assign(p, NearestVertex<D>(mesh, points[p], 0));
      waiting.push_back(p);
    }
    while (true) {
      ASSERT_NO_FATAL_FAILURE(ExpectListed<D>(mesh, location, points, waiting));
      if (D < 4 || waiting.size() % 8 == 0) {
        ASSERT_NO_FATAL_FAILURE(ExpectFound<D>(mesh, location, points, waiting));
      }
      if (waiting.empty()) break;
      const VertexIndex v = waiting.front();
      waiting.erase(waiting.begin());
      SimplexIndex conflicting = kNone;
      mesh.ForEachSimplex([&](SimplexIndex s) {
        if (conflicting == kNone && mesh.Conflicts(s, points[v])) conflicting = s;
      });
      location.Inserting(points[v], conflicting);
      mesh.InsertAt(v, points[v], conflicting);
      location.Inserted(v, true);
    }
  }
}

}  // namespace
}  // namespace dynmesh::svr::location_test
