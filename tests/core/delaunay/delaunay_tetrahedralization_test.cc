// DelaunayTetrahedralization piece by piece: batch insertion, location, stars, conflict
// tests, tags.
#include "core/delaunay/delaunay_tetrahedralization.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/core/delaunay/tetrahedra_oracle.h"
#include "tests/core/geometry/random_points.h"

namespace dynmesh::delaunay::delaunay_tetrahedralization_test {
namespace {

using namespace testing;
using geometry::testing::NewSeed;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalTetrahedra = CGAL::Delaunay_triangulation_3<Kernel>;
constexpr VertexIndex kInfinite = DelaunayTetrahedralization::kInfinite;

// Without those that have three corners of the box: the four of a face are cocircular, and
// CGAL breaks ties in its own way.
TetrahedronSet WithoutTies(const TetrahedronSet& all) {
  const auto corners = Corners();
  TetrahedronSet result;
  for (const PlacedTetrahedron& t : all) {
    if (std::count_if(t.begin(), t.end(), [&](const Point3& p) {
          return std::find(corners.begin(), corners.end(), p) != corners.end();
        }) < 3) {
      result.insert(t);
    }
  }
  return result;
}

TetrahedronSet CgalDelaunay(std::vector<Point3> points) {
  for (const Point3& p : Corners()) points.push_back(p);
  std::vector<Kernel::Point_3> list;
  for (const Point3& p : points) list.emplace_back(p[0], p[1], p[2]);
  const CgalTetrahedra dt(list.begin(), list.end());
  TetrahedronSet result;
  for (auto c = dt.finite_cells_begin(); c != dt.finite_cells_end(); ++c) {
    PlacedTetrahedron t;
    for (std::size_t i = 0; i < 4; ++i) {
      const Kernel::Point_3& p = c->vertex(static_cast<int>(i))->point();
      t[i] = {{p.x(), p.y(), p.z()}};
    }
    std::sort(t.begin(), t.end());
    result.insert(t);
  }
  return result;
}

TEST(DelaunayTetrahedralization, OfABareBoxIsDelaunayByDefinition) {
  const DelaunayTetrahedralization dt = EmptyBox();
  EXPECT_EQ(dt.vertex_count(), 8u);
  EXPECT_TRUE(dt.created().empty());
  EXPECT_TRUE(dt.deleted().empty());
  for (VertexIndex v = 0; v < 8; ++v) EXPECT_EQ(dt.position(v), Corners()[v]);
  ExpectSound(dt);
  EXPECT_EQ(TetrahedraOf(dt), BruteForceDelaunay(Corners()));
}

TEST(DelaunayTetrahedralization, ResetStartsOver) {
  auto dt = Tetrahedralize(DistinctPoints(Layout::kUniform, 1, 100));
  dt.Reset(kLow, kHigh, {7, 5, 6, 2, 20, 0, 1, 3});
  EXPECT_EQ(dt.vertex_count(), 8u);
  EXPECT_FALSE(dt.Contains(4));
  EXPECT_EQ(dt.position(3), kHigh);
  EXPECT_EQ(dt.position(20), Corners()[4]);
  ExpectSound(dt);
  EXPECT_EQ(TetrahedraOf(dt), TetrahedraOf(EmptyBox()));
}

// A set without ties has one Delaunay tetrahedralisation, independent of the algorithm.
TEST(DelaunayTetrahedralization, OfGenericPointsAgreesWithCgal) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const auto& [layout, count] : {std::pair(Layout::kUniform, 20000),
                                      {Layout::kPairs, 3000},
                                      {Layout::kLineAndCircle, 200}}) {
    SCOPED_TRACE(LayoutName(layout));
    const auto points = DistinctPoints(layout, seed, count);
    const auto dt = Tetrahedralize(points);
    ExpectSound(dt);
    const auto actual = TetrahedraOf(dt), expected = CgalDelaunay(points);
    EXPECT_EQ(actual.size(), dt.simplex_count());
    EXPECT_EQ(actual.size(), expected.size());
    EXPECT_EQ(WithoutTies(actual), WithoutTies(expected));
  }
}

