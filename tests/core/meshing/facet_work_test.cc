// Facet work at a square: which point of it a cell meets, and what moves to it.
#include "core/meshing/facet_work.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/core/meshing/lone_complex.h"

namespace dynmesh::meshing::facet_work_test {
namespace {

using geometry::Point3;
using Work = FacetWork<3, test::RecordingEngine>;

constexpr FeatureSlot kFacet = 77;

// The unit square at height 1/2, and v above its middle.
class FacetWorkTest : public testing::Test {
 protected:
  FacetWorkTest() {
    for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      corners_.push_back(lone_.Add({{double(x), double(y), 0.5}}));
    }
    lone_.input.AddFacet(std::vector<std::vector<VertexIndex>>{corners_}, kFacet);
    v_ = lone_.Add({{0.5, 0.5, 0.6}}, 1);
  }
  VertexIndex AddOnFacet(const Point3& p) {
    const VertexIndex u = lone_.Add(p, 1);
    lone_.complex.vertex(u).dimension = 2;
    lone_.complex.vertex(u).feature = kFacet;
    return u;
  }
  // Of all vertices.
  SpaceStar StarOf(VertexIndex v, double reach = 4) {
    SpaceStar star;
    star.Begin(v, lone_.complex.vertex(v).p, reach);
    for (const VertexIndex u : lone_.SeenAt(9)) {
      if (u != v) star.Insert(u, lone_.complex.vertex(u).p);
    }
    return star;
  }
  bool Find(VertexIndex v, double reach = 4) {
    found_ = {};
    return work_.FindPoint(StarOf(v, reach), skipped_, &found_);
  }

  LoneComplex<3> lone_;
  std::vector<VertexIndex> corners_;
  VertexIndex v_;
  Work work_{lone_.complex};
  SkippedGaps<3> skipped_;
  Candidate<3> found_;
};

TEST_F(FacetWorkTest, FindsThePointOfTheFacetNearestToTheVertex) {
  EXPECT_TRUE(work_.is_needed());
  ASSERT_TRUE(Find(v_));
  EXPECT_NEAR(geometry::SquaredDistance(found_.x, Point3{{0.5, 0.5, 0.5}}), 0, 1e-18);
  EXPECT_NEAR(found_.e2, 0.01, 1e-9);
  EXPECT_EQ(found_.neighbour, found_.x);
  EXPECT_EQ(found_.facet, kFacet);
  EXPECT_TRUE(found_.required);
  skipped_.Add(found_);
  EXPECT_FALSE(Find(v_));
  EXPECT_FALSE(found_.required);
}

TEST_F(FacetWorkTest, APointNotCertainlyInViewWaits) {
  EXPECT_FALSE(Find(v_, 0.0999));
  EXPECT_TRUE(Find(v_, 0.1001));
}

TEST_F(FacetWorkTest, AVertexOnTheFacetNeedsNoPoint) {
  EXPECT_FALSE(Find(corners_[0]));
  EXPECT_FALSE(Find(AddOnFacet({{0.3, 0.4, 0.5}})));
}

// The bisector between v and its foot is parallel to the facet.
TEST_F(FacetWorkTest, AVertexBetweenKeepsTheCellAway) {
  AddOnFacet({{0.5, 0.5, 0.5}});
  EXPECT_FALSE(Find(v_));
}

// Where its foot is nearer to another vertex, the cell meets the facet on the bisector.
TEST_F(FacetWorkTest, ACellThatIsCutOffMeetsTheFacetFartherAway) {
  AddOnFacet({{0.45, 0.5, 0.5}});
  ASSERT_TRUE(Find(v_));
  // On the facet the bisector is at x = (0.5^2 + 0.1^2 - 0.45^2) / (2 * 0.05) = 0.575.
  EXPECT_NEAR(found_.x[0], 0.575, 1e-9);
  EXPECT_NEAR(found_.x[1], 0.5, 1e-9);
  EXPECT_NEAR(found_.x[2], 0.5, 1e-12);
  EXPECT_NEAR(found_.e2, 0.01 + 0.075 * 0.075, 1e-9);
  EXPECT_FALSE(Find(v_, 0.124)) << "not certainly in view";
  EXPECT_TRUE(Find(v_, 0.126));
}

TEST_F(FacetWorkTest, TheDistanceCountsFacetsThatTheVertexIsNotOn) {
  EXPECT_NEAR(work_.Distance2(v_, 1), 0.01, 1e-12);
  EXPECT_EQ(work_.Distance2(v_, 0.005), 0.005);
  EXPECT_EQ(work_.Distance2(corners_[1], 1), 1);
  const VertexIndex beside = lone_.Add({{1.2, 0.5, 0.5}}, 1);
  EXPECT_EQ(work_.Distance2(beside, 1), 1) << "an edge is nearest";
}

TEST_F(FacetWorkTest, AGapsPointMovesToAFacetNextToIt) {
  const SpaceStar star = StarOf(v_);
  Candidate<3> gap;
  gap.x = {{0.5, 0.5, 0.56}};  // 0.04 from v, 0.06 from the facet
  gap.e2 = 0.0016;
  work_.MoveToFacet(star, &gap);
  EXPECT_EQ(gap.facet, kNil);
  EXPECT_EQ(gap.e2, 0.0016);
  gap.x = {{0.5, 0.5, 0.52}};
  gap.e2 = 0.0064;
  work_.MoveToFacet(star, &gap);
  EXPECT_EQ(gap.facet, kFacet);
  EXPECT_NEAR(gap.x[2], 0.5, 1e-15);
  EXPECT_NEAR(gap.e2, (1 - kNearFacet) * (1 - kNearFacet) * 0.0064, 1e-12);
}

TEST_F(FacetWorkTest, AGapsPointMovesToTheNearestFacet) {
  std::vector<VertexIndex> below;
  for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
    below.push_back(lone_.Add({{double(x), double(y), 0.45}}));
  }
  lone_.input.AddFacet(std::vector<std::vector<VertexIndex>>{below}, kFacet + 1);
  const SpaceStar star = StarOf(v_);
  for (const auto& [z, facet] : {std::pair(0.49, kFacet), {0.46, kFacet + 1}}) {
    Candidate<3> gap;
    gap.x = {{0.5, 0.5, z}};
    work_.MoveToFacet(star, &gap);
    EXPECT_EQ(gap.facet, facet);
  }
}

TEST_F(FacetWorkTest, ACellLeavesOtherFacetsWholeOrNot) {
  EXPECT_FALSE(work_.LeavesWhole(StarOf(v_), kNil));
  EXPECT_TRUE(work_.LeavesWhole(StarOf(v_), kFacet));
  AddOnFacet({{0.5, 0.5, 0.5}});
  EXPECT_TRUE(work_.LeavesWhole(StarOf(v_), kNil));
}

TEST(FacetWork, InThePlaneNothingIsFound) {
  const LoneComplex<2> lone;
  const FacetWork<2, test::RecordingEngine> work(lone.complex);
  EXPECT_FALSE(work.is_needed());
  EXPECT_EQ(work.Distance2(0, 3), 3);
}

}  // namespace
}  // namespace dynmesh::meshing::facet_work_test
