// The cost of a check: visited index cells and features, which determine the time, depend on the
// batch and its neighbourhood, not on the total number.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <iostream>
#include <random>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/error.h"
#include "tests/core/plc/plc_test_util.h"

namespace dynmesh::plc::plc_cost_test {
namespace {

std::uint64_t CostOf(const Plc2& plc, const EditBatch& batch) {
  std::uint64_t cost = 0;
  const absl::Status status = plc.Check(batch, &cost).status();
  EXPECT_TRUE(status.ok()) << status;
  return cost;
}

// Streets: side x side points, each joined to the next in its row and in its column.
EditBatch Streets(int side, double lo, double hi, FeatureId first_id) {
  EditBatch batch;
  const auto point = [&](int i, int j) { return first_id + FeatureId(i) * side + j; };
  const double step = (hi - lo) / side;
  FeatureId id = point(side, 0);
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j)
      batch.push_back(AddPoint(point(i, j), lo + i * step, lo + j * step));
  }
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      if (i + 1 < side) batch.push_back(AddSegment(id++, point(i, j), point(i + 1, j)));
      if (j + 1 < side) batch.push_back(AddSegment(id++, point(i, j), point(i, j + 1)));
    }
  }
  return batch;
}

// An edit around a place, of the size of the distances there: a point that comes, one
// that moves with its segments, a segment.
EditBatch LocalEdit(double x, double y, double step, FeatureId first_id) {
  return {AddPoint(first_id, x, y), AddPoint(first_id + 1, x + step / 3, y + step / 4),
          AddSegment(first_id + 2, first_id, first_id + 1)};
}

TEST(PlcCost, OfALocalEditDoesNotGrowWithFeaturesElsewhere) {
  const FeatureId kNew = 10'000'000;
  std::vector<std::uint64_t> costs;
  for (const int side : {0, 58, 182}) {  // 0, 10k and 100k features elsewhere
    Plc2 plc(Square(0, 1));
    Apply(plc, Streets(18, 0.0, 0.25, 1));
    if (side > 0) Apply(plc, Streets(side, 0.5, 1.0, 1'000'000));
    std::uint64_t cost = 0;
    for (int k = 0; k < 100; ++k) {
      const double step = 0.25 / 18, x = (k % 10 + 3.3) * step, y = (k / 10 + 3.4) * step;
      cost += CostOf(plc, LocalEdit(x, y, step, kNew));
      // A crossing moves by a tenth of a street, its four streets with it.
      const FeatureId crossing = 1 + FeatureId(k / 10 + 3) * 18 + (k % 10 + 3);
      cost += CostOf(plc, {Edit::Move(crossing, (k / 10 + 3.1) * step, (k % 10 + 3.1) * step)});
    }
    costs.push_back(cost / 200);
    std::cout << plc.size() << " features: " << cost / 200 << " per edit\n";
  }
  EXPECT_LT(costs[1], costs[0] * 1.1);
  EXPECT_LT(costs[2], costs[0] * 1.1);
}

TEST(PlcCost, OfALocalEditGrowsWithTheDepthOnly) {
  const FeatureId kNew = 10'000'000;
  std::vector<std::uint64_t> costs;
  for (const int side : {18, 182}) {  // 1k, 100k features, everywhere
    Plc2 plc(Square(0, 1));
    Apply(plc, Streets(side, 0, 1, 1));
    std::uint64_t cost = 0;
    for (int k = 0; k < 100; ++k) {
      const double step = 1.0 / side;
      cost += CostOf(plc, LocalEdit((k % 10 + 3.3) * step, (k / 10 + 3.4) * step, step, kNew));
    }
    costs.push_back(cost / 100);
    std::cout << plc.size() << " features: " << cost / 100 << " per edit\n";
  }
  EXPECT_LT(costs[1], costs[0] * 2);
}

