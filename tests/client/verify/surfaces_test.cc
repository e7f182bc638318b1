// `verify` must find the closed surfaces of a 3D input, and every wrong label. Uses a grid of
// cubes, each cut into six tetrahedra; some sides of cubes are polygons.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "client/verify/verify_internal.h"

namespace dynmesh::cli {
namespace {

constexpr int kSide = 4;  // cubes
using Cell = std::array<int, 3>;

std::uint32_t VertexAt(const Cell& c) {
  return static_cast<std::uint32_t>(c[0] + (kSide + 1) * (c[1] + (kSide + 1) * c[2]));
}

class Grid {
 public:
  Grid() {
    mesh_.dimension = 3;
    mesh_.vertices.resize((kSide + 1) * (kSide + 1) * (kSide + 1));
    Cell cell;
    for (cell[2] = 0; cell[2] < kSide; ++cell[2]) {
      for (cell[1] = 0; cell[1] < kSide; ++cell[1]) {
        for (cell[0] = 0; cell[0] < kSide; ++cell[0]) AddCube(cell);
      }
    }
    mesh_.regions.numbers.assign(mesh_.tetrahedra.size(), 0);
  }

  // The square of a cube's low side along the axis becomes a polygon.
  void AddSquare(FeatureId id, int axis, const Cell& cell) {
    std::vector<FeatureId> ring;
    for (const auto& [u, v] :
         {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
      Cell corner = cell;
      corner[static_cast<std::size_t>((axis + 1) % 3)] += u;
      corner[static_cast<std::size_t>((axis + 2) % 3)] += v;
      ring.push_back(VertexAt(corner) + 1);
    }
    features_.push_back(Feature::Polygon(id, {ring}));
    // The diagonal leads from the low corner to the high one.
    for (const std::size_t k : {1U, 3U}) {
      std::array<std::uint32_t, 3> v = {static_cast<std::uint32_t>(ring[0] - 1),
                                        static_cast<std::uint32_t>(ring[k] - 1),
                                        static_cast<std::uint32_t>(ring[2] - 1)};
      std::sort(v.begin(), v.end());
      mesh_.faces.push_back({v, id});
    }
  }
  // All of the surface of a block of cubes.
  void AddBlock(FeatureId id, const Cell& lo, const Cell& hi) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t x = (axis + 1) % 3, y = (axis + 2) % 3;
      Cell cell;
      for (cell[x] = lo[x]; cell[x] < hi[x]; ++cell[x]) {
        for (cell[y] = lo[y]; cell[y] < hi[y]; ++cell[y]) {
          for (const int at : {lo[axis], hi[axis]}) {
            cell[axis] = at;
            AddSquare(id++, static_cast<int>(axis), cell);
          }
        }
      }
    }
  }
  // Region `number` is the one in those surfaces; labels the cubes of a block.
  void Name(std::vector<FeatureId> surfaces) { mesh_.regions.polygons.push_back(surfaces); }
  void Label(std::uint32_t number, const Cell& lo, const Cell& hi) {
    for (std::size_t t = 0; t < cells_.size(); ++t) {
      bool inside = true;
      for (std::size_t k = 0; k < 3; ++k) {
        inside = inside && lo[k] <= cells_[t][k] && cells_[t][k] < hi[k];
      }
      if (inside) mesh_.regions.numbers[t] = number;
    }
  }
  std::uint32_t& region(std::size_t t) { return mesh_.regions.numbers[t]; }
  std::size_t size() const { return cells_.size(); }
  std::vector<Feature>& features() { return features_; }

  std::uint64_t Failures() const {
    return CheckRegions(mesh_, CollectFaces(mesh_), features_).failures;
  }

 private:
  void AddCube(const Cell& cell) {
    std::array<std::size_t, 3> axes = {0, 1, 2};
    do {
      Cell at = cell;
      io::IndexedMesh::Tetrahedron t;
      t[0] = VertexAt(at);
      for (std::size_t k = 0; k < 3; ++k) {
        ++at[axes[k]];
        t[k + 1] = VertexAt(at);
      }
      mesh_.tetrahedra.push_back(t);
      cells_.push_back(cell);
    } while (std::next_permutation(axes.begin(), axes.end()));
  }

  io::IndexedMesh mesh_;
  std::vector<Cell> cells_;  // of the tetrahedra
  std::vector<Feature> features_;
};

TEST(VerifySurfaces, AcceptsBlocksInEachOtherAndBesideThem) {
  Grid grid;
  EXPECT_EQ(grid.Failures(), 0U);
  grid.AddBlock(1000, {0, 0, 0}, {3, 3, 3});  // at the border
  grid.AddBlock(500, {1, 1, 1}, {2, 2, 2});
  grid.AddBlock(2000, {3, 3, 3}, {4, 4, 4});  // has a corner of the first one's, no edge
  grid.AddSquare(3000, 0, {2, 2, 2});         // dangles
  EXPECT_GT(grid.Failures(), 0U);
  grid.Name({1000});
  grid.Name({500, 1000});
  grid.Name({2000});
  grid.Label(1, {0, 0, 0}, {3, 3, 3});
  grid.Label(2, {1, 1, 1}, {2, 2, 2});
  grid.Label(3, {3, 3, 3}, {4, 4, 4});
  EXPECT_EQ(grid.Failures(), 0U);
}

TEST(VerifySurfaces, FindsEveryWrongLabel) {
  Grid grid;
  grid.AddBlock(1000, {1, 1, 1}, {3, 3, 3});
  grid.Name({1000});
  grid.Name({1001});
  grid.Label(1, {1, 1, 1}, {3, 3, 3});
  ASSERT_EQ(grid.Failures(), 0U);
  for (std::size_t t = 0; t < grid.size(); ++t) {
    const std::uint32_t good = grid.region(t);
    for (std::uint32_t wrong = 0; wrong < 3; ++wrong) {
      if (wrong == good) continue;
      grid.region(t) = wrong;
      EXPECT_EQ(grid.Failures(), 1U) << "tetrahedron " << t << " as " << wrong;
    }
    grid.region(t) = good;
  }
}

TEST(VerifySurfaces, KnowsRoomsWithCommonWalls) {
  Grid grid;
  grid.AddBlock(1000, {1, 1, 1}, {3, 2, 2});
  grid.AddBlock(10, {0, 3, 3}, {1, 4, 4});  // apart
  grid.Name({1000});
  grid.Name({5});
  grid.Name({10});
  grid.Label(1, {1, 1, 1}, {3, 2, 2});
  grid.Label(3, {0, 3, 3}, {1, 4, 4});
  EXPECT_EQ(grid.Failures(), 0U);
  // From the first room, entered through 1000, the wall leads into the second.
  grid.AddSquare(5, 0, {2, 1, 1});
  EXPECT_EQ(grid.Failures(), 6U);
  grid.Label(2, {2, 1, 1}, {3, 2, 2});
  const std::uint64_t one = grid.Failures();
  grid.Label(1, {2, 1, 1}, {3, 2, 2});
  grid.Label(2, {1, 1, 1}, {2, 2, 2});
  const std::uint64_t other = grid.Failures();
  EXPECT_EQ(std::min(one, other), 0U);
  EXPECT_EQ(std::max(one, other), 12U);
}

TEST(VerifySurfaces, KnowsWhatEnclosesNothing) {
  Grid grid;
  grid.AddBlock(1000, {1, 1, 1}, {3, 2, 2});
  EXPECT_GT(grid.Failures(), 0U);
  grid.features().pop_back();  // a hole
  EXPECT_EQ(grid.Failures(), 0U);
}

}  // namespace
}  // namespace dynmesh::cli
