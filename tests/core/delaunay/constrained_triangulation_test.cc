// ConstrainedTriangulation: random changes of points and segments, against CGAL's constrained
// Delaunay triangulation and against triangulations made in another order.
#include "core/delaunay/constrained_triangulation.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/delaunay/delaunay_oracle.h"
#include "tests/core/geometry/random_points.h"
#include "tests/support/nightly.h"

namespace dynmesh::delaunay::constrained_triangulation_test {
namespace {

using namespace testing;
using geometry::testing::NewSeed;
using test::IsNightly;
using Segment = std::pair<Point2, Point2>;  // the lesser end first

ConstrainedTriangulation EmptyConstrainedBox() {
  ConstrainedTriangulation t;
  t.Reset(kLow, kHigh, {0, 1, 2, 3});
  return t;
}

bool IsOnSide(const Point2& p) {
  return p[0] == kLow[0] || p[0] == kHigh[0] || p[1] == kLow[1] || p[1] == kHigh[1];
}

// Is p in the inside of s? By exact orientation, then by order along the line.
bool IsInside(const Point2& p, const Segment& s) {
  return s.first < p && p < s.second && Orientation(s.first, s.second, p) == 0;
}

bool Cross(const Segment& s, const Segment& t) {
  return Orientation(s.first, s.second, t.first) * Orientation(s.first, s.second, t.second) < 0 &&
         Orientation(t.first, t.second, s.first) * Orientation(t.first, t.second, s.second) < 0;
}

// Points, segments and triangles as told by created() and deleted().
class RandomScene {
 public:
  RandomScene(std::uint64_t seed, std::vector<Point2> points)
      : random_(seed), spare_(std::move(points)) {
    VertexIndex v = 0;
    for (const Point2& p : Corners()) present_[p] = v++;
    next_ = v;
    for (SimplexIndex t = 0; t < mesh_.simplex_limit(); ++t) told_.insert(Around(t));
  }

  void Step() {
    switch (random_() % 5) {
      case 0:
      case 1:
        return spare_.empty() ? RemovePoint() : InsertPoint();
      case 2:
        return RemovePoint();
      case 3:
        return AddSegment();
      default:
        return random_() % 2 == 0 ? AddSegment() : RemoveSegment();
    }
  }

  void ExpectSound() {
    std::string why;
    ASSERT_TRUE(mesh_.Check(&why)) << why;
    ASSERT_EQ(mesh_.segment_count(), segments_.size());
    for (const Segment& s : segments_) {
      ASSERT_TRUE(mesh_.HasSegment(present_.at(s.first), present_.at(s.second)));
    }
    std::set<Indices> actual;
    for (SimplexIndex t = 0; t < mesh_.simplex_limit(); ++t) {
      if (mesh_.vertices(t)[0] != mesh_.vertices(t)[1]) actual.insert(Around(t));
    }
    ASSERT_EQ(actual, told_);
  }

  // The same points and segments in another order, segments between points.
  TriangleSet FromScratch() {
    ConstrainedTriangulation fresh = EmptyConstrainedBox();
    std::map<Point2, VertexIndex> index;
    VertexIndex v = 0;
    for (const Point2& p : Corners()) index[p] = v++;
    std::vector<Point2> points;
    for (const auto& [p, u] : present_) {
      if (!index.contains(p)) points.push_back(p);
    }
    std::vector<Segment> segments(segments_.begin(), segments_.end());
    std::shuffle(points.begin(), points.end(), random_);
    std::shuffle(segments.begin(), segments.end(), random_);
    // Points on sides of the box before segments that lie there.
    std::stable_partition(points.begin(), points.end(), IsOnSide);
    for (const Point2& p : points) {
      fresh.Insert(index[p] = v++, p, 0);
      if (IsOnSide(p)) continue;
      std::erase_if(segments, [&](const Segment& s) {
        return index.contains(s.first) && index.contains(s.second) && random_() % 2 == 0 &&
               fresh.AddSegment(index[s.first], index[s.second]);
      });
    }
    for (const Segment& s : segments) {
      EXPECT_TRUE(fresh.AddSegment(index[s.second], index[s.first]));
    }
    std::string why;
    EXPECT_TRUE(fresh.Check(&why)) << why;
    return TrianglesOf(fresh);
  }

