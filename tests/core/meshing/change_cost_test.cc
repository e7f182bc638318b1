// How many operations a change of each kind executes, and how many of them make nothing new. The
// filters of notifications must not miss a change (reproduction_test.cc); here, that they do not
// report far too many. Counts, so the same on every machine. The bounds are 1.5 times what was
// measured, rounded up; the figures measured are beside them. They hardly grow with n.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "core/meshing/refinement.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing::change_cost_test {
namespace {

constexpr std::uint64_t kSeed = 20261129;
constexpr int kEdits = 24;

enum class Change { kVertex, kSegment, kSize, kFacet };
constexpr const char* kNames[] = {"vertex", "segment", "size", "facet"};

// Per edit, additions and removals alike.
struct Cost {
  double executed = 0, unchanged = 0;
};

template <int D>
class Cloud {
 public:
  using Point = geometry::Point<D>;

  explicit Cloud(int n) : n_(n), random_(kSeed), refinement_(Options(), nullptr) {
    for (int i = 0; i < n; ++i) points_.push_back(refinement_.AddPoint(AnyPlace(), 1));
    // With the first segment features begin to be kept by position.
    const SubsegmentIndex s = refinement_.AddSegment(points_[0], OtherEnd(points_[0]), 1);
    Run();
    refinement_.RemoveSegment(s);
    Run();
  }

  Cost CostOf(Change change) {
    sac::Counters sum;
    const auto run = [&] {
      refinement_.engine().ResetCounters();
      Run();
      const sac::Counters& counters = refinement_.engine().counters();
      sum.executed += counters.executed;
      sum.unchanged += counters.unchanged;
    };
    for (int i = 0; i < kEdits; ++i) {
      switch (change) {
        case Change::kVertex: {
          const VertexIndex v = refinement_.AddPoint(AnyPlace(), 1);
          run();
          refinement_.RemovePoint(v);
          break;
        }
        case Change::kSegment: {
          const VertexIndex v = points_[static_cast<std::size_t>(1 + i)];
          const SubsegmentIndex s = refinement_.AddSegment(v, OtherEnd(v), 1);
          run();
          refinement_.RemoveSegment(s);
          break;
        }
        case Change::kSize: {
          SizingRegion<D> region;
          region.lo = region.hi = AnyPlace();
          region.target = Spacing();
          const auto index = refinement_.AddSizing(region);
          run();
          refinement_.RemoveSizing(index);
          break;
        }
        case Change::kFacet:
          ChangeFacet(run);
          break;
      }
      run();
    }
    const double edits = 2 * kEdits;
    return {static_cast<double>(sum.executed) / edits, static_cast<double>(sum.unchanged) / edits};
  }

 private:
  static MeshOptions Options() {
    MeshOptions options;
    options.dimension = D;
    options.quality = DefaultQuality(D);
    return options;
  }
  // Of the points, about.
  double Spacing() const { return D == 2 ? 1 / std::sqrt(n_) : 1 / std::cbrt(n_); }
  Point AnyPlace() {
    Point p;
    for (int k = 0; k < D; ++k) p[k] = random_.Unit();
    return p;
  }
  // The nearest of the points farther away than a few are.
  VertexIndex OtherEnd(VertexIndex v) const {
    const auto d2 = [&](VertexIndex u) {
      return geometry::SquaredDistance(refinement_.vertex(u).p, refinement_.vertex(v).p);
    };
    VertexIndex nearest = kNil;
    for (const VertexIndex u : points_) {
      if (d2(u) < 9 * Spacing() * Spacing()) continue;
      if (nearest == kNil || d2(u) < d2(nearest)) nearest = u;
    }
    return nearest;
  }
  void Run() {
    ASSERT_TRUE(refinement_.Propagate([] { return false; }));
    refinement_.TakeChanges([](auto...) {}, [](auto...) {});
  }
  // Adds a triangle, the border of which is there already, calls run, and removes it.
  template <class F>
  void ChangeFacet(F run) {
    if constexpr (D == 3) {
      const Point middle = AnyPlace();
      std::vector<VertexIndex> corners;
      for (int i = 0; i < 3; ++i) {
        Point p = middle;
        for (int k = 0; k < 3; ++k) p[k] += (k == i ? 1 : 0.1 * random_.Unit()) * Spacing();
        corners.push_back(refinement_.AddPoint(p, 1));
      }
      std::vector<SubsegmentIndex> border;
      for (std::size_t i = 0; i < 3; ++i) {
        border.push_back(refinement_.AddSegment(corners[i], corners[(i + 1) % 3], 1));
      }
      Run();
      const std::vector<std::vector<VertexIndex>> rings = {corners};
      const FacetIndex facet = refinement_.AddFacet(rings, 2);
      run();
      refinement_.RemoveFacet(facet);
    }
  }

  const int n_;
  test::Random random_;
  Refinement<D, sac::Engine> refinement_;
  std::vector<VertexIndex> points_;
};

template <int D>
void ExpectAtMost(int n, const std::vector<std::pair<Change, Cost>>& bounds) {
  Cloud<D> cloud(n);
  for (const auto& [change, bound] : bounds) {
    const Cost cost = cloud.CostOf(change);
    const std::string name = kNames[static_cast<int>(change)];
    std::cout << D << "D, n = " << n << ", " << name << ": " << cost.executed << " executed, "
              << cost.unchanged << " unchanged\n";
    EXPECT_LE(cost.executed, bound.executed) << name;
    EXPECT_LE(cost.unchanged, bound.unchanged) << name;
    EXPECT_GT(cost.executed, 0) << name;
  }
}

// Measured: executed and unchanged, at the lesser n and at the greater.
TEST(ChangeCost, InPlane) {
  const std::vector<std::pair<Change, Cost>> bounds = {
      {Change::kVertex, {24, 14}},    // 14.0, 7.9; 15.8, 9.0
      {Change::kSegment, {102, 30}},  // 67.7, 19.7; 52.2, 14.6
      {Change::kSize, {109, 55}},     // 64.9, 32.1; 72.3, 36.6
  };
  for (const int n : {500, 2000}) ExpectAtMost<2>(n, bounds);
}

TEST(ChangeCost, InSpace) {
  const std::vector<std::pair<Change, Cost>> bounds = {
      {Change::kVertex, {108, 88}},    // 71.6, 58.1; 57.5, 47.1
      {Change::kSegment, {194, 138}},  // 119.3, 83.4; 129.1, 91.4
      {Change::kSize, {889, 644}},     // 589.7, 418.0; 592.0, 428.9
      {Change::kFacet, {184, 161}},    // 122.6, 106.8; 106.0, 91.6
  };
  for (const int n : {500, 1000}) ExpectAtMost<3>(n, bounds);
}

}  // namespace
}  // namespace dynmesh::meshing::change_cost_test
