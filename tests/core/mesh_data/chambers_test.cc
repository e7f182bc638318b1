#include "core/mesh_data/chambers.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <vector>

#include "gtest/gtest.h"
#include "tests/core/mesh_data/made_up_mesh.h"

namespace dynmesh::mesh_data {
namespace {

using testing::MakeRandom;
using testing::Random;

VertexId IdOf(int x, int y, int z = 0) {
  return 1 + static_cast<VertexId>(x + 100 * (y + 100 * z));
}

// A grid of n x n squares, each of two triangles.
Mesh Grid(int n) {
  Mesh mesh;
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) {
      mesh.vertices.ids.push_back(IdOf(x, y));
      mesh.vertices.coordinates.insert(mesh.vertices.coordinates.end(),
                                       {static_cast<double>(x), static_cast<double>(y)});
      mesh.vertices.containing_dimensions.push_back(0);
      mesh.vertices.owners.push_back(kNoFeature);
    }
  }
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const VertexId a = IdOf(x, y), b = IdOf(x + 1, y), c = IdOf(x + 1, y + 1), d = IdOf(x, y + 1);
      for (const VertexId id : {a, b, c, a, c, d}) mesh.simplices.push_back(id);
    }
  }
  return mesh;
}

// A grid of n^3 cubes, each of six tetrahedra around a diagonal.
Mesh SpaceGrid(int n) {
  Mesh mesh;
  mesh.dimension = 3;
  for (int z = 0; z <= n; ++z) {
    for (int y = 0; y <= n; ++y) {
      for (int x = 0; x <= n; ++x) {
        mesh.vertices.ids.push_back(IdOf(x, y, z));
        for (const int c : {x, y, z}) mesh.vertices.coordinates.push_back(c);
        mesh.vertices.containing_dimensions.push_back(0);
        mesh.vertices.owners.push_back(kNoFeature);
      }
    }
  }
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        std::array<int, 3> axes = {0, 1, 2};
        do {
          std::array<int, 3> at = {x, y, z};
          std::array<VertexId, 4> path;
          path[0] = IdOf(at[0], at[1], at[2]);
          for (std::size_t k = 0; k < 3; ++k) {
            ++at[static_cast<std::size_t>(axes[k])];
            path[k + 1] = IdOf(at[0], at[1], at[2]);
          }
          // Positively oriented for even permutations of the axes.
          const bool even = (axes[0] < axes[1]) ^ (axes[1] < axes[2]) ^ (axes[0] < axes[2]);
          if (!even) std::swap(path[2], path[3]);
          mesh.simplices.insert(mesh.simplices.end(), path.begin(), path.end());
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
    }
  }
  return mesh;
}

std::vector<std::set<VertexId>> Rows(const Mesh& mesh) {
  const auto width = static_cast<std::ptrdiff_t>(mesh.dimension) + 1;
  std::vector<std::set<VertexId>> rows;
  for (auto row = mesh.simplices.begin(); row != mesh.simplices.end(); row += width) {
    rows.emplace_back(row, row + width);
  }
  return rows;
}

std::set<VertexId> Shared(const std::set<VertexId>& a, const std::set<VertexId>& b) {
  std::set<VertexId> both;
  std::ranges::set_intersection(a, b, std::inserter(both, both.end()));
  return both;
}

void AddWall(Mesh& mesh, const std::set<VertexId>& side, FeatureId owner) {
  if (mesh.dimension == 2) {
    mesh.subsegments.ends.insert(mesh.subsegments.ends.end(), side.begin(), side.end());
    mesh.subsegments.owners.push_back(owner);
  } else {
    mesh.subfacets.corners.insert(mesh.subfacets.corners.end(), side.begin(), side.end());
    mesh.subfacets.owners.push_back(owner);
  }
}

