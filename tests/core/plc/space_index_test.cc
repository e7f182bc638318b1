// The 3D index against examining everything, and the cost of a check there.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/geometry/constructions.h"
#include "core/plc/facet_rules.h"
#include "core/plc/plc.h"
#include "core/plc/spatial_index.h"
#include "tests/core/plc/plc_test_util.h"

namespace dynmesh::plc::space_index_test {
namespace {

using geometry::Point3;

// Arbitrary features anywhere: the 3D index accepts crossings.
class Things {
 public:
  explicit Things(std::uint64_t seed)
      : random_(seed), limit_(CloseLimit(Cube(0, 1))), index_({Cube(0, 1).box, limit_}) {}

  Point3 Place() {
    Point3 p;
    for (double& x : p.c) x = std::uniform_real_distribution<double>(0, 1)(random_);
    return p;
  }
  Point3 Near(const Point3& p, double size) {
    Point3 q;
    for (int i = 0; i < 3; ++i) {
      q[i] =
          std::clamp(p[i] + std::uniform_real_distribution<double>(-size, size)(random_), 0., 1.);
    }
    return q;
  }
  double Size() { return std::ldexp(1, -static_cast<int>(random_() % 40)); }
  // On something there, or as far from it as `Size` says.
  Point3 PlaceByThings() {
    if (facets_.empty() || random_() % 4 == 0) return Place();
    const auto& corners = facets_[random_() % facets_.size()].first.feature().positions[0];
    const double u = std::uniform_real_distribution<double>(0, 1)(random_), v = (1 - u) / 2;
    Point3 p;
    for (int i = 0; i < 3; ++i) {
      p[i] = u * corners[0][i] + v * corners[1][i] + (1 - u - v) * corners[2][i];
    }
    return random_() % 2 == 0 ? p : Near(p, Size());
  }

  PointFeature<3> NewPoint() { return {next_++, PlaceByThings()}; }
  SegmentFeature<3> NewSegment() {
    const Point3 p = PlaceByThings();
    return {next_++, next_, next_ + 1, p, Near(p, Size())};
  }
  Facet NewFacet() {
    const Point3 p = PlaceByThings();
    const double size = Size();
    const FeatureId id = next_;
    next_ += 4;
    return Facet({id, {{id + 1, id + 2, id + 3}}, {{p, Near(p, size), Near(p, size)}}});
  }
  void Add(const PointFeature<3>& f) { points_.emplace_back(f, index_.Insert(f)); }
  void Add(const SegmentFeature<3>& f) { segments_.emplace_back(f, index_.Insert(f)); }
  void Add(const Facet& f) { facets_.emplace_back(f, index_.Insert(f)); }
  void Thin(int one_in) {
    const auto out = [&] { return random_() % one_in != 0; };
    std::erase_if(points_, [&](const auto& f) {
      const bool gone = out();
      if (gone) index_.ErasePoint(f.second);
      return gone;
    });
    std::erase_if(segments_, [&](const auto& f) {
      const bool gone = out();
      if (gone) index_.EraseSegment(f.second);
      return gone;
    });
    std::erase_if(facets_, [&](const auto& f) {
      const bool gone = out();
      if (gone) index_.EraseFacet(f.second);
      return gone;
    });
  }

  // Checks that the answer has all features that conflict with f. Returns their number.
  template <class F, class Where>
  std::size_t Ask(const F& f, const Where& where) {
    std::set<FeatureId> wanted, got;
    for (const auto& [g, slot] : points_) Judge(f, g, g.id, wanted);
    for (const auto& [g, slot] : segments_) Judge(f, g, g.id, wanted);
    for (const auto& [g, slot] : facets_) Judge(f, g, g.id(), wanted);
    std::uint64_t cost = 0;
    index_.QueryNear(
        where, [&](const PointFeature<3>& g) { got.insert(g.id); },
        [&](const SegmentFeature<3>& g) { got.insert(g.id); },
        [&](const Facet& g) { got.insert(g.id()); }, &cost);
    EXPECT_TRUE(std::includes(got.begin(), got.end(), wanted.begin(), wanted.end()));
    return wanted.size();
  }
  const SpatialIndex<3>& index() const { return index_; }

