// An insertion has the effect that CavityOf predicts; a copy equals the original.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <string>

#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::delaunay::cavity_test {
namespace {

using Triangulation = DelaunayTetrahedralization;
using Corners = std::array<Triangulation::VertexIndex, 4>;

Corners Sorted(Corners v) {
  std::sort(v.begin(), v.end());
  return v;
}

std::set<Corners> SimplicesOf(const Triangulation& triangulation) {
  std::set<Corners> all;
  triangulation.ForEachSimplex([&](auto t) { all.insert(Sorted(triangulation.vertices(t))); });
  return all;
}

// On a grid, where ties are many, and anywhere.
TEST(Cavity, IsWhatAnInsertionUnmakesAndMakes) {
  for (const bool on_grid : {false, true}) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> within(0.1, 0.9);
    Triangulation triangulation;
    triangulation.Reset({{0, 0, 0}}, {{1, 1, 1}}, {0, 1, 2, 3, 4, 5, 6, 7});
    std::set<geometry::Point3> taken;
    for (Triangulation::VertexIndex v = 8; v < 400; ++v) {
      geometry::Point3 p;
      do {
        for (double& c : p.c) {
          c = on_grid ? static_cast<double>(1 + random() % 15) / 16 : within(random);
        }
      } while (!taken.insert(p).second);
      const auto in = triangulation.Locate(p, v - 1);
      const std::set<Corners> before = SimplicesOf(triangulation);
      Triangulation::Cavity cavity;
      triangulation.CavityOf(p, in, &cavity);
      std::set<Corners> unmade, made;
      for (const auto& [t] : cavity.simplices.keys()) {
        unmade.insert(Sorted(triangulation.vertices(t)));
      }
      for (const auto& [a, b, c] : cavity.facets) {
        made.insert(Sorted({a, b, c, v}));
        EXPECT_GT(geometry::Orientation(triangulation.position(a), triangulation.position(b),
                                        triangulation.position(c), p),
                  0);
      }
      triangulation.InsertAt(v, p, in);
      std::set<Corners> expected = before;
      for (const Corners& gone : unmade) ASSERT_EQ(expected.erase(gone), 1u);
      expected.insert(made.begin(), made.end());
      ASSERT_EQ(SimplicesOf(triangulation), expected) << v;
    }
  }
}

TEST(Cavity, ACopyGoesItsOwnWay) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> within(0.1, 0.9);
  Triangulation first, second;
  first.Reset({{0, 0, 0}}, {{1, 1, 1}}, {0, 1, 2, 3, 4, 5, 6, 7});
  for (Triangulation::VertexIndex v = 8; v < 100; ++v) {
    const double x = within(random), y = within(random);
    first.Insert(v, {{x, y, within(random)}}, v - 1);
  }
  for (Triangulation::VertexIndex v = 20; v < 30; ++v) first.Remove(v);
  second.Copy(first);
  EXPECT_EQ(SimplicesOf(second), SimplicesOf(first));
  for (Triangulation::VertexIndex v = 40; v < 80; ++v) second.Remove(v);
  first.Insert(200, {{0.5, 0.51, 0.52}}, 8);
  for (const Triangulation* each : {&first, &second}) {
    std::string why;
    EXPECT_TRUE(each->Check(&why)) << why;
  }
  EXPECT_EQ(second.vertex_count() + 41, first.vertex_count());
}

}  // namespace
}  // namespace dynmesh::delaunay::cavity_test
