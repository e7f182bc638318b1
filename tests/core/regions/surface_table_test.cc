// Closed surfaces of random sets of polygons, against the literal definition: chambers of a grid of
// cubes, found by flood fill.
#include "core/regions/surface_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::surface_table_test {
namespace {

using plc::FacetFeature;
using Polygons = std::map<FeatureId, Rings>;

std::vector<FacetFeature> Features(const Polygons& from, const Polygons& to) {
  std::vector<FacetFeature> features;
  for (const auto& [id, rings] : from) {
    const auto it = to.find(id);
    if (it == to.end() || it->second != rings) features.push_back({id, rings, {}});
  }
  return features;
}

// The squares of a grid of cubes, by the corner of least coordinates.
class Squares {
 public:
  static FeatureId At(int i, int j, int k) {
    return static_cast<FeatureId>(1 + i + 4 * (j + 4 * k));
  }
  static Rings Square(int axis, int i, int j, int k) {
    const auto at = [&](int u, int v) {
      int c[3] = {i, j, k};
      c[(axis + 1) % 3] += u;
      c[(axis + 2) % 3] += v;
      return At(c[0], c[1], c[2]);
    };
    return {{at(0, 0), at(1, 0), at(1, 1), at(0, 1)}};
  }
};

// Where a corner is: on the grid, or that turned over and moved.
class Places {
 public:
  void Change(test::Random& random) {
    for (int k = 0; k < 3; ++k) {
      sign_[k] = random.OneIn(2) ? -1 : 1;
      by_[k] = random.Unit();
    }
    first_ = random.Below(3);
  }
  geometry::Point3 operator()(FeatureId id) const {
    const auto n = static_cast<int>(id - 1);
    const int c[3] = {n % 4, n / 4 % 4, n / 16};
    geometry::Point3 p;
    for (int k = 0; k < 3; ++k) p[(k + first_) % 3] = by_[k] + sign_[k] * 0.3 * c[k];
    return p;
  }

