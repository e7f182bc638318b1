// Polygons with very many corners: checking them against each other takes about as long as reading
// them.
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/error.h"
#include "tests/core/plc/plc_test_util.h"

namespace dynmesh::plc::large_polygons_test {
namespace {

constexpr int kTeeth = 20'000;
constexpr double kTop = 0.5;

// Corners 1 to kTeeth + 1 in a row at the height of kTop; a polygon with that many teeth which
// touch the row with their tips. It hangs down, or lies towards -y. Its own corners and itself
// have ids from `first` on.
EditBatch Jagged(FeatureId first, bool hangs) {
  const double width = 0.9 / kTeeth, depth = 0.8 * width;
  EditBatch batch;
  std::vector<FeatureId> ring;
  FeatureId next = first;
  const auto add = [&](double along, double off) {
    ring.push_back(next);
    batch.push_back(AddPoint3(next++, along, hangs ? kTop : kTop - off, hangs ? kTop - off : kTop));
  };
  for (int i = 0; i < kTeeth; ++i) {
    ring.push_back(1 + static_cast<FeatureId>(i));
    add(0.05 + width * (i + 0.5), depth);
  }
  ring.push_back(1 + static_cast<FeatureId>(kTeeth));
  add(0.97, 0.0286);
  add(0.97, 0.25);
  add(0.03, 0.25);
  add(0.03, 0.0286);
  batch.push_back(AddPolygon(next, {std::move(ring)}));
  return batch;
}

EditBatch Row() {
  EditBatch batch;
  for (int i = 0; i <= kTeeth; ++i) {
    batch.push_back(AddPoint3(1 + static_cast<FeatureId>(i), 0.05 + 0.9 / kTeeth * i, kTop, kTop));
  }
  return batch;
}

TEST(LargePolygons, MeetInManyCorners) {
  Plc3 plc(Cube(0, 1));
  Apply(plc, Row() + Jagged(1'000'000, false) + Jagged(2'000'000, true));
  EXPECT_FALSE(plc.Check({AddPoint3(9'000'000, 0.5, 0.4, kTop)}).ok());
  EXPECT_TRUE(plc.Check({AddPoint3(9'000'000, 0.5, 0.6, kTop)}).ok());
}

TEST(LargePolygons, HaveManyHoles) {
  constexpr int kSide = 120;
  EditBatch batch = {AddPoint3(1, 0.1, 0.1, kTop), AddPoint3(2, 0.9, 0.1, kTop),
                     AddPoint3(3, 0.9, 0.9, kTop), AddPoint3(4, 0.1, 0.9, kTop)};
  Rings rings = {{1, 2, 3, 4}};
  FeatureId next = 5;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const double x = 0.11 + 0.78 / kSide * i, y = 0.11 + 0.78 / kSide * j, side = 0.3 / kSide;
      for (int k = 0; k < 4; ++k) {
        batch.push_back(
            AddPoint3(next + k, x + (k == 1 || k == 2) * side, y + (k / 2) * side, kTop));
      }
      rings.push_back({next, next + 1, next + 2, next + 3});
      next += 4;
    }
  }
  batch.push_back(AddPolygon(next, std::move(rings)));
  Plc3 plc(Cube(0, 1));
  Apply(plc, batch);
  const double x = 0.11 + 0.78 / kSide * 60, y = 0.11 + 0.78 / kSide * 70;
  EXPECT_TRUE(plc.Check({AddPoint3(next + 1, x + 0.15 / kSide, y + 0.1 / kSide, kTop)}).ok());
  EXPECT_FALSE(plc.Check({AddPoint3(next + 1, x + 0.15 / kSide, y - 0.1 / kSide, kTop)}).ok());
}

}  // namespace
}  // namespace dynmesh::plc::large_polygons_test