// Every pair of rows, again and again, until nothing changes.
std::vector<std::uint32_t> NaiveChambers(const Mesh& mesh,
                                         const std::set<std::set<VertexId>>& walls) {
  const auto rows = Rows(mesh);
  std::vector<std::uint32_t> of(rows.size());
  std::iota(of.begin(), of.end(), 0U);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const auto side = Shared(rows[i], rows[j]);
        if (side.size() != static_cast<std::size_t>(mesh.dimension) || walls.contains(side))
          continue;
        const std::uint32_t least = std::min(of[i], of[j]);
        changed |= of[i] != of[j];
        of[i] = of[j] = least;
      }
    }
  }
  return of;
}

TEST(Chambers, AreThoseOfAPairwiseSearch) {
  Random random = MakeRandom();
  for (int round = 0; round < 20; ++round) {
    Mesh mesh = round % 2 == 0 ? Grid(5) : SpaceGrid(2);
    const auto rows = Rows(mesh);
    std::set<std::set<VertexId>> walls;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const auto side = Shared(rows[i], rows[j]);
        if (side.size() != static_cast<std::size_t>(mesh.dimension) || random() % 10 < 4) continue;
        walls.insert(side);
        AddWall(mesh, side, 7);
      }
    }
    const std::vector<std::uint32_t> naive = NaiveChambers(mesh, walls);
    const Chambers chambers = FindChambers(mesh);
    ASSERT_EQ(chambers.of.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        ASSERT_EQ(chambers.of[i] == chambers.of[j], naive[i] == naive[j]) << i << " " << j;
      }
    }
    std::set<std::uint32_t> outside;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      std::size_t neighbours = 0;
      for (std::size_t j = 0; j < rows.size(); ++j) {
        neighbours += Shared(rows[i], rows[j]).size() == static_cast<std::size_t>(mesh.dimension);
      }
      if (neighbours <= static_cast<std::size_t>(mesh.dimension)) outside.insert(chambers.of[i]);
    }
    for (std::uint32_t c = 0; c < chambers.count(); ++c) {
      EXPECT_EQ(chambers.is_outside[c], outside.contains(c)) << c;
    }
  }
}

// The square from (1, 1) to (2, 2) of a grid of 3 x 3.
Mesh WithRoom(FeatureId owner) {
  Mesh mesh = Grid(3);
  const VertexId a = IdOf(1, 1), b = IdOf(2, 1), c = IdOf(2, 2), d = IdOf(1, 2);
  for (const auto& side : {std::set{a, b}, {b, c}, {c, d}, {d, a}}) AddWall(mesh, side, owner);
  return mesh;
}

TEST(Chambers, ARoomOfSegmentsIsNoHoleOneOfAPolygonsEdgesIs) {
  Mesh mesh = WithRoom(7);
  Chambers chambers = FindChambers(mesh);
  ASSERT_EQ(chambers.count(), 2U);
  EXPECT_TRUE(chambers.is_outside[0]);
  EXPECT_FALSE(chambers.is_outside[1]);
  EXPECT_FALSE(chambers.is_hole[1]);
  // All around lies in polygon 7: the room is its hole.
  mesh.regions.assign(mesh.simplex_count(), 7);
  for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
    if (chambers.of[i] == 1) mesh.regions[i] = kNoRegion;
  }
  chambers = FindChambers(mesh);
  EXPECT_TRUE(chambers.is_hole[1]);
  // One of its edges is a segment's.
  mesh.subsegments.owners[2] = 9;
  EXPECT_FALSE(FindChambers(mesh).is_hole[1]);
  // The box divides nothing.
  mesh.subsegments.owners[2] = kBoxFeature;
  EXPECT_EQ(FindChambers(mesh).count(), 1U);
}