 private:
  template <class F, class G>
  void Judge(const F& f, const G& g, FeatureId id, std::set<FeatureId>& wanted) const {
    const auto between = [&] {
      if constexpr (requires { Between(f, g, limit_); }) {
        return Between(f, g, limit_);
      } else {
        return Between(g, f, limit_);
      }
    };
    if (between() != Conflict::kNone) wanted.insert(id);
  }

  std::mt19937_64 random_;
  double limit_;
  SpatialIndex<3> index_;
  FeatureId next_ = 1;
  std::vector<std::pair<PointFeature<3>, Slot>> points_;
  std::vector<std::pair<SegmentFeature<3>, Slot>> segments_;
  std::vector<std::pair<Facet, Slot>> facets_;
};

TEST(SpaceIndex, AnswersHaveEveryConflict) {
  const std::uint64_t seed = 81;
  SCOPED_TRACE(seed);
  Things things(seed);
  const std::size_t empty = things.index().node_count();
  std::size_t conflicts = 0;
  for (int round = 0; round < 4; ++round) {
    for (int i = 0; i < 150; ++i) {
      things.Add(things.NewPoint());
      things.Add(things.NewSegment());
      things.Add(things.NewFacet());
    }
    for (int i = 0; i < 400; ++i) {
      const PointFeature<3> p = things.NewPoint();
      conflicts += things.Ask(p, p.p);
      const SegmentFeature<3> s = things.NewSegment();
      conflicts += things.Ask(s, s);
      const Facet f = things.NewFacet();
      conflicts += things.Ask(f, f);
      if (testing::Test::HasFailure()) return;
    }
    things.Thin(2);
  }
  EXPECT_GT(conflicts, 1000u);
  things.Thin(1 << 30);
  EXPECT_EQ(things.index().node_count(), empty);
}

// n^3 small boxes apart from each other, in a cube.
EditBatch Boxes(int n, double lo, double hi, FeatureId first) {
  EditBatch batch;
  const double step = (hi - lo) / n;
  FeatureId polygon = first + 8 * FeatureId(n) * n * n;
  for (int i = 0; i < n * n * n; ++i) {
    std::array<double, 3> a, b;
    for (int k = 0, rest = i; k < 3; ++k, rest /= n) {
      a[k] = lo + (rest % n + 0.25) * step, b[k] = lo + (rest % n + 0.75) * step;
    }
    batch = std::move(batch) + BoxOf(first, polygon, a, b);
    first += 8, polygon += 6;
  }
  return batch;
}

// A facet in a box. A box dented at a corner of four faces would not be flat, so a whole face
// moves.
std::uint64_t CostOfEdits(const Plc3& plc, int n, double hi) {
  std::uint64_t cost = 0;
  const double step = hi / n;
  int edits = 0;
  for (int i = 0; i < n * n * n; i += 5, ++edits) {
    const FeatureId first = 1 + 8 * FeatureId(i);
    const double z = (i / (n * n) + 0.8) * step;
    EditBatch batch;
    for (FeatureId c = first + 4; c < first + 8; ++c) {
      const auto at = plc.store().FindPoint(c)->p;
      batch.push_back(Edit::Move(c, at[0], at[1], z));
    }
    const auto delta = plc.Check(batch, &cost);
    EXPECT_TRUE(delta.ok()) << delta.status();
  }
  return cost / edits;
}

TEST(SpaceCost, OfALocalEditDoesNotGrowWithFeaturesElsewhere) {
  std::vector<std::uint64_t> costs;
  for (const int elsewhere : {0, 4, 9}) {
    Plc3 plc(Cube(0, 1));
    Apply(plc, Boxes(4, 0, 0.25, 1));
    if (elsewhere > 0) Apply(plc, Boxes(elsewhere, 0.5, 1, 1'000'000));
    costs.push_back(CostOfEdits(plc, 4, 0.25));
    std::cout << plc.size() << " features: " << costs.back() << " per edit\n";
  }
  EXPECT_LT(costs[1], 1.1 * costs[0]);
  EXPECT_LT(costs[2], 1.1 * costs[0]);
}

TEST(SpaceCost, OfALocalEditGrowsWithTheDepthOnly) {
  std::vector<std::uint64_t> costs;
  for (const int n : {3, 10}) {
    Plc3 plc(Cube(0, 1));
    Apply(plc, Boxes(n, 0, 1, 1));
    costs.push_back(CostOfEdits(plc, n, 1));
    std::cout << plc.size() << " features: " << costs.back() << " per edit\n";
  }
  EXPECT_LT(costs[1], 2 * costs[0]);
}

// Plates side by side, of equal size: a feature between two of them visits these, if plates are no
// nearer to each other than a 64th of their size.
TEST(SpaceCost, LargePlatesAreTheirNumberNearby) {
  for (const int n : {10, 30}) {
    Plc3 plc(Cube(0, 1));
    EditBatch batch;
    for (int i = 0; i < n; ++i) {
      const double z = (i + 0.5) / n;
      const FeatureId first = 1 + 5 * FeatureId(i);
      batch = std::move(batch) +
              EditBatch{AddPoint3(first, 0, 0, z), AddPoint3(first + 1, 1, 0, z),
                        AddPoint3(first + 2, 1, 1, z), AddPoint3(first + 3, 0, 1, z),
                        AddPolygon(first + 4, {{first, first + 1, first + 2, first + 3}})};
    }
    Apply(plc, batch);
    std::uint64_t cost = 0;
    for (int i = 0; i + 1 < n; ++i) {
      const double z = (i + 1.0) / n;
      EXPECT_TRUE(plc.Check({AddPoint3(10000, 0.3, 0.4, z)}, &cost).ok());
    }
    cost /= n - 1;
    std::cout << n << " plates: " << cost << " per point, " << plc.index().node_count()
              << " nodes\n";
    EXPECT_LT(cost, 60u);
    EXPECT_LT(plc.index().node_count(), 10'000u);
  }
}

// A fan: needles from one corner to a fine rim, aslant, so that each one's box holds much of the
// fan. Cells at the rim hold needles near them only, and a needle that comes does not look at all
// that are in its cells already.
TEST(SpaceCost, OfAFanOfNeedlesIsThatOfWhatIsNear) {
  std::vector<double> looked_at, visited;
  double seen_by_one = 0;  // segments that a needle visits, of the last fan
  for (const int n : {250, 1000}) {
    const CellGrid<3> grid(Cube(0, 1).box, CloseLimit(Cube(0, 1)));
    SpatialIndex<3> index(grid);
    const Point3 apex{{0.1, 0.11, 0.12}};
    const auto rim = [&](int i) {
      const double t = 0.3 * i / n;
      return Point3{{0.9 - 0.9 * t, 0.5 + t, 0.4 + 0.7 * t}};
    };
    for (int i = 0; i <= n; ++i) index.Insert(PointFeature<3>{FeatureId(i) + 2, rim(i)});
    index.Insert(PointFeature<3>{1, apex});
    for (int i = 0; i <= n; ++i) {
      index.Insert(SegmentFeature<3>{FeatureId(i) + 10'000, 1, FeatureId(i) + 2, apex, rim(i)});
    }
    std::vector<Facet> needles;
    for (int i = 0; i < n; ++i) {
      const FeatureId first = FeatureId(i) + 2;
      needles.emplace_back(FacetFeature{
          FeatureId(i) + 20'000, {{1, first, first + 1}}, {{apex, rim(i), rim(i + 1)}}});
      index.Insert(needles.back());
    }
    looked_at.push_back(static_cast<double>(index.looked_at()) / n);
    // Beside the middle of each rim edge.
    std::uint64_t cost = 0;
    for (int i = 0; i < n; ++i) {
      const auto ignore = [](const auto&) {};
      const Point3 a = rim(i), b = rim(i + 1);
      index.QueryNear(geometry::Midpoint(a, b), ignore, ignore, ignore, &cost);
    }
    visited.push_back(static_cast<double>(cost) / n);
    std::uint64_t seen = 0;
    for (const Facet& needle : needles) {
      const auto ignore = [](const auto&) {};
      index.QueryNear(
          needle, ignore, [&](const SegmentFeature<3>&) { ++seen; }, ignore, &cost);
    }
    seen_by_one = static_cast<double>(seen) / n;
    std::cout << n << " needles: " << looked_at.back() << " looked at per needle, "
              << visited.back() << " visited per point; a needle visits " << seen_by_one
              << " segments\n";
  }
  EXPECT_LT(seen_by_one, 1200);  // all meet at the apex
  EXPECT_LT(looked_at[1], 2 * looked_at[0]);
  EXPECT_LT(visited[1], 1.5 * visited[0]);
}

}  // namespace
}  // namespace dynmesh::plc::space_index_test