  TriangleSet ByCgal() const {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    CGAL::Constrained_Delaunay_triangulation_2<Kernel> cdt;
    const auto to_cgal = [](const Point2& p) { return Kernel::Point_2(p[0], p[1]); };
    for (const auto& [p, v] : present_) cdt.insert(to_cgal(p));
    for (const Segment& s : segments_) cdt.insert_constraint(to_cgal(s.first), to_cgal(s.second));
    TriangleSet result;
    for (auto f = cdt.finite_faces_begin(); f != cdt.finite_faces_end(); ++f) {
      PlacedTriangle t;
      for (int i = 0; i < 3; ++i) {
        t[static_cast<std::size_t>(i)] = {{f->vertex(i)->point().x(), f->vertex(i)->point().y()}};
      }
      result.insert(Canonical(t));
    }
    return result;
  }

  const ConstrainedTriangulation& mesh() const { return mesh_; }
  std::size_t segment_count() const { return segments_.size(); }

 private:
  using Indices = std::array<VertexIndex, 3>;
  static Indices Least(Indices v) {
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    return v;
  }
  Indices Around(SimplexIndex t) const { return Least(mesh_.vertices(t)); }
  const Point2& AnyPoint() {
    return std::next(present_.begin(), static_cast<long>(random_() % present_.size()))->first;
  }

  void InsertPoint() {
    std::swap(spare_[random_() % spare_.size()], spare_.back());
    const Point2 p = spare_.back();
    spare_.pop_back();
    if (present_.contains(p) ||
        std::ranges::any_of(segments_, [&](const Segment& s) { return IsInside(p, s); })) {
      return;
    }
    mesh_.Insert(next_, p, present_.at(AnyPoint()));
    present_[p] = next_++;
    Hear();
  }

  void RemovePoint() {
    const Point2 p = AnyPoint();
    if (IsOnSide(p) || std::ranges::any_of(segments_, [&](const Segment& s) {
          return s.first == p || s.second == p;
        })) {
      return;
    }
    mesh_.Remove(present_.at(p));
    present_.erase(p);
    spare_.push_back(p);
    Hear();
  }

  void AddSegment() {
    const Point2 p = AnyPoint(), q = AnyPoint();
    if (p == q) return;
    const Segment s = std::minmax(p, q);
    const bool is_free =
        !segments_.contains(s) &&
        std::ranges::none_of(present_, [&](const auto& at) { return IsInside(at.first, s); }) &&
        std::ranges::none_of(segments_, [&](const Segment& t) { return Cross(s, t); });
    ASSERT_EQ(mesh_.AddSegment(present_.at(p), present_.at(q)), is_free);
    if (is_free) segments_.insert(s);
    Hear();
  }

  void RemoveSegment() {
    if (segments_.empty()) return;
    const auto s = std::next(segments_.begin(), static_cast<long>(random_() % segments_.size()));
    mesh_.RemoveSegment(present_.at(s->second), present_.at(s->first));
    segments_.erase(s);
    Hear();
  }

  void Hear() {
    ASSERT_EQ(mesh_.deleted().size(), mesh_.deleted_tags().size());
    for (const Indices& v : mesh_.deleted()) ASSERT_EQ(told_.erase(Least(v)), 1u);
    for (const SimplexIndex t : mesh_.created()) {
      ASSERT_EQ(mesh_.tag(t), 0u);
      ASSERT_TRUE(told_.insert(Around(t)).second);
    }
  }

