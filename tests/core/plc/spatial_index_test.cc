// The index against examining everything: no relevant feature is ever missed, with many features,
// long segments, deep clusters, and after removals.
#include "core/plc/spatial_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

#include "core/geometry/segment_distance.h"
#include "core/plc/rules.h"
#include "tests/core/plc/plc_test_util.h"

namespace dynmesh::plc::spatial_index_test {
namespace {

using geometry::Point2;

constexpr double kLimit = 0x1p-41;  // of the unit square

// The index and a plain list of the same features.
class Both {
 public:
  Both() : grid_(Square(0, 1).box, kLimit), index_(grid_) {}

  FeatureId Add(Point2 p) {
    const PointFeature<2> f{next_id_++, p};
    points_.push_back({f, index_.Insert(f)});
    return f.id;
  }
  // With its ends.
  void Add(Point2 p, Point2 q) {
    const FeatureId p_id = Add(p), q_id = Add(q);
    const SegmentFeature<2> f{next_id_++, p_id, q_id, p, q};
    segments_.push_back({f, index_.Insert(f)});
  }
  // Adds it if it has no conflict with present features.
  void AddIfLegal(Point2 p, Point2 q) {
    const PointFeature<2> pf{next_id_, p}, qf{next_id_ + 1, q};
    const SegmentFeature<2> f{next_id_ + 2, pf.id, qf.id, p, q};
    if (Between(pf, qf, kLimit) == Conflict::kNone && Conflicts(pf).empty() &&
        Conflicts(qf).empty() && Conflicts(f).empty()) {
      Add(p, q);
    }
  }
  // Takes away a share of the segments, then of the points.
  void Thin(double share, std::mt19937_64& random) {
    std::bernoulli_distribution out(share);
    std::erase_if(segments_, [&](const auto& s) {
      if (!out(random)) return false;
      index_.EraseSegment(s.slot);
      return true;
    });
    std::set<FeatureId> used;
    for (const auto& s : segments_) used.insert({s.f.p_id, s.f.q_id});
    std::erase_if(points_, [&](const auto& p) {
      if (used.contains(p.f.id) || !out(random)) return false;
      index_.ErasePoint(p.slot);
      return true;
    });
  }

  std::set<FeatureId> Conflicts(const PointFeature<2>& f) const {
    std::set<FeatureId> result;
    for (const auto& p : points_) {
      if (Between(f, p.f, kLimit) != Conflict::kNone) result.insert(p.f.id);
    }
    for (const auto& s : segments_) {
      if (Between(f, s.f, kLimit) != Conflict::kNone) result.insert(s.f.id);
    }
    return result;
  }
  std::set<FeatureId> Conflicts(const SegmentFeature<2>& f) const {
    std::set<FeatureId> result;
    for (const auto& p : points_) {
      if (Between(p.f, f, kLimit) != Conflict::kNone) result.insert(p.f.id);
    }
    for (const auto& s : segments_) {
      if (Between(f, s.f, kLimit) != Conflict::kNone) result.insert(s.f.id);
    }
    return result;
  }

  template <typename Place>
  std::set<FeatureId> Answer(const Place& place, std::uint64_t* cost) const {
    std::set<FeatureId> result;
    index_.QueryNear(
        place, [&](const PointFeature<2>& p) { result.insert(p.id); },
        [&](const SegmentFeature<2>& s) { result.insert(s.id); }, cost);
    return result;
  }

  // Queries a position and fails if a conflict is missing in the answer.
  int Ask(Point2 p) const {
    std::uint64_t cost = 0;
    return Compare(Conflicts(PointFeature<2>{kAsker, p}), Answer(p, &cost));
  }
  int Ask(Point2 p, Point2 q) const {
    if (geometry::SquaredDistance(p, q) < kLimit * kLimit) return 0;
    const SegmentFeature<2> f{kAsker, kAsker - 1, kAsker - 2, p, q};
    std::uint64_t cost = 0;
    return Compare(Conflicts(f), Answer(f, &cost));
  }

