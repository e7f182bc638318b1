// Random scripts of insertions and removals: after each operation the triangulation must equal the
// one defined by its points, and created() and deleted() must report the changes.
#include <gtest/gtest.h>

#include <map>

#include "tests/core/delaunay/delaunay_oracle.h"
#include "tests/core/geometry/random_points.h"

namespace dynmesh::delaunay {
namespace {

using namespace testing;
using geometry::testing::NewSeed;

// Triangles by vertex indices, the least first; infinite ones included.
using IndexTriangle = std::array<VertexIndex, 3>;
IndexTriangle Rotated(IndexTriangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

// A triangulation, the list of its points, and its triangles according to the reports.
class Script {
 public:
  explicit Script(std::uint64_t seed) : random_(seed), dt_(EmptyBox()) {
    for (SimplexIndex t = 0; t < dt_.simplex_limit(); ++t) told_.insert(Rotated(dt_.vertices(t)));
    for (const Point2& p : Corners()) present_[p] = static_cast<VertexIndex>(present_.size());
  }

  void Insert(const Point2& p) {
    if (present_.contains(p)) return;
    // Old indices come again, as those of a real caller do.
    VertexIndex v = next_;
    if (unused_.empty() || random_() % 2 == 0) {
      ++next_;
    } else {
      v = unused_.back();
      unused_.pop_back();
    }
    const auto near = std::next(present_.begin(), static_cast<long>(random_() % present_.size()));
    dt_.Insert(v, p, near->second);
    present_[p] = v;
    Hear();
    ASSERT_TRUE(dt_.Contains(v));
    ASSERT_EQ(dt_.position(v), p);
  }

  void RemoveAny() {
    if (present_.size() == 4) return;
    auto victim = std::next(present_.begin(), static_cast<long>(random_() % present_.size()));
    while (victim->second < 4) {
      if (++victim == present_.end()) victim = present_.begin();
    }
    const VertexIndex v = victim->second;
    dt_.Remove(v);
    present_.erase(victim);
    unused_.push_back(v);
    Hear();
    ASSERT_FALSE(dt_.Contains(v));
  }

  void Step(const Point2& p, double remove_probability) {
    if (std::uniform_real_distribution<double>(0, 1)(random_) < remove_probability) {
      RemoveAny();
    } else {
      Insert(p);
    }
  }

  void ExpectSound() const {
    std::string why;
    ASSERT_TRUE(dt_.Check(&why)) << why;
    ASSERT_EQ(dt_.vertex_count(), present_.size());
    std::set<IndexTriangle> actual;
    std::size_t finite = 0;
    for (SimplexIndex t = 0; t < dt_.simplex_limit(); ++t) {
      const IndexTriangle v = dt_.vertices(t);
      if (v[0] != v[1]) actual.insert(Rotated(v));  // else unused
      finite += !dt_.IsInfinite(t);
    }
    ASSERT_EQ(finite, dt_.simplex_count());
    ASSERT_EQ(actual, told_);
  }

  const DelaunayTriangulation& dt() const { return dt_; }
  std::vector<Point2> points() const {
    std::vector<Point2> result;
    for (const auto& [p, v] : present_) result.push_back(p);
    return result;
  }

 private:
  // Applies the reports to told_.
  void Hear() {
    for (const IndexTriangle& t : dt_.deleted()) ASSERT_EQ(told_.erase(Rotated(t)), 1u);
    for (const SimplexIndex t : dt_.created()) {
      ASSERT_EQ(dt_.tag(t), 0u);
      ASSERT_TRUE(told_.insert(Rotated(dt_.vertices(t))).second);
    }
  }

  std::mt19937_64 random_;
  DelaunayTriangulation dt_;
  std::map<Point2, VertexIndex> present_;
  VertexIndex next_ = 4;
  std::vector<VertexIndex> unused_;
  std::set<IndexTriangle> told_;
};

class DelaunayScript : public ::testing::TestWithParam<Layout> {};

TEST_P(DelaunayScript, SmallSetsAreDelaunayByDefinitionAfterEveryOperation) {
  const std::uint64_t seed = NewSeed();
  for (std::uint64_t round = 0; round < 20; ++round) {
    SCOPED_TRACE("seed " + std::to_string(seed) + " round " + std::to_string(round));
    Script script(seed + round);
    LayoutSource source(GetParam(), seed + round, 12);
    for (int step = 0; step < 60; ++step) {
      // Grow to a dozen, then down to none.
      ASSERT_NO_FATAL_FAILURE(script.Step(source.Next(), step < 30 ? 0.3 : 0.75));
      ASSERT_NO_FATAL_FAILURE(script.ExpectSound());
      ASSERT_EQ(TrianglesOf(script.dt()), BruteForceDelaunay(script.points())) << "step " << step;
    }
  }
}

TEST_P(DelaunayScript, MediumSetsAgreeWithCgalAfterEveryOperation) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Script script(seed);
  LayoutSource source(GetParam(), seed, 100);
  for (int step = 0; step < 1000; ++step) {
    ASSERT_NO_FATAL_FAILURE(script.Step(source.Next(), step % 400 < 250 ? 0.2 : 0.7));
    ASSERT_NO_FATAL_FAILURE(script.ExpectSound());
    ASSERT_EQ(TrianglesOf(script.dt()), CgalDelaunay(script.points())) << "step " << step;
  }
}

TEST_P(DelaunayScript, LargeSetsDoNotRememberTheirHistory) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Script script(seed);
  LayoutSource source(GetParam(), seed, 3000);
  for (int step = 1; step <= 6000; ++step) {
    ASSERT_NO_FATAL_FAILURE(script.Step(source.Next(), step < 3500 ? 0.2 : 0.7));
    if (step % 500 != 0) continue;
    ASSERT_NO_FATAL_FAILURE(script.ExpectSound());
    const TriangleSet triangles = TrianglesOf(script.dt());
    ASSERT_EQ(triangles, CgalDelaunay(script.points())) << "step " << step;
    // From scratch, in lexicographic order.
    DelaunayTriangulation fresh = EmptyBox();
    const std::vector<Point2> corners = Corners();
    VertexIndex v = 4;
    for (const Point2& p : script.points()) {
      if (std::find(corners.begin(), corners.end(), p) == corners.end()) fresh.Insert(v++, p, 0);
    }
    ASSERT_EQ(triangles, TrianglesOf(fresh)) << "step " << step;
  }
}

std::string NameOf(const ::testing::TestParamInfo<Layout>& layout) {
  return LayoutName(layout.param);
}
INSTANTIATE_TEST_SUITE_P(Layouts, DelaunayScript, ::testing::ValuesIn(kAllLayouts), NameOf);

}  // namespace
}  // namespace dynmesh::delaunay
