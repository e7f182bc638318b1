// The differential test has teeth: with any one term of a notification filter
// switched off it fails. Built from its own copy of the mesher, in which they can be.
#include <gtest/gtest.h>

#include "core/meshing/filter_terms.h"
#include "tests/differential/differential.h"

namespace dynmesh::test {
namespace {

// Operations that a batch of these sizes stays far below.
constexpr int kEnough = 20'000;

bool SuiteFails() {
  constexpr double kQualities[] = {2.0, kDefaultQuality2D, 1.2, 1.0};
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    for (const Distribution d : kAllDistributions) {
      if (d == Distribution::kParallel) continue;
      if (RunScript(d, 12, kQualities[seed % 4], seed, 15, 1, kEnough).difference.found)
        return true;
    }
    // Cascades of splits, the only place where this term counts. (With other terms off
    // they may not end.)
    if (meshing::switched_off == meshing::Term::kDeathOfSubsegment &&
        RunScript(Distribution::kParallel, 14, seed % 2 == 0 ? 1.2 : 1.0, seed, 40, 1, kEnough)
            .difference.found) {
      return true;
    }
  }
  return false;
}

class Mutation : public testing::TestWithParam<int> {
 protected:
  void TearDown() override { meshing::switched_off = meshing::Term::kCount; }
};

TEST_P(Mutation, OfOneFilterTermIsNoticed) {
  meshing::switched_off = static_cast<meshing::Term>(GetParam());
  EXPECT_TRUE(SuiteFails());
}

INSTANTIATE_TEST_SUITE_P(EveryTerm, Mutation,
                         testing::Range(0, static_cast<int>(meshing::Term::kCount)));

TEST(Mutation, WithNothingSwitchedOffNothingFails) {
  for (const Distribution d : kAllDistributions) {
    const RunReport run = RunScript(d, 12, 1.2, 3, 10);
    EXPECT_FALSE(run.difference.found) << NameOf(d) << ": " << run.difference.what;
  }
}

}  // namespace
}  // namespace dynmesh::test
