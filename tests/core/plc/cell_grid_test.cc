// Cells and segments: exact tests are exact, conservative ones err to one side.
#include "core/plc/cell_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "core/plc/rules.h"
#include "tests/core/plc/plc_test_util.h"

namespace dynmesh::plc::cell_grid_test {
namespace {

using geometry::Point2;

TEST(CellGrid, RootHoldsTheClosedBox) {
  for (const double hi : {1.0, 0.75, 1.5, 100.0, 3e-7}) {
    const MeshOptions options = Square(-hi / 3, hi);
    const CellGrid<2> grid(options.box, CloseLimit(options));
    const UnitPoint<2> corner = grid.ToUnits({{hi, hi}}),
                       origin = grid.ToUnits({{-hi / 3, -hi / 3}});
    EXPECT_EQ(CellGrid<2>::Quantise(origin[0]), 0);
    EXPECT_LT(CellGrid<2>::Quantise(corner[0]), grid.root().side);
    EXPECT_GE(CellGrid<2>::Quantise(corner[0]), grid.root().side / 2);
  }
  const MeshOptions options = Square(5, 5);
  EXPECT_EQ(CellGrid<2>(options.box, CloseLimit(options)).root().side, 1);
}

TEST(CellGrid, ChildrenTileTheirParent) {
  const Cell<2> cell{{8, 24}, 8};
  std::int64_t area = 0;
  for (int i = 0; i < 4; ++i) {
    const Cell<2> child = cell.Child(i);
    area += child.side * child.side;
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_GE(child.at[axis], cell.at[axis]);
      EXPECT_LE(child.at[axis] + child.side, cell.at[axis] + cell.side);
    }
    for (int j = 0; j < i; ++j) EXPECT_NE(cell.Child(j).at, child.at);
  }
  EXPECT_EQ(area, cell.side * cell.side);
}

// Units are 2^-45 in the unit square.
TEST(CellGrid, ASegmentSpansACellIfBothItsEndsAreInOtherColumns) {
  const CellGrid<2> grid(Square(0, 1).box, 0x1p-41);
  const Cell<2> cell{{16, 0}, 16};
  const auto spans = [&](double from, double to, bool flat) {
    const double u = 0x1p-45;
    const Point2 p{{from * u, 3 * u}}, q{{to * u, 4 * u}};
    const Point2 ps{{p[1], p[0]}}, qs{{q[1], q[0]}};
    const SegmentFeature<2> f =
        flat ? SegmentFeature<2>{1, 2, 3, p, q} : SegmentFeature<2>{1, 2, 3, ps, qs};
    const GridSegment<2> forward(f, grid), backward({1, 3, 2, f.q, f.p}, grid);
    const Cell<2> at = flat ? cell : Cell<2>{{cell.at[1], cell.at[0]}, cell.side};
    EXPECT_EQ(forward.flat, flat);
    EXPECT_EQ(forward.Spans(at), backward.Spans(at));
    return forward.Spans(at);
  };
  for (const bool flat : {true, false}) {
    EXPECT_TRUE(spans(15.9, 32, flat));
    EXPECT_TRUE(spans(0, 100, flat));
    EXPECT_FALSE(spans(16, 32, flat));
    EXPECT_FALSE(spans(16.5, 33, flat));
    EXPECT_FALSE(spans(15.9, 31.9, flat));
    EXPECT_FALSE(spans(0, 10, flat));
    EXPECT_FALSE(spans(40, 60, flat));
  }
}

TEST(CellGrid, ASegmentMeetsEveryCellThatHoldsAPointOfIt) {
  const std::uint64_t seed = 31;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const CellGrid<2> grid(Square(0, 1).box, 0x1p-41);
  for (int i = 0; i < 20000; ++i) {
    const double length = std::ldexp(1.0, -static_cast<int>(random() % 38));
    const Point2 p{{unit(random), unit(random)}};
    const Point2 q{{std::clamp(p[0] + length * (unit(random) - 0.5), 0.0, 1.0),
                    std::clamp(p[1] + length * (unit(random) - 0.5), 0.0, 1.0)}};
    const GridSegment<2> segment({1, 2, 3, p, q}, grid);
    const double t = unit(random);
    const UnitPoint<2> at = grid.ToUnits({{p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])}});
    for (Cell<2> cell = grid.root(); cell.side > 1;) {
      ASSERT_TRUE(segment.Meets(cell, 0.25)) << "seed " << seed << ", try " << i;
      int child = 0;
      for (int axis = 0; axis < 2; ++axis) {
        if (CellGrid<2>::Quantise(at[axis]) >= cell.at[axis] + cell.side / 2) child += 1 << axis;
      }
      cell = cell.Child(child);
    }
  }
}

TEST(CellGrid, ASegmentDoesNotMeetCellsWellBesideIt) {
  const CellGrid<2> grid(Square(0, 1).box, 0x1p-41);
  const GridSegment<2> diagonal({1, 2, 3, {{0, 0}}, {{1, 1}}}, grid);
  const std::int64_t quarter = std::int64_t{1} << 43;
  EXPECT_TRUE(diagonal.Meets({{quarter, quarter}, quarter}, 0.25));
  EXPECT_FALSE(diagonal.Meets({{0, 2 * quarter}, quarter}, 0.25));
  EXPECT_FALSE(diagonal.Meets({{2 * quarter + 2, 0}, 2 * quarter}, 0.25));
  EXPECT_TRUE(diagonal.Meets({{2 * quarter, 0}, 2 * quarter}, 0.25));  // its corner
}

}  // namespace
}  // namespace dynmesh::plc::cell_grid_test