  // The same for the segments nearer than a distance.
  int AskWithin(Point2 p, Point2 q, double distance) const {
    std::set<FeatureId> wanted, got;
    for (const auto& s : segments_) {
      if (geometry::SquaredDistance(p, q, s.f.p, s.f.q) < distance * distance) {
        wanted.insert(s.f.id);
      }
    }
    std::uint64_t cost = 0;
    index_.QueryWithin(
        SegmentFeature<2>{kAsker, kAsker - 1, kAsker - 2, p, q}, distance,
        [&](const SegmentFeature<2>& s) { got.insert(s.id); }, &cost);
    return Compare(wanted, got);
  }

  const SpatialIndex<2>& index() const { return index_; }
  std::size_t size() const { return points_.size() + segments_.size(); }
  // A place on or near a feature, or anywhere.
  Point2 Place(std::mt19937_64& random) const {
    const auto real = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
    const int dice = static_cast<int>(real() * 4);
    if (dice == 0 || points_.empty() || segments_.empty()) return {{real(), real()}};
    const double step = dice == 1 ? 0 : std::ldexp(real() - 0.5, -static_cast<int>(real() * 45));
    Point2 at = points_[random() % points_.size()].f.p;
    if (real() < 0.7) {
      const SegmentFeature<2>& s = segments_[random() % segments_.size()].f;
      const double t = real();
      at = {{s.p[0] + t * (s.q[0] - s.p[0]), s.p[1] + t * (s.q[1] - s.p[1])}};
    }
    return {{std::clamp(at[0] + step, 0.0, 1.0), std::clamp(at[1] - step, 0.0, 1.0)}};
  }

 private:
  static constexpr FeatureId kAsker = FeatureId{1} << 50;

  static int Compare(const std::set<FeatureId>& wanted, const std::set<FeatureId>& got) {
    EXPECT_TRUE(std::includes(got.begin(), got.end(), wanted.begin(), wanted.end()));
    return wanted.empty() ? 0 : 1;
  }

  struct APoint {
    PointFeature<2> f;
    Slot slot;
  };
  struct ASegment {
    SegmentFeature<2> f;
    Slot slot;
  };
  CellGrid<2> grid_;
  SpatialIndex<2> index_;
  std::vector<APoint> points_;
  std::vector<ASegment> segments_;
  FeatureId next_id_ = 1;
};

void AskMuch(const Both& both, std::mt19937_64& random, int times) {
  int hits = 0;
  for (int i = 0; i < times; ++i) {
    const Point2 p = both.Place(random), q = both.Place(random);
    hits += both.Ask(p);
    hits += both.Ask(p, q);
    // Short ones, and axis-parallel ones.
    const double step = std::ldexp(1.0, -static_cast<int>(random() % 45));
    hits += both.Ask(p, {{std::min(p[0] + step, 1.0), std::max(p[1] - step / 3, 0.0)}});
    hits += both.Ask(p, {{p[0], q[1]}});
    hits += both.Ask(p, {{q[0], p[1]}});
    const double distance = std::ldexp(1.0, -static_cast<int>(random() % 40));
    hits += both.AskWithin(p, q, distance);
    hits += both.AskWithin(p, {{std::min(p[0] + step, 1.0), std::max(p[1] - step, 0.0)}}, distance);
    if (testing::Test::HasFailure()) FAIL() << "try " << i;
  }
  if (both.size() > 0) {
    EXPECT_GT(hits, times / 10);
  }
}

// Queries, then removes features in portions and queries again, until nothing is left.
void Exercise(Both& both, std::uint64_t seed) {
  SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << both.size() << " features");
  std::mt19937_64 random(seed);
  for (const double share : {0.5, 0.8, 1.0}) {
    AskMuch(both, random, 120);
    both.Thin(share, random);
    if (testing::Test::HasFailure()) return;
  }
  both.Thin(1, random);
  EXPECT_EQ(both.size(), 0u);
  EXPECT_EQ(both.index().node_count(), 4u);
}

TEST(SpatialIndex, FindsAmongManyParallelLongSegments) {
  for (const double degrees : {0.0, 1.0, 22.0, 45.0, 60.0, 90.0, 135.0, 170.0}) {
    Both both;
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> jitter(0, 0.2);
    const double c = std::cos(degrees * 0.017453292519943295);
    const double s = std::sin(degrees * 0.017453292519943295);
    const int n = 700;
    for (int i = 0; i < n; ++i) {
      const double off = 0.6 * (i + 0.5) / n - 0.3;
      const double from = -0.38 + jitter(random), to = 0.38 - jitter(random);
      both.Add({{0.5 + from * c - off * s, 0.5 + from * s + off * c}},
               {{0.5 + to * c - off * s, 0.5 + to * s + off * c}});
    }
    Exercise(both, 100 + static_cast<std::uint64_t>(degrees));
  }
}

TEST(SpatialIndex, FindsAmongRandomSegmentsOfAllLengths) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Both both;
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 3000; ++i) {
      const Point2 p{{unit(random), unit(random)}};
      const double length = std::ldexp(unit(random), -static_cast<int>(random() % 12));
      const double angle = 6.283185307179586 * unit(random);
      const Point2 q{{p[0] + length * std::cos(angle), p[1] + length * std::sin(angle)}};
      if (q[0] < 0 || q[0] > 1 || q[1] < 0 || q[1] > 1) continue;
      both.AddIfLegal(p, q);
    }
    EXPECT_GT(both.size(), 900u);
    Exercise(both, seed);
  }
}

