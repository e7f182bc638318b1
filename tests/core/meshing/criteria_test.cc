// The two criteria of gaps, on stars of a handful of neighbours.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/meshing/edge_criterion.h"
#include "core/meshing/thesis_criterion.h"
#include "tests/core/meshing/lone_complex.h"

namespace dynmesh::meshing::criteria_test {
namespace {

constexpr double kNear = 0.125, kFar = 0.5;
const int kNearBucket = BucketOf(kNear * kNear);

// v in the middle, u near it to the east, the other neighbours at distance 1/2 along the axes.
template <int D>
struct Scene {
  // `first_axis`: of those neighbours, which come first.
  explicit Scene(bool v_is_younger, int first_axis = 0) {
    geometry::Point<D> p;
    p.c.fill(0.5);
    v = lone.Add(p, v_is_younger ? 3 : 1);
    star.Begin(v, p, 8);
    u = Insert(0, kNear, v_is_younger ? 1 : 3);
    for (int i = 0; i < 2 * D; ++i) {
      const int k = (first_axis + i) % D;
      const double by = i < D ? -kFar : kFar;
      if (k > 0 || by < 0) Insert(k, by, 2);
    }
  }
  VertexIndex Insert(int axis, double by, sac::Stamp birth) {
    geometry::Point<D> q = star.position();
    q[axis] += by;
    const VertexIndex w = lone.Add(q, birth);
    EXPECT_TRUE(star.Insert(w, q));
    return w;
  }
  EdgeCriterion<D, test::RecordingEngine> edges() { return {lone.complex, star, skipped}; }
  ThesisCriterion<D, test::RecordingEngine> cells() { return {lone.complex, star, skipped}; }
  // What v's Complete of this bucket requests.
  template <class Criterion>
  std::vector<test::Requested> Requests(const Criterion& criterion, int bucket) {
    auto context = lone.At(9, v, MakeEpoch(bucket, 0, kQualityStep));
    criterion.RequestNext(context, bucket);
    return context.requests;
  }