TEST(DelaunayTetrahedralization, InsertAllDoesWhatOneByOneDoesOnEveryLayout) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const Layout layout : kAllLayouts) {
    SCOPED_TRACE(LayoutName(layout));
    const auto points = DistinctPoints(layout, seed, 600);
    const auto all = Tetrahedralize(points);
    ExpectSound(all);
    EXPECT_TRUE(all.created().empty());
    EXPECT_TRUE(all.deleted().empty());
    DelaunayTetrahedralization each = EmptyBox();
    for (std::size_t i = 0; i < points.size(); ++i) {
      each.Insert(static_cast<VertexIndex>(8 + i), points[i], 0);
    }
    ASSERT_EQ(TetrahedraOf(all), TetrahedraOf(each));
  }
}

TEST(DelaunayTetrahedralization, InsertAllContinuesWhereOthersBegan) {
  const auto points = DistinctPoints(Layout::kGrid, 5, 300);
  const std::size_t half = points.size() / 2;
  const auto indices = IndicesFrom8(points.size());
  DelaunayTetrahedralization dt = EmptyBox();
  dt.InsertAll({indices.data(), half}, {points.data(), half});
  dt.InsertAll({indices.data() + half, points.size() - half},
               {points.data() + half, points.size() - half});
  dt.InsertAll({}, {});
  ExpectSound(dt);
  EXPECT_EQ(TetrahedraOf(dt), TetrahedraOf(Tetrahedralize(points)));
}

TEST(DelaunayTetrahedralization, InsertAtAcceptsAnyConflictingTetrahedron) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  const auto points = DistinctPoints(Layout::kBoxFaces, seed, 60);
  DelaunayTetrahedralization dt = EmptyBox();
  std::size_t choice = 0;
  for (VertexIndex i = 0; i < points.size(); ++i) {
    std::vector<SimplexIndex> conflicting;
    for (SimplexIndex t = 0; t < dt.simplex_limit(); ++t) {
      if (!dt.IsUnused(t) && dt.Conflicts(t, points[i])) conflicting.push_back(t);
    }
    ASSERT_FALSE(conflicting.empty());
    dt.InsertAt(8 + i, points[i], conflicting[choice++ % conflicting.size()]);
    ASSERT_EQ(dt.deleted().size(), conflicting.size());
  }
  ExpectSound(dt);
  EXPECT_EQ(TetrahedraOf(dt), TetrahedraOf(Tetrahedralize(points)));
}

TEST(DelaunayTetrahedralization, WorksInATinyBoxFarFromTheOrigin) {
  const Point3 lo{{1e6, -1e6, 3e5}};
  const auto at = [&](int x, int y, int z) {
    return Point3{{lo[0] + x * 0x1p-23, lo[1] + y * 0x1p-23, lo[2] + z * 0x1p-23}};
  };
  DelaunayTetrahedralization dt;
  dt.Reset(lo, at(4, 4, 4), {0, 1, 2, 3, 4, 5, 6, 7});
  VertexIndex v = 8;
  for (int i = 0; i < 125; ++i) {
    const int x = i % 5, y = i / 5 % 5, z = i / 25;
    if (x % 4 != 0 || y % 4 != 0 || z % 4 != 0) dt.Insert(v++, at(x, y, z), 0);
  }
  ExpectSound(dt);
  EXPECT_EQ(dt.vertex_count(), 125u);
}

