// Every refusal but those of sizes (size_refusals_test.cc).
#include "tests/core/plc/plc_refusals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace dynmesh::plc::plc_refusals_test {
namespace {

constexpr double kLimit = 0x1p-41;  // in the unit square
constexpr FeatureId kReserved = FeatureId{0} - 0x10000;

TEST_F(PlcRefusals, BadIds) {
  const auto expect = [&](const Edit& edit, FeatureId id) {
    ExpectRefused({Edit::Remove(14), edit}, Code::kInvalidArgument, reason::kBadId, {id}, 1);
  };
  for (const FeatureId id : {FeatureId{0}, kReserved, kReserved + 7, kBoxFeature}) {
    expect(AddPoint(id, 0.1, 0.1), id);
    expect(AddSegment(id, 1, 5), id);
    expect(SetPoint(id, 0.1, 0.1), id);
    expect(Edit::Remove(id), id);
    expect(Edit::Move(id, 0.1, 0.1), id);
  }
  ExpectAccepted({AddPoint(kReserved - 1, 0.1, 0.1)});
  EXPECT_EQ(kLastFeatureId, kReserved - 1);
}

// From there up a region's id is that of a set of polygons.
TEST_F(PlcRefusals, IdsOfPolygonsFrom2To63Up) {
  constexpr FeatureId kSet = FeatureId{1} << 63;
  const Rings rings = {{1, 3, 5}};
  for (const FeatureId id : {kSet, kSet + 7, kReserved - 1}) {
    ExpectRefused({Edit::Remove(14), Edit::Add(Feature::Polygon(id, rings))},
                  Code::kInvalidArgument, reason::kBadId, {id}, 1);
    ExpectRefused({AddPoint(id, 0.1, 0.1), Edit::Set(Feature::Polygon(id, rings))},
                  Code::kInvalidArgument, reason::kBadId, {id}, 1);
    const absl::Status status =
        plc_.Check(EditBatch{Edit::Add(Feature::Polygon(id, rings))}).status();
    EXPECT_NE(status.message().find("1 to 9223372036854775807"), std::string::npos) << status;
  }
  ExpectAccepted({AddPoint(kSet, 0.1, 0.1)});
}

TEST_F(PlcRefusals, IdsInUse) {
  ExpectRefused({AddPoint(5, 0.1, 0.1)}, Code::kAlreadyExists, reason::kIdInUse, {5}, 0);
  ExpectRefused({AddPoint(11, 0.1, 0.1)}, Code::kAlreadyExists, reason::kIdInUse, {11}, 0);
  ExpectRefused({AddSegment(5, 1, 6)}, Code::kAlreadyExists, reason::kIdInUse, {5}, 0);
  ExpectRefused({AddPoint(30, 0.1, 0.1), AddSegment(30, 1, 5)}, Code::kAlreadyExists,
                reason::kIdInUse, {30}, 1);
  ExpectAccepted({Edit::Remove(5), AddPoint(5, 0.1, 0.1)});
  ExpectAccepted({Edit::Remove(14), AddPoint(14, 0.1, 0.1)});
}

TEST_F(PlcRefusals, UnknownFeatures) {
  ExpectRefused({Edit::Remove(30)}, Code::kNotFound, reason::kUnknownFeature, {30}, 0);
  ExpectRefused({SetPoint(30, 0.1, 0.1)}, Code::kNotFound, reason::kUnknownFeature, {30}, 0);
  ExpectRefused({SetSegment(30, 1, 5)}, Code::kNotFound, reason::kUnknownFeature, {30}, 0);
  ExpectRefused({Edit::Move(30, 0.1, 0.1)}, Code::kNotFound, reason::kUnknownFeature, {30}, 0);
  ExpectRefused({Edit::Remove(5), Edit::Remove(5)}, Code::kNotFound, reason::kUnknownFeature, {5},
                1);
  ExpectRefused({Edit::Move(30, 0.1, 0.1), AddPoint(30, 0.1, 0.1)}, Code::kNotFound,
                reason::kUnknownFeature, {30}, 0);
  ExpectAccepted({AddPoint(30, 0.1, 0.1), Edit::Move(30, 0.2, 0.1), Edit::Remove(30)});
}

TEST_F(PlcRefusals, WrongKinds) {
  ExpectRefused({Edit::Move(11, 0.1, 0.1)}, Code::kInvalidArgument, reason::kWrongKind, {11}, 0);
  Feature odd = Feature::Point(30, 0.1, 0.1);
  odd.kind = static_cast<FeatureKind>(0);
  ExpectRefused({Edit::Add(odd)}, Code::kInvalidArgument, reason::kWrongKind, {30}, 0);
  odd.id = 5;
  ExpectRefused({Edit::Set(odd)}, Code::kInvalidArgument, reason::kWrongKind, {5}, 0);
  Edit strange = AddPoint(30, 0.1, 0.1);
  strange.action = static_cast<Edit::Action>(9);
  ExpectRefused({strange}, Code::kInvalidArgument, reason::kWrongKind, {30}, 0);
  // Move and remove ignore the kind in the edit.
  Edit move = Edit::Move(5, 0.4, 0.5);
  move.feature.kind = static_cast<FeatureKind>(0);
  ExpectAccepted({move});
}

TEST_F(PlcRefusals, CoordinatesThatAreNotFinite) {
  for (const double bad : {kNan, kInf, -kInf}) {
    ExpectRefused({AddPoint(30, bad, 0.5)}, Code::kInvalidArgument, reason::kNotFinite, {30}, 0);
    ExpectRefused({AddPoint(30, 0.5, bad)}, Code::kInvalidArgument, reason::kNotFinite, {30}, 0);
    ExpectRefused({Edit::Move(5, bad, 0.5)}, Code::kInvalidArgument, reason::kNotFinite, {5}, 0);
    ExpectRefused({SetPoint(2, bad, 0.5)}, Code::kInvalidArgument, reason::kNotFinite, {2}, 0);
    // Only the result counts, and in 2D only x and y.
    ExpectAccepted({AddPoint(30, bad, 0.5), Edit::Move(30, 0.1, 0.1)});
    ExpectAccepted({Edit::Add(Feature::Point(30, 0.1, 0.1, bad))});
  }
}

TEST_F(PlcRefusals, PointsOutsideTheBox) {
  for (const double bad : {-0x1p-52, 1 + 0x1p-52, 7.0, -1e300}) {
    ExpectRefused({AddPoint(30, bad, 0.5)}, Code::kInvalidArgument, reason::kOutsideBox, {30}, 0);
    ExpectRefused({Edit::Move(5, 0.5, bad)}, Code::kInvalidArgument, reason::kOutsideBox, {5}, 0);
  }
  ExpectAccepted({AddPoint(30, 0, 0), AddPoint(31, 1, 1), AddPoint(32, 0, 1)});
}

TEST_F(PlcRefusals, CoordinatesTooNearToZero) {
  ExpectRefused({AddPoint(30, 0x1p-201, 0.5)}, Code::kInvalidArgument, reason::kTooClose, {30}, 0);
  ExpectRefused({AddPoint(30, 0.5, std::numeric_limits<double>::denorm_min())},
                Code::kInvalidArgument, reason::kTooClose, {30}, 0);
  ExpectAccepted({AddPoint(30, 0x1p-200, 0.5)});
}

TEST_F(PlcRefusals, UnknownEnds) {
  ExpectRefused({AddSegment(30, 5, 40)}, Code::kFailedPrecondition, reason::kUnknownEnd, {30, 40},
                0);
  ExpectRefused({AddSegment(30, 41, 40)}, Code::kFailedPrecondition, reason::kUnknownEnd,
                {30, 41, 40}, 0);
  ExpectRefused({AddSegment(30, 0, 5)}, Code::kFailedPrecondition, reason::kUnknownEnd, {30, 0}, 0);
  ExpectRefused({AddSegment(30, 5, 11)}, Code::kFailedPrecondition, reason::kUnknownEnd, {30, 11},
                0);
  ExpectRefused({Edit::Remove(5), SetSegment(14, 6, 5)}, Code::kFailedPrecondition,
                reason::kUnknownEnd, {14, 5}, 1);
  ExpectAccepted({AddSegment(30, 5, 40), AddPoint(40, 0.5, 0.4)});
}

TEST_F(PlcRefusals, SegmentsOfOnePoint) {
  ExpectRefused({AddSegment(30, 5, 5)}, Code::kInvalidArgument, reason::kDegenerateSegment, {30, 5},
                0);
  ExpectRefused({AddSegment(30, 40, 40)}, Code::kInvalidArgument, reason::kDegenerateSegment,
                {30, 40}, 0);
  ExpectRefused({SetSegment(14, 6, 6)}, Code::kInvalidArgument, reason::kDegenerateSegment, {14, 6},
                0);
}

TEST_F(PlcRefusals, PointsInUse) {
  ExpectRefused({Edit::Remove(2)}, Code::kFailedPrecondition, reason::kPointInUse, {2, 11, 12}, 0);
  ExpectRefused({Edit::Remove(12), Edit::Remove(2)}, Code::kFailedPrecondition, reason::kPointInUse,
                {2, 11}, 1);
  ExpectRefused({SetSegment(2, 5, 6)}, Code::kFailedPrecondition, reason::kPointInUse, {2, 11, 12},
                0);
  ExpectRefused({AddSegment(30, 5, 40), AddPoint(40, 0.5, 0.4), Edit::Remove(40)},
                Code::kFailedPrecondition, reason::kPointInUse, {40, 30}, 2);
  ExpectAccepted({Edit::Remove(2), Edit::Remove(11), Edit::Remove(12)});
  ExpectAccepted({Edit::Remove(2), SetSegment(11, 1, 5), Edit::Remove(12)});
}

TEST_F(PlcRefusals, PointsInUseNameNoMoreThanSixteenSegments) {
  // A wheel in the box; its rim would be too much, eight spokes are the most there can be.
  EditBatch batch = {AddPoint(100, 0.125, 0.5)};
  for (FeatureId i = 0; i < 8; ++i) {
    const double angle = 0.785398163397448310 * static_cast<double>(i);
    batch.push_back(
        AddPoint(101 + i, 0.125 + 0.0625 * std::cos(angle), 0.5 + 0.0625 * std::sin(angle)));
    batch.push_back(AddSegment(201 + i, 100, 101 + i));
  }
  ExpectAccepted(batch);
  // Sixteen and more occur only if the batch itself is at fault.
  for (FeatureId i = 0; i < 20; ++i) batch.push_back(AddSegment(301 + i, 100, 1));
  batch.push_back(Edit::Remove(100));
  const absl::Status status = plc_.Check(batch).status();
  ASSERT_TRUE(GetErrorDetail(status).has_value());
  EXPECT_EQ(GetErrorDetail(status)->reason, reason::kPointInUse);
  EXPECT_EQ(GetErrorDetail(status)->features.size(), 17u);
}

TEST_F(PlcRefusals, DuplicatePoints) {
  ExpectRefused({AddPoint(30, 0.5, 0.5)}, Code::kFailedPrecondition, reason::kDuplicatePoint,
                {30, 5}, 0);
  ExpectRefused({Edit::Move(5, 0.75, 0.75)}, Code::kFailedPrecondition, reason::kDuplicatePoint,
                {5, 3}, 0);
  ExpectRefused({AddPoint(30, 0, 0), AddPoint(31, -0.0, 0)}, Code::kFailedPrecondition,
                reason::kDuplicatePoint, {31, 30}, 1);
  ExpectRefused({AddPoint(31, 0, 0.5), AddPoint(30, -0.0, 0.5)}, Code::kFailedPrecondition,
                reason::kDuplicatePoint, {30, 31}, 1);
  ExpectAccepted({AddPoint(30, 0.5, 0.5), Edit::Remove(5)});
  ExpectAccepted({Edit::Move(5, 0.875, 0.25), Edit::Move(6, 0.5, 0.5), Edit::Move(7, 0.5, 0.6)});
}

TEST_F(PlcRefusals, DuplicateSegments) {
  ExpectRefused({AddSegment(30, 1, 2)}, Code::kFailedPrecondition, reason::kDuplicateSegment,
                {30, 11}, 0);
  ExpectRefused({AddSegment(30, 2, 1)}, Code::kFailedPrecondition, reason::kDuplicateSegment,
                {30, 11}, 0);
  ExpectRefused({SetSegment(14, 3, 2)}, Code::kFailedPrecondition, reason::kDuplicateSegment,
                {14, 12}, 0);
  ExpectAccepted({AddSegment(30, 1, 2), Edit::Remove(11)});
}

TEST_F(PlcRefusals, PointsOnSegments) {
  ExpectRefused({AddPoint(30, 0.5, 0.25)}, Code::kFailedPrecondition, reason::kPointOnSegment,
                {30, 11}, 0);
  ExpectRefused({Edit::Move(5, 0.75, 0.5)}, Code::kFailedPrecondition, reason::kPointOnSegment,
                {5, 12}, 0);
  ExpectRefused({AddSegment(30, 1, 3)}, Code::kFailedPrecondition, reason::kPointOnSegment, {30, 5},
                0);
  // A segment that a moved point takes along.
  ExpectRefused({Edit::Remove(13), Edit::Move(3, 0.9375, 0.25)}, Code::kFailedPrecondition,
                reason::kPointOnSegment, {12, 6}, 1);
  // An end in the inside of another segment: the point, not the crossing.
  ExpectRefused({AddPoint(30, 0.5, 0.25), AddSegment(31, 5, 30)}, Code::kFailedPrecondition,
                reason::kPointOnSegment, {30, 11}, 0);
}

TEST_F(PlcRefusals, PointsUlpsOffASegmentAreTooCloseNotOn) {
  for (const double off : {kUlp, -kUlp, 100 * kUlp, kLimit - kUlp, kUlp - kLimit}) {
    ExpectRefused({AddPoint(30, 0.5, 0.25 + off)}, Code::kFailedPrecondition, reason::kTooClose,
                  {30, 11}, 0);
    ExpectRefused({Edit::Move(5, 0.75 + off, 0.5)}, Code::kFailedPrecondition, reason::kTooClose,
                  {5, 12}, 0);
  }
  ExpectAccepted({AddPoint(30, 0.5, 0.25 + kLimit)});
  ExpectAccepted({AddPoint(30, 0.5, 0.25 - kLimit)});
  // A segment that passes a point ulps away.
  ExpectRefused({Edit::Move(5, 0.5, 0.5 + kUlp), AddSegment(30, 1, 3)}, Code::kFailedPrecondition,
                reason::kTooClose, {30, 5}, 1);
  ExpectAccepted({Edit::Move(5, 0.5, 0.5 + 2 * kLimit), AddSegment(30, 1, 3)});
}

TEST_F(PlcRefusals, PointsTooCloseToPoints) {
  ExpectRefused({AddPoint(30, 0.5 + kUlp, 0.5)}, Code::kFailedPrecondition, reason::kTooClose,
                {30, 5}, 0);
  ExpectRefused({AddPoint(30, 0.5, 0.5 - kLimit + kUlp)}, Code::kFailedPrecondition,
                reason::kTooClose, {30, 5}, 0);
  ExpectRefused({AddPoint(30, 0.75 * kLimit, 0), AddPoint(31, 0, 0)}, Code::kFailedPrecondition,
                reason::kTooClose, {31, 30}, 1);
  ExpectAccepted({AddPoint(30, 0.5 + kLimit, 0.5)});
  // The pairs at 2^-40 that must work.
  ExpectAccepted({AddPoint(30, 0.5, 0.5 + 0x1p-40), AddSegment(31, 5, 30)});
}

TEST_F(PlcRefusals, CrossingSegments) {
  ExpectRefused({AddPoint(30, 0.5, 0.125), AddSegment(31, 5, 30)}, Code::kFailedPrecondition,
                reason::kSegmentsCross, {31, 11}, 1);
  ExpectRefused({AddSegment(31, 5, 6)}, Code::kFailedPrecondition, reason::kSegmentsCross, {31, 12},
                0);
  // Of several the least id; of several edits the earliest.
  ExpectRefused({AddPoint(30, 1, 0.5), AddSegment(31, 5, 30)}, Code::kFailedPrecondition,
                reason::kSegmentsCross, {31, 12}, 1);
  ExpectRefused({AddSegment(31, 5, 6), AddSegment(10, 5, 7)}, Code::kFailedPrecondition,
                reason::kSegmentsCross, {31, 12}, 0);
  // A moved point's segment, and a segment with a point that comes later.
  ExpectRefused({Edit::Move(7, 0.5, 0.375)}, Code::kFailedPrecondition, reason::kSegmentsCross,
                {14, 12}, 0);
  ExpectRefused({AddSegment(31, 5, 40), AddPoint(41, 0.1, 0.1), AddPoint(40, 0.5, 0.125)},
                Code::kFailedPrecondition, reason::kSegmentsCross, {31, 11}, 2);
  ExpectAccepted({AddSegment(31, 5, 6), Edit::Remove(12)});
}

TEST(Plc, SaysWhereSegmentsCross) {
  const Plc2 plc{MeshOptions()};
  const absl::Status status =
      plc.Check({AddPoint(1, 0.25, 0.25), AddPoint(2, 0.75, 0.5), AddPoint(3, 0.25, 0.5),
                 AddPoint(4, 0.75, 0.25), AddSegment(5, 1, 2), AddSegment(6, 3, 4)})
          .status();
  EXPECT_EQ(
      status.message(),
      "segment 6 from point 3 (0.25, 0.5) to point 4 (0.75, 0.25) and segment 5 from point 1 "
      "(0.25, 0.25) to point 2 (0.75, 0.5) cross at (0.5, 0.375); add a point there and split "
      "both, or remove feature 5 in the same batch");
}

TEST_F(PlcRefusals, OverlappingSegments) {
  // With a common end. Without one, it is also an end in the inside of a segment; which of both is
  // reported depends on what comes last.
  ExpectRefused({AddPoint(30, 0.875, 0.875), AddPoint(31, 0.9375, 0.9375), AddSegment(32, 30, 31),
                 AddPoint(33, 1, 1), AddSegment(34, 30, 33)},
                Code::kFailedPrecondition, reason::kSegmentsOverlap, {34, 32}, 4);
  ExpectRefused({AddPoint(30, 0.5, 0), AddPoint(31, 0.75, 0), AddPoint(33, 1, 0),
                 AddPoint(34, 0.625, 0), AddSegment(42, 34, 33), AddSegment(41, 30, 31)},
                Code::kFailedPrecondition, reason::kPointOnSegment, {42, 31}, 4);
  ExpectRefused({AddPoint(30, 0.5, 0), AddPoint(31, 0.75, 0), AddSegment(41, 30, 31),
                 AddPoint(33, 0.25, 0), AddPoint(34, 0.875, 0), AddSegment(42, 34, 33)},
                Code::kFailedPrecondition, reason::kSegmentsOverlap, {42, 41}, 5);
  ExpectAccepted({AddPoint(30, 0.875, 0.875), AddPoint(31, 0.9375, 0.9375), AddSegment(32, 30, 31),
                  AddPoint(33, 1, 1), AddSegment(34, 31, 33)});
}

TEST_F(PlcRefusals, SmallAngles) {
  // At 0.0011 degrees: legal. At 0.0009: not.
  ExpectAccepted({AddSegment(30, 1, 5)});
  ExpectAccepted({AddPoint(30, 0.5, 0.25 + 4.8e-6), AddSegment(31, 1, 30)});
  const Edit sharp = AddPoint(30, 0.5, 0.25 + 3.9e-6);
  ExpectRefused({sharp, AddSegment(31, 1, 30)}, Code::kFailedPrecondition, reason::kSmallAngle,
                {31, 11}, 1);
  ExpectRefused({sharp, AddSegment(31, 30, 1)}, Code::kFailedPrecondition, reason::kSmallAngle,
                {31, 11}, 1);
  // A moved point may turn two segments to each other.
  ExpectRefused({Edit::Move(3, 0.5, 0.25 + 3.9e-6)}, Code::kFailedPrecondition, reason::kSmallAngle,
                {12, 11}, 0);
  const absl::Status status = plc_.Check({sharp, AddSegment(31, 1, 30)}).status();
  EXPECT_NE(status.message().find("0.00089"), std::string::npos) << status;
  EXPECT_NE(status.message().find("point 1"), std::string::npos) << status;
  // More than 90 degrees.
  ExpectAccepted({AddPoint(30, 0.0625, 0.25), AddSegment(31, 1, 30)});
}

TEST_F(PlcRefusals, Polygons) {
  const auto polygon = [](FeatureId id, Rings rings) {
    return Edit::Add(Feature::Polygon(id, std::move(rings)));
  };
  const auto bad = [&](Rings rings, const std::vector<FeatureId>& features) {
    ExpectRefused({polygon(30, std::move(rings))}, Code::kInvalidArgument, reason::kBadPolygon,
                  features, 0);
  };
  bad({}, {30});
  bad({{}}, {30});
  bad({{1, 2}}, {30});
  bad({{1, 2, 3}, {5, 6}}, {30});
  bad({{1, 2, 3, 1}}, {30, 1});
  bad({{1, 2, 3}, {2, 6, 3}}, {30, 2, 3});
  ExpectRefused({polygon(30, {{1, 2, 77}})}, Code::kFailedPrecondition, reason::kUnknownEnd,
                {30, 77}, 0);
  ExpectRefused({polygon(30, {{1, 2, 3}}), Edit::Remove(2)}, Code::kFailedPrecondition,
                reason::kPointInUse, {2, 11, 12, 30}, 1);
  ExpectRefused({polygon(30, {{5, 6, 7}})}, Code::kFailedPrecondition, reason::kSegmentsCross,
                {30, 12}, 0);
  ExpectRefused({polygon(30, {{1, 2, 3}})}, Code::kFailedPrecondition, reason::kPointOnSegment,
                {30, 5}, 0);
  ExpectRefused({polygon(30, {{1, 2, 3, 4}}), Edit::Move(30, 0, 0)}, Code::kInvalidArgument,
                reason::kWrongKind, {30}, 1);
  ExpectRefused({polygon(30, {{1, 2, 3, 4}}), polygon(30, {{1, 2, 3, 4}})}, Code::kAlreadyExists,
                reason::kIdInUse, {30}, 1);
  // On the square, and inside on its centre; a second one beside it; with the side closed.
  ExpectAccepted({polygon(30, {{1, 2, 3, 4}}), polygon(31, {{1, 2, 5}, {4, 5, 3}}),
                  polygon(32, {{2, 6, 3}}), AddSegment(33, 4, 1)});
}

TEST_F(PlcRefusals, TheEarliestEditToBlameIsReported) {
  const Edit dup = AddPoint(30, 0.5, 0.5), nan = AddPoint(31, kNan, 0), unknown = Edit::Remove(77);
  const Edit ok = AddPoint(40, 0.1, 0.1), use = Edit::Remove(2), end = AddSegment(32, 5, 50);
  ExpectRefused({ok, dup, nan, unknown}, Code::kFailedPrecondition, reason::kDuplicatePoint,
                {30, 5}, 1);
  ExpectRefused({ok, nan, dup, unknown}, Code::kInvalidArgument, reason::kNotFinite, {31}, 1);
  ExpectRefused({ok, unknown, nan, dup}, Code::kNotFound, reason::kUnknownFeature, {77}, 1);
  ExpectRefused({ok, use, nan, dup}, Code::kFailedPrecondition, reason::kPointInUse, {2, 11, 12},
                1);
  ExpectRefused({end, use, nan, dup}, Code::kFailedPrecondition, reason::kUnknownEnd, {32, 50}, 0);
  // A fault that a later edit repairs is not reported, even if the earlier edit cannot act.
  ExpectRefused({dup, ok, unknown, Edit::Move(30, 0.2, 0.2)}, Code::kNotFound,
                reason::kUnknownFeature, {77}, 2);
  ExpectRefused({dup, ok, unknown, Edit::Remove(5)}, Code::kNotFound, reason::kUnknownFeature, {77},
                2);
  ExpectRefused({end, ok, unknown, AddPoint(50, 0.5, 0.4)}, Code::kNotFound,
                reason::kUnknownFeature, {77}, 2);
}

TEST_F(PlcRefusals, OneBadFeatureIsFoundWhereverItStands) {
  for (std::size_t bad = 0; bad < 40; ++bad) {
    EditBatch batch;
    for (std::size_t i = 0; i < 40; ++i) {
      const double x = static_cast<double>(i) / 64;
      batch.push_back(i == bad ? AddPoint(100 + i, 0.5, 0.25) : AddPoint(100 + i, x, 0.0625));
    }
    ExpectRefused(batch, Code::kFailedPrecondition, reason::kPointOnSegment, {100 + bad, 11}, bad);
  }
}

}  // namespace
}  // namespace dynmesh::plc::plc_refusals_test
