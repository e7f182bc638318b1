// Lattices of a facet: each contains all coarser ones, and points are distinguished by their
// indices.
#include "core/meshing/facet_lattice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace dynmesh::meshing::facet_lattice_test {
namespace {

using geometry::FacetPlane;
using geometry::Point3;

FacetPlane PlaneAcross(int axis, double slope_u, double slope_v) {
  FacetPlane plane;
  plane.axis = axis;
  plane.origin = {{0.1, 0.2, 0.3}};
  const double length = std::sqrt(1 + slope_u * slope_u + slope_v * slope_v);
  plane.normal[static_cast<std::size_t>(axis)] = 1 / length;
  plane.normal[static_cast<std::size_t>((axis + 1) % 3)] = slope_u / length;
  plane.normal[static_cast<std::size_t>((axis + 2) % 3)] = slope_v / length;
  return plane;
}

std::map<std::tuple<int, std::int64_t, std::int64_t>, Point3> PlacesOf(const FacetLattice& lattice,
                                                                       int finest) {
  std::map<std::tuple<int, std::int64_t, std::int64_t>, Point3> places;
  lattice.ForEachCellOver({{0, 0, 0}}, {{1, 1, 1}}, [&](const FacetLattice::Cell& cell) {
    return lattice.ForEachIn(cell, finest, [&](const FacetLattice::Index& index, const Point3& p) {
      EXPECT_LE(index.level, finest);
      EXPECT_TRUE(places.emplace(std::tuple(index.level, index.i, index.j), p).second);
      return true;
    });
  });
  return places;
}

TEST(FacetLattice, EachLevelHoldsTheCoarserOnesAndAsManyPointsMore) {
  for (int axis = 0; axis < 3; ++axis) {
    const FacetLattice lattice(PlaneAcross(axis, 0.5, -0.25));
    auto coarser = PlacesOf(lattice, 0);
    for (int finest = 1; finest <= 8; ++finest) {
      const auto places = PlacesOf(lattice, finest);
      for (const auto& [index, p] : coarser) {
        const auto at = places.find(index);
        ASSERT_NE(at, places.end());
        EXPECT_EQ(at->second, p);
      }
      for (const auto& [index, p] : places) {
        EXPECT_EQ(coarser.contains(index), std::get<0>(index) < finest);
      }
      std::set<Point3> different;
      for (const auto& [index, p] : places) different.insert(p);
      EXPECT_EQ(different.size(), places.size());
      EXPECT_EQ(places.size(), 2 * coarser.size());
      coarser = places;
    }
  }
}

TEST(FacetLattice, PlacesLieInThePlaneAndNoFartherApartThanTheSpacing) {
  for (int axis = 0; axis < 3; ++axis) {
    const FacetPlane plane = PlaneAcross(axis, 0.7, 0.6);
    const FacetLattice lattice(plane);
    for (const int level : {3, 4}) {
      std::vector<Point3> places;
      for (const auto& [index, p] : PlacesOf(lattice, level)) places.push_back(p);
      for (const Point3& p : places) {
        EXPECT_NEAR(plane.Height(p), 0, 1e-15);
        // The four neighbours in a square lattice; one at the corner may have one alone.
        int near = 0;
        for (const Point3& q : places) {
          const double d = std::sqrt(geometry::SquaredDistance(p, q));
          near += d > 0 && d <= lattice.Spacing(level) * (1 + 1e-12);
        }
        EXPECT_GE(near, 1);
      }
    }
  }
}

TEST(FacetLattice, LevelOfIsTheCoarsestThatIsFineEnough) {
  const FacetLattice lattice(PlaneAcross(2, 0.3, 0.1));
  for (double spacing = 1e-6; spacing < 10; spacing *= 1.37) {
    const int level = lattice.LevelOf(spacing);
    EXPECT_LE(lattice.Spacing(level), spacing * (1 + 1e-12));
    EXPECT_GT(lattice.Spacing(level - 1), spacing);
  }
}

// A cell narrower than a lattice's squares holds its lowest corner, if that is a point.
TEST(FacetLattice, SmallCellsShareThePointsOut) {
  const FacetLattice lattice(PlaneAcross(1, 0, 0));
  const auto places = PlacesOf(lattice, 3);
  std::set<Point3> found;
  for (std::int64_t i = 0; i < 32; ++i) {
    for (std::int64_t j = 0; j < 32; ++j) {
      lattice.ForEachIn({5, i, j}, 3, [&](const FacetLattice::Index&, const Point3& p) {
        EXPECT_TRUE(found.insert(p).second);
        return true;
      });
    }
  }
  std::size_t within = 0;
  for (const auto& [index, p] : places) within += p[2] >= 0 && p[2] < 1 && p[0] >= 0 && p[0] < 1;
  EXPECT_EQ(found.size(), within);
}

}  // namespace
}  // namespace dynmesh::meshing::facet_lattice_test