  std::mt19937_64 random_;
  ConstrainedTriangulation mesh_ = EmptyConstrainedBox();
  std::vector<Point2> spare_;
  std::map<Point2, VertexIndex> present_;
  std::set<Segment> segments_;
  std::set<Indices> told_;
  VertexIndex next_ = 0;
};

TEST(ConstrainedTriangulation, IsAFunctionOfPointsAndSegmentsOnEveryLayout) {
  const std::uint64_t seed = NewSeed();
  for (const Layout layout : kAllLayouts) {
    for (std::size_t run = 0; run < (IsNightly() ? 200u : 10u); ++run) {
      SCOPED_TRACE(std::string(LayoutName(layout)) + ", run " + std::to_string(run) + ", seed " +
                   std::to_string(seed));
      RandomScene scene(seed + run, DistinctPoints(layout, seed + run, 40));
      for (int step = 0; step < 300; ++step) {
        scene.Step();
        if (HasFatalFailure()) return;
        if (step % 10 == 9) scene.ExpectSound();
        if (HasFatalFailure()) return;
      }
      ASSERT_EQ(TrianglesOf(scene.mesh()), scene.FromScratch());
    }
  }
}

// Ten thousand scenes by night. Ties, too: CGAL decides them by the lexicographic order.
TEST(ConstrainedTriangulation, AgreesWithCgalOnEveryLayout) {
  const std::uint64_t seed = NewSeed();
  for (const Layout layout : kAllLayouts) {
    std::size_t segments = 0;
    for (std::size_t run = 0; run < (IsNightly() ? 1500u : 30u); ++run) {
      SCOPED_TRACE(std::string(LayoutName(layout)) + ", run " + std::to_string(run) + ", seed " +
                   std::to_string(seed));
      const int size = static_cast<int>(10 + 8 * run % 200);
      RandomScene scene(seed + run, DistinctPoints(layout, seed + run, size));
      for (int step = 0; step < 400; ++step) scene.Step();
      if (HasFatalFailure()) return;
      ASSERT_EQ(TrianglesOf(scene.mesh()), scene.ByCgal());
      segments += scene.segment_count();
    }
    EXPECT_GT(segments, 100u);
  }
}

// A segment over many edges, with a fan on either side; it goes, and all is as before.
TEST(ConstrainedTriangulation, ASegmentCrossesThousandsOfEdges) {
  ConstrainedTriangulation mesh = EmptyConstrainedBox();
  constexpr VertexIndex kCount = 2000;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  VertexIndex v = 4;
  for (; v < 4 + kCount; ++v) {
    const double x = kLow[0] + (kHigh[0] - kLow[0]) * (0.1 + 0.8 * unit(random));
    const double y = kLow[1] + (kHigh[1] - kLow[1]) * (0.5 + 0.01 * (unit(random) - 0.5));
    mesh.Insert(v, {{x, y}}, v - 1);
  }
  const TriangleSet before = TrianglesOf(mesh);
  const double y = kLow[1] + (kHigh[1] - kLow[1]) * 0.5;
  mesh.Insert(v, {{kLow[0] + (kHigh[0] - kLow[0]) * 0.05, y}}, 0);
  mesh.Insert(v + 1, {{kLow[0] + (kHigh[0] - kLow[0]) * 0.95, y + 1e-7}}, 0);
  ASSERT_TRUE(mesh.AddSegment(v, v + 1));
  EXPECT_GT(mesh.deleted().size(), 100u);
  std::string why;
  ASSERT_TRUE(mesh.Check(&why)) << why;
  mesh.RemoveSegment(v + 1, v);
  mesh.Remove(v);
  mesh.Remove(v + 1);
  ASSERT_TRUE(mesh.Check(&why)) << why;
  EXPECT_EQ(TrianglesOf(mesh), before);
}

// Each is found from its other end: from the hub, this would take a minute.
TEST(ConstrainedTriangulation, AHubHasManySegments) {
  ConstrainedTriangulation mesh = EmptyConstrainedBox();
  constexpr VertexIndex kCount = 100'000, kHub = 4;
  const Point2 middle = {{(kLow[0] + kHigh[0]) / 2, (kLow[1] + kHigh[1]) / 2}};
  const double radius = (kHigh[0] - kLow[0]) / 4;
  mesh.Insert(kHub, middle, 0);
  for (VertexIndex i = 0; i < kCount; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCount;
    mesh.Insert(kHub + 1 + i,
                {{middle[0] + radius * std::cos(angle), middle[1] + radius * std::sin(angle)}},
                kHub + i);
  }
  for (VertexIndex i = 1; i <= kCount; ++i) ASSERT_TRUE(mesh.AddSegment(kHub, kHub + i));
  std::string why;
  ASSERT_TRUE(mesh.Check(&why)) << why;
  for (VertexIndex i = 1; i <= kCount; ++i) mesh.RemoveSegment(kHub, kHub + i);
  EXPECT_EQ(mesh.segment_count(), 0u);
  ASSERT_TRUE(mesh.Check(&why)) << why;
}

TEST(ConstrainedTriangulation, AVertexOfLargeDegreeGoesBesideASegment) {
  ConstrainedTriangulation mesh = EmptyConstrainedBox();
  constexpr VertexIndex kCount = 3000;
  const Point2 middle = {{(kLow[0] + kHigh[0]) / 2, (kLow[1] + kHigh[1]) / 2}};
  const double radius = (kHigh[0] - kLow[0]) / 4;
  for (VertexIndex i = 0; i < kCount; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCount;
    mesh.Insert(4 + i,
                {{middle[0] + radius * std::cos(angle), middle[1] + radius * std::sin(angle)}},
                3 + i);
  }
  ASSERT_TRUE(mesh.AddSegment(4, 4 + kCount / 3));
  const TriangleSet before = TrianglesOf(mesh);
  mesh.Insert(4 + kCount, {{middle[0] - radius / 16, middle[1] - radius / 32}}, 0);
  EXPECT_GT(mesh.created().size(), kCount / 2);
  mesh.Remove(4 + kCount);
  std::string why;
  ASSERT_TRUE(mesh.Check(&why)) << why;
  EXPECT_EQ(TrianglesOf(mesh), before);
}

}  // namespace
}  // namespace dynmesh::delaunay::constrained_triangulation_test