 private:
  double sign_[3] = {1, 1, 1}, by_[3] = {0, 0, 0};
  int first_ = 0;
};

// The squares present, each with its axis and the cube above it.
struct Square {
  int axis;
  std::array<int, 3> at;
};
using PresentSquares = std::map<FeatureId, Square>;

// The surfaces of each polygon: cubes without a square in between are one chamber, or the outside.
// Dangling squares have the same one on both sides.
std::map<FeatureId, SurfaceIds> NaiveSurfaces(const PresentSquares& squares) {
  constexpr int kSide = 4;  // the grid and a layer around it
  const auto cell = [](const std::array<int, 3>& c) {
    return (c[0] + 1) + kSide * ((c[1] + 1) + kSide * (c[2] + 1));
  };
  const auto below = [](const Square& s) {
    std::array<int, 3> c = s.at;
    --c[static_cast<std::size_t>(s.axis)];
    return c;
  };
  std::set<std::pair<int, int>> cut;
  for (const auto& [id, s] : squares) cut.emplace(cell(below(s)), cell(s.at));
  std::vector<int> chamber(kSide * kSide * kSide);
  for (std::size_t i = 0; i < chamber.size(); ++i) chamber[i] = static_cast<int>(i);
  for (bool again = true; again;) {
    again = false;
    for (int axis = 0; axis < 3; ++axis) {
      std::array<int, 3> c;
      for (c[0] = -1; c[0] < 3; ++c[0]) {
        for (c[1] = -1; c[1] < 3; ++c[1]) {
          for (c[2] = -1; c[2] < 3; ++c[2]) {
            if (c[static_cast<std::size_t>(axis)] < 0) continue;
            const int a = cell(below({axis, c})), b = cell(c);
            if (cut.contains({a, b})) continue;
            int &x = chamber[static_cast<std::size_t>(a)],
                &y = chamber[static_cast<std::size_t>(b)];
            if (x == y) continue;
            x = y = std::min(x, y);
            again = true;
          }
        }
      }
    }
  }
  const auto chamber_at = [&](const std::array<int, 3>& c) {
    return chamber[static_cast<std::size_t>(cell(c))];
  };
  std::map<int, FeatureId> names = {{0, kNoFeature}};
  for (bool again = true; again;) {
    again = false;
    for (const auto& [id, s] : squares) {
      const int a = chamber_at(below(s)), b = chamber_at(s.at);
      if (names.contains(a) == names.contains(b)) continue;
      names.emplace(a, id), names.emplace(b, id);
      again = true;
      break;  // the least first
    }
  }
  std::map<FeatureId, SurfaceIds> surfaces;
  for (const auto& [id, s] : squares) {
    const int a = chamber_at(below(s)), b = chamber_at(s.at);
    if (a == b) continue;
    for (const int c : {a, b}) {
      if (c != 0) surfaces[id].push_back(names.at(c));
    }
    std::sort(surfaces[id].begin(), surfaces[id].end());
  }
  return surfaces;
}

TEST(SurfaceTable, IsWhatTheDefinitionSaysAfterEveryChange) {
  std::size_t closed = 0, shared = 0, changed = 0, moved = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    Polygons present;
    PresentSquares squares;
    Places places;
    SurfaceTable table;
    std::map<FeatureId, SurfaceIds> surfaces;
    const int shift = random.Below(100);
    const auto id_of = [&](int axis, int i, int j, int k) {
      const int number = 1 + axis + 3 * (i + 3 * (j + 3 * k));
      return static_cast<FeatureId>(1 + (number * 37 + shift) % 101);
    };
    const auto toggle = [&](int axis, int i, int j, int k) {
      const FeatureId id = id_of(axis, i, j, k);
      if (present.erase(id) == 0) {
        present[id] = Squares::Square(axis, i, j, k);
        squares[id] = {axis, {i, j, k}};
      } else {
        squares.erase(id);
      }
    };
    for (int revision = 0; revision < 30; ++revision) {
      const Polygons before = present;
      if (random.OneIn(2)) {  // a cube, made or unmade or joined to others
        const std::array<int, 3> cube = {random.Below(2), random.Below(2), random.Below(2)};
        const bool only_make = random.OneIn(2);
        for (int axis = 0; axis < 3; ++axis) {
          for (int side = 0; side < 2; ++side) {
            std::array<int, 3> at = cube;
            at[static_cast<std::size_t>(axis)] += side;
            if (only_make && present.contains(id_of(axis, at[0], at[1], at[2]))) continue;
            toggle(axis, at[0], at[1], at[2]);
          }
        }
      } else {
        for (int count = 1 + random.Below(3); count > 0; --count) {
          int at[3] = {random.Below(2), random.Below(2), random.Below(2)};
          const int axis = random.Below(3);
          at[axis] += random.Below(2);
          toggle(axis, at[0], at[1], at[2]);
        }
      }
      std::vector<FacetFeature> removed = Features(before, present);
      std::vector<FacetFeature> added = Features(present, before);
      // One moves, or all: it is in both lists.
      const bool all_move = random.OneIn(6);
      if (all_move) places.Change(random);
      for (const auto& [id, rings] : present) {
        if (!before.contains(id) || !(all_move || random.OneIn(8))) continue;
        removed.push_back({id, rings, {}});
        added.push_back({id, rings, {}});
        ++moved;
      }
      const auto by_id = [](const FacetFeature& f, const FacetFeature& g) { return f.id < g.id; };
      std::sort(removed.begin(), removed.end(), by_id);
      std::sort(added.begin(), added.end(), by_id);
      const auto changes = table.Update(removed, added, places);
      const std::map<FeatureId, SurfaceIds> expected = NaiveSurfaces(squares);
      std::vector<SurfaceTable::Change> expected_changes;
      for (const auto& [id, rings] : present) {
        const auto at = [&](const std::map<FeatureId, SurfaceIds>& all) {
          const auto it = all.find(id);
          return it == all.end() ? SurfaceIds() : it->second;
        };
        const auto said = table.SurfacesOf(id);
        ASSERT_EQ(SurfaceIds(said.begin(), said.end()), at(expected)) << "polygon " << id;
        const bool is_added = std::any_of(added.begin(), added.end(),
                                          [&](const FacetFeature& f) { return f.id == id; });
        if (!is_added && at(surfaces) != at(expected)) {
          expected_changes.push_back({id, at(surfaces), at(expected)});
        }
        shared += at(expected).size() == 2;
      }
      ASSERT_EQ(changes, expected_changes);
      surfaces = expected;
      closed += surfaces.size();
      changed += changes.size();
    }
  }
  EXPECT_GT(closed, 1000u);
  EXPECT_GT(shared, 300u);
  EXPECT_GT(changed, 300u);
  EXPECT_GT(moved, 1000u);
}