  LoneComplex<D> lone;
  VertexIndex v, u;
  Star<D> star;
  SkippedGaps<D> skipped;
};

test::Requested Complete(VertexIndex v, int bucket) {
  return {kComplete, v, MakeEpoch(bucket, 0, kQualityStep)};
}

template <class Dimension>
class CriteriaTest : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(CriteriaTest, Dimensions);

TYPED_TEST(CriteriaTest, TheYoungerEndFindsTheGapOfAnEdge) {
  constexpr int D = TypeParam();
  Scene<D> scene(true);
  Candidate<D> gap;
  EXPECT_FALSE(scene.edges().Find(kNearBucket - 1, &gap)) << "the edge is of a later bucket";
  for (const int bucket : {kNearBucket, kNearBucket + 5}) {
    ASSERT_TRUE(scene.edges().Find(bucket, &gap));
    const auto &p = scene.star.position(), &q = scene.lone.complex.vertex(scene.u).p;
    EXPECT_EQ(gap.neighbour, q);
    EXPECT_EQ(gap.facet, kNil);
    EXPECT_FALSE(gap.required);
    // On the bisector, too far from the ends, and no other vertex is nearer.
    const double r2 = geometry::SquaredDistance(gap.x, p);
    EXPECT_NEAR(r2, geometry::SquaredDistance(gap.x, q), 1e-12);
    EXPECT_GT(r2, kNear * kNear);
    EXPECT_LE(gap.e2, r2);
    scene.star.ForEachNeighbour(
        [&](const auto& w) { EXPECT_GE(geometry::SquaredDistance(gap.x, w.p), r2 * (1 - 1e-9)); });
  }
  Scene<D> older(false);
  EXPECT_FALSE(older.edges().Find(kBuckets - 2, &gap)) << "u deals with it; others have no gap";
}

TYPED_TEST(CriteriaTest, AnEdgesGapsMayBeSkippedOneByOne) {
  constexpr int D = TypeParam();
  Scene<D> scene(true);
  Candidate<D> gap;
  int found = 0;
  while (found < 5 && scene.edges().Find(kNearBucket, &gap)) {
    ++found;
    scene.skipped.Add(gap);
  }
  EXPECT_EQ(found, D == 2 ? 2 : 1) << "2D: one on each side";
}

TYPED_TEST(CriteriaTest, ByEdgesTheNextCompleteIsThatOfTheShortestEdgeWithAGap) {
  constexpr int D = TypeParam();
  Scene<D> scene(true), older(false);
  EXPECT_EQ(scene.Requests(scene.edges(), kNearBucket - 3),
            (std::vector{Complete(scene.v, kNearBucket)}));
  EXPECT_EQ(scene.Requests(scene.edges(), kNearBucket), (std::vector<test::Requested>()));
  EXPECT_EQ(older.Requests(older.edges(), 0), (std::vector<test::Requested>()));
}

// If a corner within the domain is at a ghost, more may come into view later.
TYPED_TEST(CriteriaTest, ByEdgesAnOpenViewIsWidened) {
  constexpr int D = TypeParam();
  LoneComplex<D> lone;
  geometry::Point<D> p;
  p.c.fill(0.5);
  const VertexIndex v = lone.Add(p, 1);
  Star<D> star;
  star.Begin(v, p, 0.125);
  SkippedGaps<D> skipped;
  const EdgeCriterion<D, test::RecordingEngine> edges(lone.complex, star, skipped);
  constexpr int kBucket = 4000;
  auto context = lone.At(9, v);
  edges.RequestNext(context, kBucket);
  EXPECT_EQ(context.requests,
            (std::vector{Complete(v, lone.complex.rules.LastKnownBucket(kBucket) + 1)}));
}

TYPED_TEST(CriteriaTest, ASizeMakesAGapOfATooLargeSimplex) {
  constexpr int D = TypeParam();
  for (const double target : {2.0, 0.25}) {
    Scene<D> scene(true);
    // Without the near vertex all simplices are good.
    scene.star.Begin(scene.v, scene.star.position(), 8);
    for (int k = 0; k < 2 * D; ++k) scene.Insert(k / 2, k % 2 == 0 ? kFar * 1.001 : -kFar, 2);
    Candidate<D> gap;
    EXPECT_FALSE(scene.edges().Find(kBuckets - 2, &gap));
    SizingRegion<D> region;
    region.lo.c.fill(0), region.hi.c.fill(1);
    region.target = target;
    scene.lone.input.AddSizing(region);
    ASSERT_EQ(scene.edges().Find(kBuckets - 2, &gap), target < 1);
    if (target > 1) continue;
    // The circumcentre.
    const double r2 = geometry::SquaredDistance(gap.x, scene.star.position());
    EXPECT_NEAR(r2, D * 0.0625, 1e-3);
  }
}

TYPED_TEST(CriteriaTest, ByTheThesisTheCellReachesTooFarWhoeverIsYounger) {
  constexpr int D = TypeParam();
  for (int round = 0; round < 2 * D; ++round) {
    Scene<D> scene(round % 2 == 0, round / 2);
    Candidate<D> gap;
    EXPECT_FALSE(scene.cells().Find(kNearBucket - 1, &gap)) << "NN(v) is of a later bucket";
    ASSERT_TRUE(scene.cells().Find(kNearBucket, &gap));
    const double r = std::sqrt(geometry::SquaredDistance(gap.x, scene.star.position()));
    const double gamma = scene.lone.complex.rules.gamma();
    EXPECT_NEAR(r, std::min(std::sqrt(D * 0.0625), gamma * kNear), 1e-9);
    EXPECT_NEAR(gap.e2, r * r, 1e-12);
    // Towards one of the farthest corners: a quarter away from v along each axis, west. The least.
    EXPECT_LT(gap.x[0], scene.star.position()[0]);
    for (int k = 1; k < D; ++k) EXPECT_LT(gap.x[k], scene.star.position()[k]);
  }
}

TYPED_TEST(CriteriaTest, ByTheThesisTheNextCompletesAreThoseOfNearestNeighbours) {
  constexpr int D = TypeParam();
  Scene<D> scene(true);
  // u's nearest vertex is v, which is younger; that of the others is v or u.
  auto requests = scene.Requests(scene.cells(), kNearBucket - 1);
  ASSERT_GE(requests.size(), 2u);
  EXPECT_EQ(requests[0], Complete(scene.v, kNearBucket));
  EXPECT_NE(std::ranges::find(requests, Complete(scene.u, kNearBucket)), requests.end());
  EXPECT_EQ(requests.size(), 1u + 1 + (2 * D - 1));
  scene.lone.complex.vertex(scene.v).epoch = kBirthOfInput;
  EXPECT_EQ(scene.Requests(scene.cells(), kNearBucket - 1),
            (std::vector{Complete(scene.v, kNearBucket)}));
  EXPECT_EQ(scene.Requests(scene.cells(), kNearBucket), (std::vector<test::Requested>()));
}

}  // namespace
}  // namespace dynmesh::meshing::criteria_test