// A segment that ends in a hole, or lies in it, has the hole on both sides: it is not around it.
TEST(Chambers, ADanglingSegmentLeavesAHoleAHole) {
  Mesh mesh = Grid(4);
  const VertexId a = IdOf(1, 1), b = IdOf(3, 1), c = IdOf(3, 3), d = IdOf(1, 3);
  const VertexId ab = IdOf(2, 1), bc = IdOf(3, 2), cd = IdOf(2, 3), da = IdOf(1, 2);
  for (const auto& side :
       {std::set{a, ab}, {ab, b}, {b, bc}, {bc, c}, {c, cd}, {cd, d}, {d, da}, {da, a}}) {
    AddWall(mesh, side, 7);
  }
  const Chambers bare = FindChambers(mesh);
  ASSERT_EQ(bare.count(), 2U);
  mesh.regions.assign(mesh.simplex_count(), 7);
  for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
    if (bare.of[i] == 1) mesh.regions[i] = kNoRegion;
  }
  AddWall(mesh, {ab, IdOf(2, 2)}, 9);
  Chambers chambers = FindChambers(mesh);
  EXPECT_EQ(chambers.of, bare.of);
  EXPECT_TRUE(chambers.is_hole[1]);
  // From edge to edge it divides the hole: neither part has only edges of polygons around it.
  AddWall(mesh, {IdOf(2, 2), cd}, 9);
  chambers = FindChambers(mesh);
  ASSERT_EQ(chambers.count(), 3U);
  EXPECT_FALSE(chambers.is_hole[1] || chambers.is_hole[2]);
}

TEST(Chambers, PositionsAreLocatedExactly) {
  const Mesh mesh = WithRoom(7);
  const Chambers chambers = FindChambers(mesh);
  const double tiny = 1e-300;
  const std::vector<std::array<double, 3>> positions = {
      {1.5, 1.25, 9}, {0.5, 0.5, 0}, {1, 1.5, 0},     {1.5, 1.5, 0},
      {3, 3, 0},      {3.1, 0.5, 0}, {1e300, 0.5, 0}, {0.5, tiny, 0}};
  const auto places = LocateInChambers(mesh, chambers, positions);
  constexpr std::uint32_t kNone = PlaceInChambers::kNone;
  EXPECT_EQ(places[0], (PlaceInChambers{1, false}));
  EXPECT_EQ(places[1], (PlaceInChambers{0, false}));  // on an edge inside
  EXPECT_TRUE(places[2].is_between);
  EXPECT_EQ(places[3], (PlaceInChambers{1, false}));
  EXPECT_EQ(places[4], (PlaceInChambers{0, false}));
  EXPECT_EQ(places[5].chamber, kNone);
  EXPECT_EQ(places[6].chamber, kNone);
  EXPECT_EQ(places[7], (PlaceInChambers{0, false}));
}

TEST(Chambers, InSpaceTheyAreSeparatedByFacets) {
  Mesh mesh = SpaceGrid(2);
  for (const auto& [i, row] : [&] {
         std::vector<std::pair<int, std::set<VertexId>>> rows;
         for (const auto& r : Rows(mesh)) rows.emplace_back(0, r);
         return rows;
       }()) {
    std::set<VertexId> side;
    for (const VertexId id : row) {
      if ((id - 1) % 100 == 1) side.insert(id);  // x = 1
    }
    if (side.size() == 3) AddWall(mesh, side, 5);
  }
  const Chambers chambers = FindChambers(mesh);
  EXPECT_EQ(chambers.count(), 2U);
  EXPECT_TRUE(chambers.is_outside[0] && chambers.is_outside[1]);
  EXPECT_FALSE(chambers.is_hole[0] || chambers.is_hole[1]);  // 3D has seeds of holes only
  const std::vector<std::array<double, 3>> positions = {
      {0.5, 0.3, 0.1}, {1.5, 0.3, 0.1}, {1, 0.4, 0.9}, {0.5, 0.5, 2.5}};
  const auto places = LocateInChambers(mesh, chambers, positions);
  EXPECT_NE(places[0].chamber, places[1].chamber);
  EXPECT_FALSE(places[0].is_between);
  EXPECT_TRUE(places[2].is_between);
  EXPECT_EQ(places[3].chamber, PlaceInChambers::kNone);
  EXPECT_TRUE(LocateInChambers(mesh, chambers, {}).empty());
}

}  // namespace
}  // namespace dynmesh::mesh_data