// Up to where floats, which bound the cached spheres, have ended long since.
TEST(DelaunayTetrahedralization, WorksAtTheEndsOfTheCoordinateDomain) {
  const auto points = DistinctPoints(Layout::kGrid, 5, 200);
  const auto as_ever = [&](double s) {
    const auto scaled = [&](const Point3& p) { return Point3{{s * p[0], s * p[1], s * p[2]}}; };
    DelaunayTetrahedralization dt;
    dt.Reset(scaled(kLow), scaled(kHigh), {0, 1, 2, 3, 4, 5, 6, 7});
    for (VertexIndex i = 0; i < points.size(); ++i) dt.Insert(8 + i, scaled(points[i]), 0);
    for (VertexIndex i = 0; i < points.size(); i += 3) dt.Remove(8 + i);
    ExpectSound(dt);
    std::set<std::array<VertexIndex, 4>> result;
    dt.ForEachSimplex([&](SimplexIndex t) {
      auto v = dt.vertices(t);
      std::sort(v.begin(), v.end());
      result.insert(v);
    });
    return result;
  };
  const auto expected = as_ever(1);
  for (const double s : {0x1p-240, 0x1p-120, 0x1p-75, 0x1p-50, 0x1p50, 0x1p75, 0x1p120, 0x1p240}) {
    SCOPED_TRACE(s);
    EXPECT_EQ(as_ever(s), expected);
  }
}

// Cospherical and coplanar throughout, 2,400 of the points on the hull.
TEST(DelaunayTetrahedralization, OfALargeGridIsSound) {
  std::vector<Point3> points;
  constexpr int kSide = 19;
  for (int i = 0; i < 20 * 20 * 20; ++i) {
    const Point3 p{{double(i % 20), double(i / 20 % 20), double(i / 400)}};
    const auto extreme = [](double x) { return x == 0 || x == kSide; };
    if (!extreme(p[0]) || !extreme(p[1]) || !extreme(p[2])) points.push_back(p);
  }
  DelaunayTetrahedralization dt;
  dt.Reset({{0, 0, 0}}, {{kSide, kSide, kSide}}, {0, 1, 2, 3, 4, 5, 6, 7});
  dt.InsertAll(IndicesFrom8(points.size()), points);
  ExpectSound(dt);
  EXPECT_EQ(dt.vertex_count(), 8000u);
  // No flat ones: each cell of the grid is cut into five or six.
  EXPECT_GE(dt.simplex_count(), 5u * kSide * kSide * kSide);
  EXPECT_LE(dt.simplex_count(), 6u * kSide * kSide * kSide);
}

TEST(DelaunayTetrahedralization, LocateFindsATetrahedronThatHoldsThePoint) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const Layout layout : kAllLayouts) {
    SCOPED_TRACE(LayoutName(layout));
    auto points = DistinctPoints(layout, seed, 300);
    const std::size_t half = points.size() / 2;
    const auto dt = Tetrahedralize({points.begin(), points.begin() + static_cast<long>(half)});
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (const VertexIndex near : {0u, 7u, static_cast<VertexIndex>(8 + i % half), kInfinite}) {
        const SimplexIndex t = dt.Locate(points[i], near);
        ASSERT_FALSE(dt.IsInfinite(t));
        const auto& v = dt.vertices(t);
        for (const auto& [a, b, c] : DelaunayTetrahedralization::kFacet) {
          ASSERT_GE(Orientation(dt.position(v[a]), dt.position(v[b]), dt.position(v[c]), points[i]),
                    0);
        }
        ASSERT_TRUE(i < half || dt.Conflicts(t, points[i]));
      }
    }
  }
}

TEST(DelaunayTetrahedralization, LocateOutsideTheBoxIsInfinite) {
  const auto dt = Tetrahedralize(DistinctPoints(Layout::kUniform, 2, 100));
  for (const Point3& p : {Point3{{3, 0, 0}}, Point3{{0, -2, 0}}, Point3{{9, 9, 9}}}) {
    const SimplexIndex t = dt.Locate(p, 20);
    EXPECT_TRUE(dt.IsInfinite(t));
    EXPECT_TRUE(dt.Conflicts(t, p));
  }
}

