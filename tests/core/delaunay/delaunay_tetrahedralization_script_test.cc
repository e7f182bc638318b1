// Random scripts of insertions and removals: after each operation the tetrahedralisation must equal
// the one defined by its points, and created() and deleted() must report the changes.
#include <gtest/gtest.h>

#include <map>

#include "tests/core/delaunay/tetrahedra_oracle.h"
#include "tests/core/geometry/random_points.h"

namespace dynmesh::delaunay {
namespace {

using namespace testing;
using geometry::testing::NewSeed;

// Tetrahedra by vertex indices, ascending; infinite ones included.
using IndexTetrahedron = std::array<VertexIndex, 4>;
IndexTetrahedron Sorted(IndexTetrahedron t) {
  std::sort(t.begin(), t.end());
  return t;
}

// A tetrahedralisation, the list of its points, and its tetrahedra according to the reports.
class Script {
 public:
  explicit Script(std::uint64_t seed) : random_(seed), dt_(EmptyBox()) {
    for (SimplexIndex t = 0; t < dt_.simplex_limit(); ++t) {
      if (!dt_.IsUnused(t)) told_.insert(Sorted(dt_.vertices(t)));
    }
    for (const Point3& p : Corners()) present_[p] = static_cast<VertexIndex>(present_.size());
  }

  void Insert(const Point3& p) {
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
    for (const SimplexIndex t : dt_.created()) ASSERT_EQ(dt_.vertices(t)[3], v);
  }

  void RemoveAny() {
    if (present_.size() == 8) return;
    auto victim = std::next(present_.begin(), static_cast<long>(random_() % present_.size()));
    while (victim->second < 8) {
      if (++victim == present_.end()) victim = present_.begin();
    }
    const VertexIndex v = victim->second;
    dt_.Remove(v);
    present_.erase(victim);
    unused_.push_back(v);
    Hear();
    ASSERT_FALSE(dt_.Contains(v));
  }

  void Step(const Point3& p, double remove_probability) {
    if (std::uniform_real_distribution<double>(0, 1)(random_) < remove_probability) {
      RemoveAny();
    } else {
      Insert(p);
    }
  }

  void ExpectSound() const {
    ASSERT_NO_FATAL_FAILURE(testing::ExpectSound(dt_));
    ASSERT_EQ(dt_.vertex_count(), present_.size());
    std::set<IndexTetrahedron> actual;
    std::size_t finite = 0;
    for (SimplexIndex t = 0; t < dt_.simplex_limit(); ++t) {
      if (!dt_.IsUnused(t)) actual.insert(Sorted(dt_.vertices(t)));
      finite += !dt_.IsInfinite(t);
    }
    ASSERT_EQ(finite, dt_.simplex_count());
    ASSERT_EQ(actual, told_);
  }

  // The same points from scratch, in another order.
  void ExpectEqualsScratch() {
    auto points = this->points();
    std::shuffle(points.begin(), points.end(), random_);
    DelaunayTetrahedralization fresh = EmptyBox();
    const std::vector<Point3> corners = Corners();
    VertexIndex v = 8;
    for (const Point3& p : points) {
      if (std::find(corners.begin(), corners.end(), p) == corners.end()) fresh.Insert(v++, p, 0);
    }
    ASSERT_EQ(TetrahedraOf(dt_), TetrahedraOf(fresh));
  }

  const DelaunayTetrahedralization& dt() const { return dt_; }
  std::vector<Point3> points() const {
    std::vector<Point3> result;
    for (const auto& [p, v] : present_) result.push_back(p);
    return result;
  }

 private:
  // Applies the reports to told_.
  void Hear() {
    ASSERT_EQ(dt_.deleted().size(), dt_.deleted_tags().size());
    for (const IndexTetrahedron& t : dt_.deleted()) ASSERT_EQ(told_.erase(Sorted(t)), 1u);
    for (const SimplexIndex t : dt_.created()) {
      ASSERT_EQ(dt_.tag(t), 0u);
      ASSERT_TRUE(told_.insert(Sorted(dt_.vertices(t))).second);
    }
  }

  std::mt19937_64 random_;
  DelaunayTetrahedralization dt_;
  std::map<Point3, VertexIndex> present_;
  VertexIndex next_ = 8;
  std::vector<VertexIndex> unused_;
  std::set<IndexTetrahedron> told_;
};

class TetrahedralizationScript : public ::testing::TestWithParam<Layout> {};

TEST_P(TetrahedralizationScript, SmallSetsAreDelaunayByDefinitionAfterEveryOperation) {
  const std::uint64_t seed = NewSeed();
  for (std::uint64_t round = 0; round < 20; ++round) {
    SCOPED_TRACE("seed " + std::to_string(seed) + " round " + std::to_string(round));
    Script script(seed + round);
    LayoutSource source(GetParam(), seed + round);
    for (int step = 0; step < 30; ++step) {
      // The box and up to eight or so more, then down again.
      ASSERT_NO_FATAL_FAILURE(script.Step(source.Next(), step < 14 ? 0.25 : 0.7));
      ASSERT_NO_FATAL_FAILURE(script.ExpectSound());
      ASSERT_EQ(TetrahedraOf(script.dt()), BruteForceDelaunay(script.points())) << "step " << step;
    }
  }
}

TEST_P(TetrahedralizationScript, MediumSetsEqualThoseFromScratchAfterEveryOperation) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (std::uint64_t round = 0; round < 3; ++round) {
    Script script(seed + round);
    LayoutSource source(GetParam(), seed + round);
    for (int step = 0; step < 240; ++step) {
      ASSERT_NO_FATAL_FAILURE(script.Step(source.Next(), step % 120 < 70 ? 0.1 : 0.8));
      ASSERT_NO_FATAL_FAILURE(script.ExpectSound());
      ASSERT_NO_FATAL_FAILURE(script.ExpectEqualsScratch()) << "step " << step;
    }
  }
}

TEST_P(TetrahedralizationScript, LargeSetsDoNotRememberTheirHistory) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Script script(seed);
  LayoutSource source(GetParam(), seed);
  for (int step = 1; step <= 1200; ++step) {
    ASSERT_NO_FATAL_FAILURE(script.Step(source.Next(), step < 700 ? 0.2 : 0.7));
    if (step % 200 != 0) continue;
    ASSERT_NO_FATAL_FAILURE(script.ExpectSound());
    ASSERT_NO_FATAL_FAILURE(script.ExpectEqualsScratch()) << "step " << step;
  }
}

std::string NameOf(const ::testing::TestParamInfo<Layout>& layout) {
  return LayoutName(layout.param);
}
INSTANTIATE_TEST_SUITE_P(Layouts, TetrahedralizationScript, ::testing::ValuesIn(kAllLayouts),
                         NameOf);

}  // namespace
}  // namespace dynmesh::delaunay
