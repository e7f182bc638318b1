// Random scripts of insertions and removals: after each operation the tetrahedralisation must equal
// the one defined by its points, and created() and deleted() must report the changes.
#include <gtest/gtest.h>

#include <string>

#include "tests/core/delaunay/random_edits.h"
#include "tests/core/delaunay/tetrahedra_oracle.h"
#include "tests/core/geometry/random_points.h"

namespace dynmesh::delaunay::delaunay_tetrahedralization_script_test {
namespace {

using namespace testing;
using geometry::testing::NewSeed;

struct Script : RandomEdits<DelaunayTetrahedralization, 3> {
  explicit Script(std::uint64_t seed) : RandomEdits(seed, EmptyBox(), Corners()) {}

  void ExpectEqualsScratch() {
    ASSERT_EQ(TetrahedraOf(dt()), TetrahedraOf(FromScratch(EmptyBox())));
  }
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
}  // namespace dynmesh::delaunay::delaunay_tetrahedralization_script_test