// Points on a sphere up to an ulp, and by chance: the cached sphere is conservative, and decides
// for nearly all spheres.
TEST(DelaunayTetrahedralization, ConflictsIsExact) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const Layout layout : kAllLayouts) {
    SCOPED_TRACE(LayoutName(layout));
    const auto points = DistinctPoints(layout, seed, 150);
    const auto dt = Tetrahedralize({points.begin(), points.begin() + 20});
    dt.ForEachSimplex([&](SimplexIndex t) {
      std::array<Point3, 4> x;
      for (std::size_t i = 0; i < 4; ++i) x[i] = dt.position(dt.vertices(t)[i]);
      const auto check = [&](const Point3& p) {
        if (std::find(x.begin(), x.end(), p) != x.end()) return;
        ASSERT_EQ(dt.Conflicts(t, p), InSphere(x[0], x[1], x[2], x[3], p));
      };
      for (Point3 p : points) {
        check(p);
        if (std::find(x.begin(), x.end(), p) == x.end()) continue;
        for (double& coordinate : p.c) {  // a corner, moved a little
          const double to = coordinate < 0.5 ? 1 : 0;
          coordinate = coordinate == 0 ? 0x1p-54 : std::nextafter(coordinate, to);
          check(p);
        }
      }
    });
  }
}

TEST(DelaunayTetrahedralization, NearlyAllHaveASphere) {
  const auto dt = Tetrahedralize(DistinctPoints(Layout::kUniform, 3, 5000));
  std::size_t with = 0;
  for (SimplexIndex t = 0; t < dt.simplex_limit(); ++t) {
    with += dt.HasSphere(t);
    ASSERT_FALSE(dt.HasSphere(t) && dt.IsInfinite(t));
  }
  EXPECT_GT(with, dt.simplex_count() * 999 / 1000);
}

TEST(DelaunayTetrahedralization, TagsStayUntilTheTetrahedronGoes) {
  auto dt = Tetrahedralize(DistinctPoints(Layout::kUniform, 4, 50));
  std::map<std::array<VertexIndex, 4>, std::uint64_t> tags;
  for (SimplexIndex t = 0; t < dt.simplex_limit(); ++t) {
    dt.set_tag(t, t + 1);
    if (!dt.IsUnused(t)) tags[dt.vertices(t)] = t + 1;
  }
  const auto check = [&] {
    ASSERT_FALSE(dt.deleted().empty());
    for (std::size_t i = 0; i < dt.deleted().size(); ++i) {
      EXPECT_EQ(dt.deleted_tags()[i], tags.at(dt.deleted()[i]));
    }
    for (const SimplexIndex t : dt.created()) {
      EXPECT_EQ(dt.tag(t), 0u);
      tags[dt.vertices(t)] = 0;
    }
    for (SimplexIndex t = 0; t < dt.simplex_limit(); ++t) {
      EXPECT_TRUE(dt.IsUnused(t) || dt.tag(t) == tags.at(dt.vertices(t)));
    }
  };
  dt.Insert(1000, {{0.501, 0.499, 0.5}}, 0);
  check();
  dt.Remove(20);
  check();
}

TEST(DelaunayTetrahedralization, StarsAreAllTetrahedraAtAVertex) {
  const auto dt = Tetrahedralize(DistinctPoints(Layout::kBoxFaces, 5, 300));
  std::map<VertexIndex, std::set<SimplexIndex>> expected;
  for (SimplexIndex t = 0; t < dt.simplex_limit(); ++t) {
    if (dt.IsUnused(t)) continue;
    for (const VertexIndex v : dt.vertices(t)) expected[v].insert(t);
  }
  EXPECT_EQ(expected.size(), dt.vertex_count() + 1);
  DelaunayTetrahedralization::Star star;
  for (const auto& [v, tetrahedra] : expected) {
    dt.SimplicesAround(v, &star);
    std::set<SimplexIndex> actual;
    for (const auto& [t] : star.keys()) EXPECT_TRUE(actual.insert(t).second);
    EXPECT_EQ(actual, tetrahedra);
    const auto corner = dt.Around(v);
    EXPECT_EQ(dt.vertices(corner.simplex)[corner.index], v);
  }
}

