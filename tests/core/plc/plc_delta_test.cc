// The results of Check and the effects of Apply: exactly the net change.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/error.h"
#include "tests/core/plc/plc_test_util.h"

namespace dynmesh::plc::plc_delta_test {
namespace {

const geometry::Point2 kA{{0.25, 0.25}}, kB{{0.75, 0.25}}, kC{{0.5, 0.75}};

SegmentFeature<2> SegmentOf(const Plc2& plc, FeatureId id) {
  return plc.store().Expand(id, *plc.store().FindSegment(id));
}

// Sorted.
std::vector<FeatureId> SegmentsAt(const Plc2& plc, FeatureId point) {
  const auto at = plc.store().SegmentsAt(point);
  std::vector<FeatureId> segments(at.begin(), at.end());
  std::sort(segments.begin(), segments.end());
  return segments;
}

// Triangle 1, 2, 3 with sides 11 = (1, 2) and 12 = (2, 3).
class PlcDelta : public testing::Test {
 protected:
  PlcDelta() : plc_(Square(0, 1)) {
    Apply(plc_, {AddPoint(1, kA[0], kA[1]), AddPoint(2, kB[0], kB[1]), AddPoint(3, kC[0], kC[1]),
                 AddSegment(11, 1, 2), AddSegment(12, 2, 3)});
  }
  Plc2 plc_;
};

TEST_F(PlcDelta, FirstBatchAddsEverythingSortedById) {
  Plc2 fresh(Square(0, 1));
  const Delta<2> delta =
      Apply(fresh, {AddSegment(9, 7, 3), AddPoint(7, 0.5, 0.5), AddPoint(3, 0.25, 0.5)});
  EXPECT_EQ(delta.added_points,
            (std::vector<PointFeature<2>>{{3, {{0.25, 0.5}}}, {7, {{0.5, 0.5}}}}));
  EXPECT_EQ(delta.added_segments,
            (std::vector<SegmentFeature<2>>{{9, 7, 3, {{0.5, 0.5}}, {{0.25, 0.5}}}}));
  EXPECT_TRUE(delta.removed_points.empty());
  EXPECT_TRUE(delta.removed_segments.empty());
}

TEST_F(PlcDelta, NothingChangesUntilApply) {
  const absl::StatusOr<Delta<2>> delta = plc_.Check({AddPoint(4, 0.1, 0.1)});
  ASSERT_TRUE(delta.ok());
  EXPECT_EQ(plc_.store().FindPoint(4), nullptr);
  EXPECT_EQ(plc_.size(), 5u);
  plc_.Apply(*delta);
  EXPECT_NE(plc_.store().FindPoint(4), nullptr);
  EXPECT_EQ(plc_.size(), 6u);
}

TEST_F(PlcDelta, EmptyBatchAndBatchesWithoutNetChangeAreEmpty) {
  for (const EditBatch& batch : std::vector<EditBatch>{
           {},
           {AddPoint(4, 0.1, 0.1), Edit::Remove(4)},
           {Edit::Move(2, 0.8, 0.2), Edit::Move(2, kB[0], kB[1])},
           {SetPoint(2, kB[0], kB[1])},
           {SetSegment(11, 1, 2)},
           {Edit::Remove(12), AddSegment(12, 2, 3)},
           {Edit::Remove(2), AddPoint(2, kB[0], kB[1])},
       }) {
    const absl::StatusOr<Delta<2>> delta = plc_.Check(batch);
    ASSERT_TRUE(delta.ok()) << delta.status();
    EXPECT_TRUE(delta->empty()) << ScriptOf(batch);
  }
}

TEST_F(PlcDelta, AMovedPointTakesItsSegmentsAlong) {
  const geometry::Point2 to{{0.8, 0.2}};
  const Delta<2> delta = Apply(plc_, {Edit::Move(2, to[0], to[1])});
  EXPECT_EQ(delta.removed_points, (std::vector<PointFeature<2>>{{2, kB}}));
  EXPECT_EQ(delta.added_points, (std::vector<PointFeature<2>>{{2, to}}));
  EXPECT_EQ(delta.removed_segments,
            (std::vector<SegmentFeature<2>>{{11, 1, 2, kA, kB}, {12, 2, 3, kB, kC}}));
  EXPECT_EQ(delta.added_segments,
            (std::vector<SegmentFeature<2>>{{11, 1, 2, kA, to}, {12, 2, 3, to, kC}}));
  EXPECT_EQ(SegmentOf(plc_, 12), (SegmentFeature<2>{12, 2, 3, to, kC}));
}

TEST_F(PlcDelta, AReplacedSegmentAppearsInBothLists) {
  const Delta<2> delta = Apply(plc_, {SetSegment(12, 1, 3)});
  EXPECT_TRUE(delta.removed_points.empty());
  EXPECT_TRUE(delta.added_points.empty());
  EXPECT_EQ(delta.removed_segments, (std::vector<SegmentFeature<2>>{{12, 2, 3, kB, kC}}));
  EXPECT_EQ(delta.added_segments, (std::vector<SegmentFeature<2>>{{12, 1, 3, kA, kC}}));
}

TEST_F(PlcDelta, AFeatureMayChangeItsKind) {
  const Delta<2> delta = Apply(plc_, {SetPoint(12, 0.1, 0.1), Edit::Remove(3)});
  EXPECT_EQ(delta.removed_segments, (std::vector<SegmentFeature<2>>{{12, 2, 3, kB, kC}}));
  EXPECT_EQ(delta.removed_points, (std::vector<PointFeature<2>>{{3, kC}}));
  EXPECT_EQ(delta.added_points, (std::vector<PointFeature<2>>{{12, {{0.1, 0.1}}}}));
  Apply(plc_, {SetSegment(12, 1, 5), AddPoint(5, 0.1, 0.3)});
  EXPECT_NE(plc_.store().FindSegment(12), nullptr);
  EXPECT_EQ(plc_.store().FindPoint(12), nullptr);
}

TEST_F(PlcDelta, TheInverseRestoresTheFeatures) {
  const std::vector<Feature> before = plc_.Features();
  const Delta<2> delta = Apply(plc_, {Edit::Move(2, 0.8, 0.2), Edit::Remove(11), Edit::Remove(1),
                                      AddPoint(20, 0.1, 0.9), AddSegment(21, 20, 3)});
  EXPECT_NE(plc_.Features(), before);
  EXPECT_EQ(delta.Inverse().Inverse(), delta);
  plc_.Apply(delta.Inverse());
  EXPECT_EQ(plc_.Features(), before);
  EXPECT_EQ(SegmentsAt(plc_, 2), (std::vector<FeatureId>{11, 12}));
  // The index is back, too.
  EXPECT_FALSE(plc_.Check({AddPoint(30, 0.5, 0.25)}).ok());
  EXPECT_TRUE(plc_.Check({AddPoint(30, 0.1, 0.9)}).ok());
}

TEST_F(PlcDelta, MinusZeroIsStoredAsZero) {
  Apply(plc_, {AddPoint(4, -0.0, -0.0)});
  EXPECT_FALSE(std::signbit(plc_.store().FindPoint(4)->p[0]));
  EXPECT_FALSE(std::signbit(plc_.store().FindPoint(4)->p[1]));
  EXPECT_TRUE(plc_.Check({Edit::Move(4, 0, -0.0)})->empty());
}

TEST_F(PlcDelta, FeaturesAreSortedAndLookedUpById) {
  EXPECT_EQ(plc_.Features(),
            (std::vector<Feature>{Feature::Point(1, kA[0], kA[1]), Feature::Point(2, kB[0], kB[1]),
                                  Feature::Point(3, kC[0], kC[1]), Feature::Segment(11, 1, 2),
                                  Feature::Segment(12, 2, 3)}));
  EXPECT_EQ(plc_.store().FindPoint(2)->p, kB);
  EXPECT_EQ(plc_.store().FindPoint(11), nullptr);
  EXPECT_EQ(SegmentOf(plc_, 11), (SegmentFeature<2>{11, 1, 2, kA, kB}));
  EXPECT_EQ(plc_.store().FindSegment(2), nullptr);
  EXPECT_EQ(SegmentsAt(plc_, 2), (std::vector<FeatureId>{11, 12}));
  EXPECT_TRUE(SegmentsAt(plc_, 77).empty());
  EXPECT_EQ(plc_.store().points().size(), 3u);
  EXPECT_EQ(plc_.store().segments().size(), 2u);
}

TEST_F(PlcDelta, ACheckMayBeInterruptedAtEveryFeature) {
  Plc2 plc(Square(0, 1));
  const EditBatch batch = {AddPoint(1, 0.25, 0.25), AddPoint(2, 0.75, 0.25), AddSegment(3, 1, 2)};
  for (std::size_t stop = 0; stop <= batch.size(); ++stop) {
    std::size_t asked = 0;
    const auto delta = plc.Check(batch, nullptr, [&](std::size_t) { return asked++ == stop; });
    if (stop < batch.size()) {
      EXPECT_EQ(delta.status().code(), absl::StatusCode::kCancelled);
      ASSERT_TRUE(GetErrorDetail(delta.status()).has_value());
      EXPECT_EQ(GetErrorDetail(delta.status())->reason, reason::kCancelled);
      EXPECT_EQ(asked, stop + 1);
    } else {
      EXPECT_TRUE(delta.ok()) << delta.status();
    }
  }
}

TEST_F(PlcDelta, ABoxWithoutExtentTakesItsOnePoint) {
  Plc2 plc(Square(5, 5));
  Apply(plc, {AddPoint(1, 5, 5)});
  EXPECT_EQ(plc.Check({AddPoint(2, 5, 5 + 0x1p-50)}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(plc.Check({AddPoint(2, 5, 5)}).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST_F(PlcDelta, AFlatBoxTakesPointsOnALine) {
  MeshOptions options;
  options.box.lo = {-1, 3, 0};
  options.box.hi = {1, 3, 0};
  Plc2 plc(options);
  Apply(plc, {AddPoint(1, -1, 3), AddPoint(2, 1, 3), AddPoint(3, 0.5, 3), AddSegment(4, 1, 3)});
  EXPECT_FALSE(plc.Check({AddSegment(5, 1, 2)}).ok());
  EXPECT_TRUE(plc.Check({AddSegment(5, 2, 3)}).ok());
}

TEST_F(PlcDelta, OfCapsules) {
  Plc2 plc(Square(0, 1));
  const Feature capsule = Feature::SizeCapsule(7, {{0.5, 0.0}, {0.25, 0.5}}, 0.25, 0.125);
  Apply(plc, {Edit::Add(capsule)});
  // -0 is +0; members unused by a capsule and a third coordinate are dropped.
  Feature untidy = Feature::SizeCapsule(7, {{0.5, -0.0, 3}, {0.25, 0.5, -1}}, 0.25, 0.125);
  untidy.sizing.hi = {4, 4, 4};
  untidy.position = {0.5, 0.5, 0.5};
  EXPECT_TRUE(plc.Check({Edit::Set(untidy)})->empty());
  EXPECT_EQ(plc.Features(), std::vector<Feature>{capsule});
  const auto moved =
      plc.Check({Edit::Set(Feature::SizeCapsule(7, {{0.5, 0}, {0.25, 0.75}}, 0.25, 0.125))});
  ASSERT_TRUE(moved.ok());
  EXPECT_EQ(moved->size(), 2u);
  plc.Apply(*moved);
  EXPECT_EQ(plc.Features()[0].sizing.path[1][1], 0.75);
  plc.Apply(moved->Inverse());
  EXPECT_EQ(plc.Features(), std::vector<Feature>{capsule});
}

TEST_F(PlcDelta, OfSizes) {
  Plc2 plc(Square(0, 1));
  const Feature disc = Feature::SizeDisc(7, 0.5, -0.0, 0.25, 0.125);
  Apply(plc, {AddPoint(1, 0.5, 0.5), Edit::Add(disc)});
  EXPECT_EQ(plc.size(), 2u);
  // -0 is +0; members unused by a disc are dropped.
  Feature untidy = Feature::SizeDisc(7, 0.5, 0.0, 0.25, 0.125);
  untidy.sizing.hi = {4, 4, 4};
  EXPECT_TRUE(plc.Check({Edit::Set(untidy)})->empty());
  EXPECT_TRUE(plc.Check({Edit::Remove(7), Edit::Add(disc)})->empty());
  EXPECT_EQ(plc.Features().size(), 2u);
  EXPECT_EQ(plc.Features()[1], Feature::SizeDisc(7, 0.5, 0.0, 0.25, 0.125));

  const auto finer = plc.Check({Edit::Set(Feature::SizeDisc(7, 0.5, 0, 0.25, 0.0625))});
  ASSERT_TRUE(finer.ok());
  ASSERT_EQ(finer->removed_sizes.size(), 1u);
  ASSERT_EQ(finer->added_sizes.size(), 1u);
  EXPECT_EQ(finer->size(), 2u);
  EXPECT_EQ(finer->added_sizes[0].sizing.target, 0.0625);
  EXPECT_EQ(finer->Inverse().Inverse(), *finer);
  plc.Apply(*finer);
  plc.Apply(finer->Inverse());
  EXPECT_EQ(plc.store().FindSize(7)->sizing.target, 0.125);

  // Kinds change in place.
  const auto point = plc.Check({Edit::Set(Feature::Point(7, 0.25, 0.25))});
  ASSERT_TRUE(point.ok());
  EXPECT_EQ(point->removed_sizes.size(), 1u);
  EXPECT_EQ(point->added_points.size(), 1u);
  plc.Apply(*point);
  EXPECT_EQ(plc.store().FindSize(7), nullptr);
  const auto back = plc.Check({Edit::Set(disc)});
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->removed_points.size(), 1u);
  EXPECT_EQ(back->added_sizes.size(), 1u);
  plc.Apply(*back);
  EXPECT_EQ(plc.store().FindPoint(7), nullptr);
  Apply(plc, {Edit::Remove(7)});
  EXPECT_EQ(plc.size(), 1u);
}

// However it is split, the parts together equal the whole.
TEST(PlcDeltaParts, MakeTheWholeChange) {
  const EditBatch before = {AddPoint(1, 0.1, 0.1),
                            AddPoint(2, 0.9, 0.1),
                            AddPoint(3, 0.5, 0.8),
                            AddPoint(4, 0.2, 0.5),
                            AddSegment(5, 1, 2),
                            AddSegment(6, 1, 4),
                            Edit::Add(Feature::Polygon(7, {{1, 2, 3}})),
                            Edit::Add(Feature::SizeAt(8, 0.3, 0.3, 0.2))};
  Plc2 plc(Square(0, 1));
  Apply(plc, before);
  const std::vector<Feature> from = plc.Features();
  const absl::StatusOr<Delta<2>> whole = plc.Check(
      {Edit::Remove(7), Edit::Remove(5), Edit::Remove(6), Edit::Move(4, 0.3, 0.6),
       AddPoint(9, 0.7, 0.7), AddSegment(10, 4, 9), Edit::Remove(8),
       Edit::Add(Feature::Polygon(11, {{1, 2, 9}})), Edit::Add(Feature::SizeAt(8, 0.3, 0.3, 0.1))});
  ASSERT_TRUE(whole.ok()) << whole.status();
  ASSERT_GE(whole->size(), 10u);
  std::vector<Feature> to;
  for (std::size_t at_once = whole->size(); at_once > 0; --at_once) {
    for (std::size_t at = 0; at < whole->size(); at += at_once) {
      const Delta<2> part = whole->Part(at, std::min(at + at_once, whole->size()));
      EXPECT_EQ(part.size(), std::min(at_once, whole->size() - at));
      plc.Apply(part);
    }
    if (to.empty()) to = plc.Features();
    EXPECT_EQ(plc.Features(), to);
    plc.Apply(whole->Inverse());
    EXPECT_EQ(plc.Features(), from);
  }
  EXPECT_EQ(whole->Part(0, whole->size()), *whole);
}

}  // namespace
}  // namespace dynmesh::plc::plc_delta_test