TEST(SurfaceTable, ClosesAHoleWithARimOfItsOwn) {
  // A box with a hole in face 1, from which a tube of four leads outwards without an end; then its
  // end is added.
  SurfaceTable table;
  const geometry::Ring3 outside = {{{0, 0, 0}}, {{4, 0, 0}}, {{4, 4, 0}}, {{0, 4, 0}}};
  const geometry::Ring3 hole = {{{1, 1, 0}}, {{3, 1, 0}}, {{3, 3, 0}}, {{1, 3, 0}}};
  std::vector<FacetFeature> faces = {{1, {{1, 2, 4, 3}, {11, 12, 14, 13}}, {outside, hole}},
                                     {2, {{1, 2, 6, 5}}, {}},
                                     {3, {{2, 4, 8, 6}}, {}},
                                     {4, {{4, 3, 7, 8}}, {}},
                                     {5, {{3, 1, 5, 7}}, {}},
                                     {6, {{5, 6, 8, 7}}, {}},
                                     {7, {{11, 12, 16, 15}}, {}},
                                     {8, {{12, 14, 18, 16}}, {}},
                                     {9, {{14, 13, 17, 18}}, {}},
                                     {10, {{13, 11, 15, 17}}, {}}};
  const auto anywhere = [](FeatureId) { return geometry::Point3(); };
  table.Update({}, faces, anywhere);
  for (FeatureId id = 1; id <= 10; ++id) EXPECT_TRUE(table.SurfacesOf(id).empty());
  const std::vector<FacetFeature> end = {{20, {{15, 16, 18, 17}}, {}}};
  EXPECT_EQ(table.Update({}, end, anywhere).size(), 10u);
  for (FeatureId id = 1; id <= 10; ++id) {
    ASSERT_EQ(table.SurfacesOf(id).size(), 1u);
    EXPECT_EQ(table.SurfacesOf(id)[0], 1u);
  }
  EXPECT_EQ(table.SurfacesOf(20)[0], 1u);
}

// Two boxes with one lid, and a wall between them and the lid's two rings. While the boxes are
// beside each other, the lid belongs to neither, as its rings have different sides; when nested, it
// does.
TEST(SurfaceTable, APolygonThatFallsApartDoesNotCount) {
  const auto square = [](double x, double size) {
    return geometry::Ring3{
        {{x, x, 1}}, {{x + size, x, 1}}, {{x + size, x + size, 1}}, {{x, x + size, 1}}};
  };
  const Rings rings = {{1, 2, 3, 4}, {5, 6, 7, 8}};
  const FacetFeature beside = {10, rings, {square(0, 1), square(2, 1)}};
  const FacetFeature within = {10, rings, {square(0, 4), square(1, 1)}};
  SurfaceTable table;
  std::vector<FacetFeature> all = {beside};
  for (FeatureId first : {1, 5}) {
    const FeatureId id = 10 + 10 * first, below = first + 20;
    for (FeatureId k = 0; k < 4; ++k) {
      const FeatureId next = (k + 1) % 4;
      all.push_back({id + k, {{first + k, first + next, below + next, below + k}}, {}});
    }
    all.push_back({id + 4, {{below, below + 1, below + 2, below + 3}}, {}});
  }
  const auto anywhere = [](FeatureId) { return geometry::Point3(); };
  const auto expect = [&](bool closed) {
    for (const FacetFeature& f : all) EXPECT_EQ(table.SurfacesOf(f.id).size(), closed ? 1u : 0u);
  };
  table.Update({}, all, anywhere);
  expect(false);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(table.Update({{beside}}, {{within}}, anywhere).size(), all.size() - 1);
    expect(true);
    EXPECT_EQ(table.SurfacesOf(24)[0], 10u);
    EXPECT_EQ(table.Update({{within}}, {{beside}}, anywhere).size(), all.size() - 1);
    expect(false);
  }
}

}  // namespace
}  // namespace dynmesh::surface_table_test