// True if the link of v is the facets opposite to it, joined across their edges.
void CheckLink(const DelaunayTetrahedralization& dt, VertexIndex v,
               DelaunayTetrahedralization::VertexLink* link) {
  dt.LinkOf(v, link);
  link->Join();
  const auto id = [&](int triangle, int k) {
    return link->neighbours[link->triangles[triangle][k]];
  };
  std::set<std::array<VertexIndex, 3>> facets, expected;
  bool is_closed = true;
  dt.ForEachSimplexAround(v, [&](SimplexIndex t) {
    std::array<VertexIndex, 3> facet;
    std::ranges::remove_copy(dt.vertices(t), facet.begin(), v);
    std::ranges::sort(facet);
    expected.insert(facet);
    is_closed = is_closed && !dt.IsInfinite(t);
  });
  EXPECT_EQ(link->is_closed, is_closed);
  for (int i = 0; i < static_cast<int>(link->triangles.size()); ++i) {
    std::array<VertexIndex, 3> facet = {id(i, 0), id(i, 1), id(i, 2)};
    if (is_closed) {
      EXPECT_GT(geometry::Orientation(dt.position(v), dt.position(facet[0]), dt.position(facet[1]),
                                      dt.position(facet[2])),
                0);
    }
    std::ranges::sort(facet);
    EXPECT_TRUE(facets.insert(facet).second);
    for (int k = 0; k < 3; ++k) {
      // The same edge the other way round, and this one across it.
      const int across = link->across[i][k];
      int back = 0;
      while (back < 3 && link->across[across][back] != i) ++back;
      ASSERT_LT(back, 3);
      EXPECT_EQ(id(i, (k + 1) % 3), id(across, (back + 2) % 3));
      EXPECT_EQ(id(i, (k + 2) % 3), id(across, (back + 1) % 3));
    }
  }
  EXPECT_EQ(facets, expected);
}

TEST(DelaunayTetrahedralization, LinksAreTheFacetsOppositeToAVertexJoinedAcrossTheirEdges) {
  const auto dt = Tetrahedralize(DistinctPoints(Layout::kBoxFaces, 6, 300));
  DelaunayTetrahedralization::VertexLink link;
  int closed = 0, open = 0;
  for (VertexIndex v = 0; v < 300; ++v) {
    if (!dt.Contains(v)) continue;
    CheckLink(dt, v, &link);
    ++(link.is_closed ? closed : open);
  }
  EXPECT_GT(closed, 0);
  EXPECT_GT(open, 0);
}

TEST(DelaunayTetrahedralization, LinksMayBeLarge) {
  // One among many that are about as far away.
  for (const int count : {50, 64, 65, 66, 70, 1000}) {
    std::vector<Point3> points = {{{0.5, 0.5, 0.5}}};
    std::mt19937_64 bits(static_cast<unsigned>(count));
    std::normal_distribution<double> normal;
    while (static_cast<int>(points.size()) <= count) {
      const double x = normal(bits), y = normal(bits), z = normal(bits);
      const double r = 0.3 / std::sqrt(x * x + y * y + z * z);
      points.push_back({{0.5 + r * x, 0.5 + r * y, 0.5 + r * z}});
    }
    const auto dt = Tetrahedralize(points);
    DelaunayTetrahedralization::VertexLink link;
    std::size_t most = 0;
    for (VertexIndex v = 0; v < 8 + points.size(); ++v) {
      if (!dt.Contains(v)) continue;
      CheckLink(dt, v, &link);
      most = std::max(most, link.neighbours.size());
    }
    EXPECT_GE(most, static_cast<std::size_t>(count));
  }
}

}  // namespace
}  // namespace dynmesh::delaunay::delaunay_tetrahedralization_test