// n long segments side by side: a point between two of them visits those two.
TEST(PlcCost, LongParallelSegmentsCostABisection) {
  for (const bool slanted : {false, true}) {
    std::vector<double> costs;
    for (const int n : {500, 5000, 50000}) {
      MeshOptions options = Square(0, 1);
      options.limits.max_vertices = std::uint64_t{1} << 60;  // it is not meshed
      Plc2 plc(options);
      const double step = 0.5 / n, rise = slanted ? 0.4 : 0;
      EditBatch batch;
      for (int i = 0; i < n; ++i) {
        const FeatureId id = 1 + 3 * FeatureId(i);
        batch.push_back(AddPoint(id, 0.03125, 0.0625 + i * step));
        batch.push_back(AddPoint(id + 1, 0.9375, 0.0625 + rise + i * step));
        batch.push_back(AddSegment(id + 2, id, id + 1));
      }
      std::uint64_t build = 0;
      const absl::StatusOr<Delta<2>> delta = plc.Check(batch, &build);
      ASSERT_TRUE(delta.ok()) << delta.status();
      plc.Apply(*delta);
      std::uint64_t cost = 0;
      const FeatureId id = 1'000'000'000;
      for (int i = 0; i < 100; ++i) {
        const double y = 0.0625 + (i * (n / 100) + 0.5) * step;
        // One more in between, and a short one in the middle.
        cost += CostOf(plc, {AddPoint(id, 0.03125, y), AddPoint(id + 1, 0.9375, y + rise),
                             AddSegment(id + 2, id, id + 1)});
        const double x = 0.484375, middle = y + rise / 2;
        cost += CostOf(plc, {AddPoint(id, x, middle - step / 4), AddPoint(id + 1, x, middle),
                             AddSegment(id + 2, id, id + 1)});
      }
      costs.push_back(cost / 200.0);
      std::cout << n << " long segments: " << cost / 200 << " per edit, " << build / n
                << " each to enter, " << plc.index().node_count() << " nodes\n";
      EXPECT_LT(build / n, 1000u);
      EXPECT_LT(plc.index().node_count(), 20u * n);
    }
    EXPECT_LT(costs[2], costs[0] * 3);
  }
}

// `count` spokes from the middle to a circle, of different lengths.
EditBatch Wheel(int count) {
  EditBatch batch = {AddPoint(1, 0.5, 0.5)};
  for (int i = 0; i < count; ++i) {
    const double angle = 6.283185307179586 * i / count, r = 0.25 + 0.1 * (i % 3);
    batch.push_back(AddPoint(2 + i, 0.5 + r * std::cos(angle), 0.5 + r * std::sin(angle)));
  }
  for (int i = 0; i < count; ++i) batch.push_back(AddSegment(2 + count + i, 1, 2 + i));
  return batch;
}

TEST(PlcCost, OfASegmentDoesNotGrowWithThoseThatMeetAtItsEnd) {
  std::vector<double> per_segment, of_another;
  for (const int count : {1000, 8000}) {
    Plc2 plc(Square(0, 1));
    const EditBatch wheel = Wheel(count);
    per_segment.push_back(static_cast<double>(CostOf(plc, wheel)) / count);
    Apply(plc, wheel);
    const EditBatch again = {Edit::Remove(2 + count), AddSegment(2 + count, 2, 1)};
    of_another.push_back(static_cast<double>(CostOf(plc, again)));
  }
  std::cout << "cost of a spoke: " << per_segment[0] << ", " << per_segment[1]
            << "; of one more: " << of_another[0] << ", " << of_another[1] << "\n";
  EXPECT_LT(per_segment[1], 1.5 * per_segment[0]);
  EXPECT_LT(of_another[1], 1.5 * of_another[0]);
}

// All is replaced repeatedly: the index neither grows nor slows.
TEST(PlcCost, TheIndexDoesNotAge) {
  Plc2 plc(Square(0, 1));
  Apply(plc, Streets(20, 0, 1, 1));
  const std::size_t nodes = plc.index().node_count();
  const std::uint64_t cost = CostOf(plc, LocalEdit(0.51, 0.51, 0.05, 1'000'000));
  EditBatch away, back = Streets(20, 0, 1, 1);
  for (const Edit& edit : back) away.push_back(Edit::Remove(edit.feature.id));
  for (int i = 0; i < 20; ++i) {
    Apply(plc, away);
    EXPECT_EQ(plc.index().node_count(), 4u);
    Apply(plc, back);
  }
  EXPECT_LE(plc.index().node_count(), 2 * nodes);
  EXPECT_LE(CostOf(plc, LocalEdit(0.51, 0.51, 0.05, 1'000'000)), 2 * cost);
}

// One bad feature in a large batch: found and named without examining all pairs.
TEST(PlcCost, ALargeBatchWithOneBadFeatureIsRefusedAtThePriceOfReadingIt) {
  Plc2 plc(Square(0, 1));
  EditBatch batch = Streets(200, 0, 1, 1);  // 119,600 features
  const std::size_t at = batch.size();
  batch.push_back(AddPoint(9'000'000, 100.5 / 200, 100.0 / 200));
  std::uint64_t cost = 0;
  const absl::Status status = plc.Check(batch, &cost).status();
  ASSERT_TRUE(GetErrorDetail(status).has_value()) << status;
  EXPECT_EQ(GetErrorDetail(status)->reason, reason::kPointOnSegment);
  EXPECT_EQ(GetErrorDetail(status)->edit, at);
  std::cout << cost / batch.size() << " per feature\n";
  EXPECT_LT(cost / batch.size(), 200u);
}

}  // namespace
}  // namespace dynmesh::plc::plc_cost_test
