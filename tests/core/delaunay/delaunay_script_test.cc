// Random scripts of insertions and removals: after each operation the triangulation must equal the
// one defined by its points, and created() and deleted() must report the changes.
#include <gtest/gtest.h>

#include <string>

#include "tests/core/delaunay/delaunay_oracle.h"
#include "tests/core/delaunay/random_edits.h"
#include "tests/core/geometry/random_points.h"

namespace dynmesh::delaunay::delaunay_script_test {
namespace {

using namespace testing;
using geometry::testing::NewSeed;

struct Script : RandomEdits<DelaunayTriangulation, 2> {
  explicit Script(std::uint64_t seed) : RandomEdits(seed, EmptyBox(), Corners()) {}
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
    ASSERT_EQ(triangles, TrianglesOf(script.FromScratch(EmptyBox()))) << "step " << step;
  }
}

std::string NameOf(const ::testing::TestParamInfo<Layout>& layout) {
  return LayoutName(layout.param);
}
INSTANTIATE_TEST_SUITE_P(Layouts, DelaunayScript, ::testing::ValuesIn(kAllLayouts), NameOf);

}  // namespace
}  // namespace dynmesh::delaunay::delaunay_script_test