TEST(SpatialIndex, FindsInDeepClusters) {
  Both both;
  std::mt19937_64 random(99);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int scale = 0; scale <= 36; scale += 4) {
    const Point2 centre{{0.5 + 0.4 * unit(random), 0.5 + 0.4 * unit(random)}};
    for (int i = 0; i < 80; ++i) {
      const double size = std::ldexp(0.1, -scale);
      const auto near = [&] {
        return Point2{{centre[0] + size * unit(random), centre[1] + size * unit(random)}};
      };
      both.AddIfLegal(near(), near());
    }
  }
  EXPECT_GT(both.size(), 200u);
  Exercise(both, 5);
}

// Ends and segments exactly on the borders of cells and of the box.
TEST(SpatialIndex, FindsOnCellBorders) {
  Both both;
  const int n = 24;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double x = i / 32.0, y = j / 32.0;
      if ((i + j) % 2 == 0) {
        both.AddIfLegal({{x, y}}, {{x, y + 1 / 64.0}});
      } else {
        both.AddIfLegal({{x, y}}, {{x + 1 / 64.0, y}});
      }
    }
  }
  both.AddIfLegal({{1, 0}}, {{1, 1}});
  both.AddIfLegal({{0, 1}}, {{0.96875, 1}});
  both.AddIfLegal({{0, 0.875}}, {{0.96875, 0.875}});
  EXPECT_GT(both.size(), 1500u);
  Exercise(both, 6);
}

TEST(SpatialIndex, SplitsNoDeeperThanNeeded) {
  // Sixteen points at the least distances share a leaf; the seventeenth splits cells
  // down to them, one path of blocks.
  CellGrid<2> grid(Square(0, 1).box, kLimit);
  SpatialIndex<2> index(grid);
  for (int i = 0; i < 16; ++i) {
    index.Insert(PointFeature<2>{FeatureId(i + 1), {{0.7 + i * kLimit, 0.7}}});
  }
  EXPECT_EQ(index.node_count(), 4u);
  index.Insert(PointFeature<2>{17, {{0.7 + 16 * kLimit, 0.7}}});
  EXPECT_GT(index.node_count(), 4 * 30u);
  EXPECT_LT(index.node_count(), 4 * 50u);
}

}  // namespace
}  // namespace dynmesh::plc::spatial_index_test
