// Legal and refused 3D input, case by case.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/error.h"
#include "tests/core/plc/plc_test_util.h"

namespace dynmesh::plc::space_plc_test {
namespace {

using Ids = std::vector<FeatureId>;

// Expects `batch` on what is present to be refused, for `reason`, naming `features`.
void ExpectRefused(const Plc3& plc, const EditBatch& batch, const std::string& reason,
                   const Ids& features) {
  const auto delta = plc.Check(batch);
  ASSERT_FALSE(delta.ok()) << "wanted " << reason;
  const std::optional<ErrorDetail> detail = GetErrorDetail(delta.status());
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, reason) << delta.status();
  EXPECT_EQ(detail->features, features) << delta.status();
}
void ExpectRefused(const EditBatch& batch, const std::string& reason, const Ids& features) {
  ExpectRefused(Plc3(Cube(0, 1)), batch, reason, features);
}
void ExpectLegal(const EditBatch& batch) {
  const auto delta = Plc3(Cube(0, 1)).Check(batch);
  EXPECT_TRUE(delta.ok()) << delta.status();
}

// Polygon 10 in the plane z = 0.5, corners 1 to 4.
EditBatch Plate() {
  return {AddPoint3(1, 0.25, 0.25, 0.5), AddPoint3(2, 0.75, 0.25, 0.5),
          AddPoint3(3, 0.75, 0.75, 0.5), AddPoint3(4, 0.25, 0.75, 0.5),
          AddPolygon(10, {{1, 2, 3, 4}})};
}

TEST(SpacePlc, SolidsAreLegal) {
  ExpectLegal(BoxOf(1, 20, {0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}));
  // In a box.
  ExpectLegal(BoxOf(1, 20, {0, 0, 0}, {1, 1, 1}) +
              BoxOf(11, 30, {0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}));
  ExpectLegal({AddPoint3(1, 0, 0, 0), AddPoint3(2, 1, 1, 0), AddPoint3(3, 1, 0, 1),
               AddPoint3(4, 0, 1, 1), AddPolygon(11, {{1, 2, 3}}), AddPolygon(12, {{1, 2, 4}}),
               AddPolygon(13, {{1, 3, 4}}), AddPolygon(14, {{2, 3, 4}})});
}

TEST(SpacePlc, AnLPrismIsLegal) {
  const double x[] = {0, 1, 1, 0.5, 0.5, 0}, y[] = {0, 0, 0.5, 0.5, 1, 1};
  EditBatch batch;
  for (FeatureId i = 0; i < 6; ++i) {
    batch.push_back(AddPoint3(1 + i, x[i], y[i], 0));
    batch.push_back(AddPoint3(11 + i, x[i], y[i], 1));
    const FeatureId j = (i + 1) % 6;
    batch.push_back(AddPolygon(21 + i, {{1 + i, 1 + j, 11 + j, 11 + i}}));
  }
  batch.push_back(AddPolygon(31, {{1, 2, 3, 4, 5, 6}}));
  batch.push_back(AddPolygon(32, {{16, 15, 14, 13, 12, 11}}));
  ExpectLegal(batch);
  // Across the corner of the notch, or the inside.
  Plc3 plc(Cube(0, 1));
  Apply(plc, batch);
  ExpectRefused(plc, {Edit::Add(Feature::Segment(40, 1, 4))}, reason::kSegmentMeetsPolygon,
                {40, 31});
  ExpectRefused(plc, {Edit::Add(Feature::Segment(40, 3, 6))}, reason::kSegmentsCross, {40, 24});
}

// Corners 5 to 8 around the middle of the plate.
EditBatch Hole(double half, double z, FeatureId first) {
  EditBatch batch;
  for (const auto& [x, y] : std::vector<std::pair<int, int>>{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    batch.push_back(AddPoint3(first++, 0.5 + x * half, 0.5 + y * half, z));
  }
  return batch;
}

TEST(SpacePlc, APlateMayHaveAHoleAndAnIslandInIt) {
  EditBatch holed = Plate() + Hole(0.125, 0.5, 5);
  holed.push_back(Edit::Set(Feature::Polygon(10, {{1, 2, 3, 4}, {5, 6, 7, 8}})));
  ExpectLegal(holed);
  // A lid on the hole, a rod through it, a second plate across it that touches nothing.
  ExpectLegal(holed + EditBatch{AddPolygon(11, {{8, 7, 6, 5}})});
  ExpectLegal(holed + EditBatch{AddPoint3(31, 0.5, 0.5, 0.25), AddPoint3(32, 0.5, 0.5, 0.75),
                                Edit::Add(Feature::Segment(33, 31, 32))});
  const EditBatch island = holed + Hole(0.0625, 0.5, 21);
  ExpectLegal(island + EditBatch{AddPolygon(11, {{21, 22, 23, 24}})});
  EditBatch three = island;
  three.push_back(Edit::Set(Feature::Polygon(10, {{21, 22, 23, 24}, {1, 2, 3, 4}, {8, 7, 6, 5}})));
  ExpectLegal(three);
  ExpectRefused(three + EditBatch{AddPoint3(40, 0.5, 0.5, 0.5)}, reason::kPointOnPolygon, {40, 10});
}

TEST(SpacePlc, TwoBoxesMayShareAFace) {
  EditBatch batch = BoxOf(1, 20, {0, 0, 0}, {0.5, 0.5, 0.5});
  const EditBatch corners = Corners(11, {0.5, 0, 0}, {1, 0.5, 0.5});
  for (const Edit& edit : corners) {
    if (edit.feature.position[0] == 1) batch.push_back(edit);
  }
  const auto faces = Faces(11);
  FeatureId id = 30;
  for (std::size_t i = 1; i < 6; ++i) {
    auto face = faces[i];
    for (FeatureId& corner : face) {
      if ((corner - 11) % 2 == 0) corner = corner - 11 + 2;
    }
    batch.push_back(AddPolygon(id++, {face}));
  }
  ExpectLegal(batch);
  Plc3 plc(Cube(0, 1));
  Apply(plc, batch);
  // A second polygon where they touch is one too many, whichever way round.
  ExpectRefused(plc, {AddPolygon(40, {{4, 8, 6, 2}})}, reason::kDuplicatePolygon, {40, 21});
  // One that overlaps half of it.
  ExpectRefused(plc, {AddPolygon(40, {{4, 8, 6}})}, reason::kSegmentMeetsPolygon, {40, 21});
}

TEST(SpacePlc, PolygonsAreFlat) {
  const auto with = [](double z) {
    EditBatch batch = Plate();
    batch[2] = AddPoint3(3, 0.75, 0.75, z);
    return batch;
  };
  ExpectLegal(with(0.5 + 1e-10));
  const auto detail = GetErrorDetail(Plc3(Cube(0, 1)).Check(with(0.5 + 1e-8)).status());
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, reason::kNonPlanar);
  EXPECT_EQ(detail->features.front(), 10u);
  // Of many corners the one to blame is named.
  EditBatch round;
  Rings ring(1);
  for (FeatureId i = 1; i <= 9; ++i) {
    const double a = static_cast<double>(i) * 2 * std::numbers::pi / 9;
    round.push_back(
        AddPoint3(i, 0.5 + 0.3 * std::cos(a), 0.5 + 0.3 * std::sin(a), i == 7 ? 0.6 : 0.5));
    ring[0].push_back(i);
  }
  ExpectRefused(round + EditBatch{AddPolygon(20, ring)}, reason::kNonPlanar, {20, 7});
}

// A triangle whose corners are just far enough apart.
TEST(SpacePlc, PolygonsHaveAnArea) {
  const auto triangle = [](double side) {
    return EditBatch{AddPoint3(1, 0, 0, 0), AddPoint3(2, side, 0, 0),
                     AddPoint3(3, side / 2, side * std::sqrt(0.75), 0),
                     AddPolygon(10, {{1, 2, 3}})};
  };
  const double limit = CloseLimit(Cube(0, 1));
  ExpectRefused(triangle(1.5 * limit), reason::kBadPolygon, {10});
  ExpectLegal(triangle(3 * limit));
}

TEST(SpacePlc, PolygonsWantAQualityThatRefinementEndsAt) {
  MeshOptions options = Cube(0, 1);
  options.quality = std::nextafter(1.4, 0.0);
  const Plc3 below(options);
  ExpectRefused(below, Plate(), reason::kQualityTooLow, {10});
  const auto refused = below.Check(Plate());
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(GetErrorDetail(refused.status())->edit, 4u);
  EXPECT_NE(refused.status().message().find("1.4 or more"), absl::string_view::npos);
  // The first of them, and before anything else that is wrong with it.
  EditBatch more = Plate() + EditBatch{AddPolygon(9, {{1, 2, 3}})};
  ExpectRefused(below, more, reason::kQualityTooLow, {10});
  more[2] = AddPoint3(3, 0.75, 0.75, 0.7);
  ExpectRefused(below, more, reason::kQualityTooLow, {10});
  ExpectRefused(below, {AddPolygon(9, {{1, 2}})}, reason::kQualityTooLow, {9});
  EditBatch points = Plate();
  points.pop_back();
  EXPECT_TRUE(below.Check(points).ok());
  EXPECT_TRUE(below.Check(points + EditBatch{Edit::Add(Feature::Segment(10, 1, 2))}).ok());
  options.quality = 1.4;
  EXPECT_TRUE(Plc3(options).Check(Plate()).ok());
}

TEST(SpacePlc, PointsAreOffTheInsidesOfPolygons) {
  const double limit = CloseLimit(Cube(0, 1));
  ExpectRefused(Plate() + EditBatch{AddPoint3(20, 0.5, 0.4, 0.5)}, reason::kPointOnPolygon,
                {20, 10});
  ExpectRefused(Plate() + EditBatch{AddPoint3(20, 0.5, 0.4, 0.5 + limit / 2)}, reason::kTooClose,
                {20, 10});
  ExpectLegal(Plate() + EditBatch{AddPoint3(20, 0.5, 0.4, 0.5 + limit)});
  ExpectLegal(Plate() + EditBatch{AddPoint3(20, 0.5, 0.2, 0.5)});
  // The polygon comes last: then it is the offender.
  ExpectRefused(EditBatch{AddPoint3(20, 0.5, 0.4, 0.5)} + Plate(), reason::kPointOnPolygon,
                {10, 20});
}

TEST(SpacePlc, SegmentsDoNotMeetTheInsidesOfPolygons) {
  const EditBatch rod = {AddPoint3(20, 0.5, 0.5, 0.25), AddPoint3(21, 0.4, 0.5, 0.75),
                         Edit::Add(Feature::Segment(22, 20, 21))};
  ExpectRefused(Plate() + rod, reason::kSegmentMeetsPolygon, {22, 10});
  ExpectRefused(rod + Plate(), reason::kSegmentMeetsPolygon, {10, 22});
  ExpectRefused(Plate() + EditBatch{Edit::Add(Feature::Segment(22, 1, 3))},
                reason::kSegmentMeetsPolygon, {22, 10});
  // In its plane, from one side to the other: it crosses edges.
  const auto across =
      Plc3(Cube(0, 1))
          .Check(Plate() + EditBatch{AddPoint3(20, 0.5, 0.1, 0.5), AddPoint3(21, 0.5, 0.9, 0.5),
                                     Edit::Add(Feature::Segment(22, 20, 21))});
  EXPECT_EQ(GetErrorDetail(across.status())->reason, reason::kSegmentsCross);
}

TEST(SpacePlc, PolygonsDoNotCross) {
  const EditBatch wall = {AddPoint3(20, 0.1, 0.5, 0.25), AddPoint3(21, 0.5, 0.5, 0.25),
                          AddPoint3(22, 0.5, 0.5, 0.75), AddPoint3(23, 0.1, 0.5, 0.75),
                          AddPolygon(24, {{20, 21, 22, 23}})};
  ExpectRefused(Plate() + wall, reason::kSegmentMeetsPolygon, {24, 10});
  // Along a line between two corners that they share.
  const EditBatch blade = {AddPoint3(20, 0.25, 0.25, 0.1), AddPoint3(21, 0.25, 0.25, 0.9),
                           AddPoint3(22, 0.75, 0.75, 0.1), AddPoint3(23, 0.75, 0.75, 0.9),
                           AddPolygon(24, {{1, 21, 23, 3, 22, 20}})};
  ExpectRefused(Plate() + blade, reason::kPolygonsMeet, {24, 10});
  ExpectRefused(blade + Plate(), reason::kPolygonsMeet, {10, 24});
}

TEST(SpacePlc, PolygonsDoNotOverlapInAPlane) {
  // On the same side of a common edge.
  ExpectRefused(Plate() + EditBatch{AddPoint3(20, 0.75, 0.5, 0.5), AddPoint3(21, 0.25, 0.5, 0.5),
                                    AddPolygon(24, {{1, 2, 20, 21}})},
                reason::kPointOnSegment, {20, 10});
  ExpectRefused(Plate() + EditBatch{AddPoint3(20, 0.75, 0.9, 0.5), AddPoint3(21, 0.25, 0.9, 0.5),
                                    AddPolygon(24, {{1, 2, 20, 21}})},
                reason::kSegmentsOverlap, {24, 10});
  ExpectRefused(Plate() + EditBatch{AddPolygon(24, {{1, 2, 3}})}, reason::kSegmentMeetsPolygon,
                {24, 10});
  ExpectRefused(Plate() + EditBatch{AddPoint3(20, 0.5, 0.7, 0.5), AddPolygon(24, {{1, 2, 20}})},
                reason::kPointOnPolygon, {20, 10});
  ExpectRefused(Plate() + Hole(0.1, 0.5, 20) + EditBatch{AddPolygon(24, {{20, 21, 22, 23}})},
                reason::kPointOnPolygon, {20, 10});
  // With holes: the outer edges are the same, the insides have something in common.
  EditBatch holed = Plate() + Hole(0.125, 0.5, 5);
  holed.push_back(Edit::Set(Feature::Polygon(10, {{1, 2, 3, 4}, {5, 6, 7, 8}})));
  holed = holed + Hole(0.0625, 0.5, 21);
  ExpectRefused(holed + EditBatch{AddPolygon(30, {{1, 2, 3, 4}, {21, 22, 23, 24}})},
                reason::kPointOnPolygon, {30, 5});
  ExpectRefused(holed + EditBatch{AddPolygon(30, {{5, 6, 7, 8}, {1, 2, 3, 4}})},
                reason::kDuplicatePolygon, {30, 10});
}

// One of several parts of each.
TEST(SpacePlc, PolygonsDoNotShareAPart) {
  EditBatch batch;
  const auto square = [&](FeatureId first, double x) {
    for (const auto& [u, v] : std::vector<std::pair<int, int>>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      batch.push_back(AddPoint3(first++, x + 0.1 * u, 0.1 * v, 0));
    }
  };
  square(1, 0.1);
  square(5, 0.4);
  square(9, 0.7);
  batch.push_back(AddPolygon(20, {{1, 2, 3, 4}, {5, 6, 7, 8}}));
  ExpectLegal(batch + EditBatch{AddPolygon(21, {{9, 10, 11, 12}})});
  ExpectRefused(batch + EditBatch{AddPolygon(21, {{9, 10, 11, 12}, {7, 6, 5, 8}})},
                reason::kPolygonsMeet, {21, 20});
}

// Two plates with a common edge at `degrees`.
EditBatch Wedge(double degrees) {
  const double a = degrees * std::numbers::pi / 180, c = 0.4 * std::cos(a), s = 0.4 * std::sin(a);
  return {AddPoint3(1, 0.5, 0.1, 0.5),         AddPoint3(2, 0.5, 0.9, 0.5),
          AddPoint3(3, 0.9, 0.9, 0.5),         AddPoint3(4, 0.9, 0.1, 0.5),
          AddPoint3(5, 0.5 + c, 0.9, 0.5 + s), AddPoint3(6, 0.5 + c, 0.1, 0.5 + s),
          AddPolygon(10, {{1, 2, 3, 4}}),      AddPolygon(11, {{1, 2, 5, 6}})};
}

TEST(SpacePlc, PolygonsMeetAtATwentiethOfADegreeOrMore) {
  for (const double angle :
       {0.0501, 0.5, 1.0, 20.0, 70.0, 90.0, 135.0, 180.0, 225.0, 340.0, 359.0, 359.9499}) {
    ExpectLegal(Wedge(angle));
  }
  for (const double angle : {0.001, 0.0499, 359.9501, 359.999}) {
    ExpectRefused(Wedge(angle), reason::kSmallAngle, {11, 10});
  }
  const auto delta = Plc3(Cube(0, 1)).Check(Wedge(0.0375));
  EXPECT_NE(std::string(delta.status().message())
                .find("polygon 11 and polygon 10 meet in an angle "
                      "of 0.0375 degrees; at least 0.05 are needed"),
            std::string::npos)
      << delta.status();
}

// Parallelograms over one edge that lean to both sides, so that their other edges are at 60
// degrees.
TEST(SpacePlc, PolygonsOnOneSideOfAnEdgeOverlapThoughTheyAreNotInOnePlane) {
  const double out = 0.2 * std::sqrt(0.75), up = 1e-8;
  ExpectRefused({AddPoint3(1, 0.5, 0.4, 0.5), AddPoint3(2, 0.5, 0.6, 0.5),
                 AddPoint3(3, 0.5 + out, 0.7, 0.5), AddPoint3(4, 0.5 + out, 0.5, 0.5),
                 AddPoint3(5, 0.5 + out, 0.5, 0.5 + up), AddPoint3(6, 0.5 + out, 0.3, 0.5 + up),
                 AddPolygon(10, {{1, 2, 3, 4}}), AddPolygon(11, {{1, 2, 5, 6}})},
                reason::kPolygonsMeet, {11, 10});
}

// An L, and a plate on the edge at its inner corner that leads away over the L's other part.
EditBatch Overhang(double degrees) {
  const double a = degrees * std::numbers::pi / 180;
  return {AddPoint3(1, 0.1, 0.1, 0.3),
          AddPoint3(2, 0.9, 0.1, 0.3),
          AddPoint3(3, 0.9, 0.9, 0.3),
          AddPoint3(4, 0.5, 0.9, 0.3),
          AddPoint3(5, 0.5, 0.5, 0.3),
          AddPoint3(6, 0.1, 0.5, 0.3),
          AddPolygon(10, {{1, 2, 3, 4, 5, 6}}),
          AddPoint3(7, 0.5 + 0.3 * std::cos(a), 0.5, 0.3 + 0.3 * std::sin(a)),
          AddPoint3(8, 0.5 + 0.3 * std::cos(a), 0.5, 0.9),
          AddPoint3(9, 0.1, 0.5, 0.9),
          AddPolygon(11, {{6, 5, 7, 8, 9}})};
}

TEST(SpacePlc, AnEdgeThatLeadsAwayFromACommonOneRisesAtAThousandthOfADegreeOrMore) {
  for (const double angle : {0.00101, 0.5, 20.0, 70.0, 90.0, 100.0}) ExpectLegal(Overhang(angle));
  for (const double angle : {0.0002, 0.0005, 0.00099}) {
    ExpectRefused(Overhang(angle), reason::kSmallAngle, {11, 10});
  }
}

// The same inside, as rings that cross in corners and as rings that touch there.
TEST(SpacePlc, AnglesAreThoseOfTheInsideHoweverItIsCutIntoRings) {
  // Over the edge from corner 2 to 3, by so much towards that side.
  const auto plate = [](double degrees, const Rings& rings) {
    const double a = degrees * std::numbers::pi / 180;
    const double y = 0.09 * std::cos(a), z = 0.5 + 0.09 * std::sin(a);
    return EditBatch{AddPoint3(1, 0.1, 0.1, 0.5),    AddPoint3(2, 0.5, 0.1, 0.5),
                     AddPoint3(3, 0.5, 0.3, 0.5),    AddPoint3(4, 0.5, 0.5, 0.5),
                     AddPoint3(5, 0.3, 0.5, 0.5),    AddPoint3(6, 0.1, 0.5, 0.5),
                     AddPoint3(7, 0.3, 0.3, 0.5),    AddPoint3(8, 0.7, 0.3, 0.5),
                     AddPoint3(9, 0.7, 0.7, 0.5),    AddPoint3(10, 0.3, 0.7, 0.5),
                     AddPolygon(20, rings),          AddPoint3(11, 0.1, 0.1 - y, z),
                     AddPoint3(12, 0.5, 0.1 - y, z), AddPolygon(21, {{1, 2, 12, 11}})};
  };
  const Rings crossing = {{1, 2, 3, 4, 5, 6}, {7, 3, 8, 9, 10, 5}};
  const Rings touching = {{1, 2, 3, 7, 5, 6}, {3, 8, 9, 10, 5, 4}};
  for (const Rings& rings : {crossing, touching}) {
    ExpectLegal(plate(100, rings));
    ExpectLegal(plate(45, rings));
    ExpectLegal(plate(179.949, rings));
    ExpectRefused(plate(179.951, rings), reason::kSmallAngle, {21, 20});
  }
}

TEST(SpacePlc, SegmentsRiseFromPolygonsAtAThousandthOfADegreeOrMore) {
  // From corner 1 in direction of the middle, at that height.
  const auto spike = [](double degrees) {
    const double a = degrees * std::numbers::pi / 180, along = 0.3 * std::cos(a) / std::sqrt(2);
    return Plate() + EditBatch{AddPoint3(20, 0.25 + along, 0.25 + along, 0.5 + 0.3 * std::sin(a)),
                               Edit::Add(Feature::Segment(21, 1, 20))};
  };
  ExpectLegal(spike(90));
  ExpectLegal(spike(0.00101));
  ExpectRefused(spike(0.00099), reason::kSmallAngle, {21, 10});
  // Away from the inside the angles to the edges count.
  ExpectLegal(spike(150));
  ExpectLegal(spike(180));
  // Right over an edge, too: at 63 degrees from it.
  ExpectLegal(Plate() +
              EditBatch{AddPoint3(20, 0.35, 0.25, 0.7), Edit::Add(Feature::Segment(21, 1, 20))});
}

TEST(SpacePlc, SegmentsMeetAtAThousandthOfADegreeOrMore) {
  const auto fork = [](double degrees) {
    const double a = degrees * std::numbers::pi / 180;
    return EditBatch{AddPoint3(1, 0.5, 0.5, 0.5), AddPoint3(2, 0.9, 0.5, 0.5),
                     AddPoint3(3, 0.5 + 0.3 * std::cos(a), 0.5, 0.5 + 0.3 * std::sin(a)),
                     Edit::Add(Feature::Segment(11, 1, 2)), Edit::Add(Feature::Segment(12, 1, 3))};
  };
  for (const double angle : {0.00101, 1.0, 59.9, 60.0, 180.0}) ExpectLegal(fork(angle));
  ExpectRefused(fork(0.00099), reason::kSmallAngle, {12, 11});
  ExpectRefused(fork(0), reason::kPointOnSegment, {11, 3});
  // An edge of a polygon is a segment.
  const auto needle = [](double degrees) {
    const double a = degrees * std::numbers::pi / 180;
    return EditBatch{AddPoint3(1, 0, 0, 0), AddPoint3(2, 1, 0, 0),
                     AddPoint3(3, 0.75 * std::cos(a), 0.75 * std::sin(a), 0),
                     AddPolygon(9, {{1, 2, 3}})};
  };
  for (const double angle : {0.00101, 1.0, 45.0}) ExpectLegal(needle(angle));
  ExpectRefused(needle(0.00099), reason::kSmallAngle, {9, 9});
}

// Triangles with a common edge from point 1 to 2. At point 1 they have the angles `low`, in the
// plane z = 0.5, and `up`; they meet at `between`. In degrees.
EditBatch Leaf(double between, double low, double up) {
  const auto at = [](double degrees) { return degrees * std::numbers::pi / 180; };
  const double d = 0.3 * std::sin(at(up));
  return {AddPoint3(1, 0.5, 0.5, 0.5),
          AddPoint3(2, 0.8, 0.5, 0.5),
          AddPoint3(3, 0.5 + 0.3 * std::cos(at(low)), 0.5 + 0.3 * std::sin(at(low)), 0.5),
          AddPoint3(4, 0.5 + 0.3 * std::cos(at(up)), 0.5 + d * std::cos(at(between)),
                    0.5 + d * std::sin(at(between))),
          AddPolygon(10, {{1, 2, 3}}),
          AddPolygon(11, {{1, 2, 4}})};
}

TEST(SpacePlc, AnEdgeMayLeanOverAnotherPolygon) {
  for (const double between : {20.5, 45.0, 72.0, 85.0, 90.0, 135.0}) {
    for (const double low : {40.0, 80.0, 119.0}) {
      for (const double up : {0.01, 1.0, 30.0, 60.0}) ExpectLegal(Leaf(between, low, up));
    }
  }
}

TEST(SpacePlc, SegmentsPassEachOtherAtTheCloseLimit) {
  const double limit = CloseLimit(Cube(0, 1));
  const auto cross = [](double gap) {
    return EditBatch{AddPoint3(1, 0.1, 0.2, 0.5),           AddPoint3(2, 0.9, 0.7, 0.5),
                     AddPoint3(3, 0.1, 0.8, 0.5 + gap),     AddPoint3(4, 0.9, 0.3, 0.5 + gap),
                     Edit::Add(Feature::Segment(11, 1, 2)), Edit::Add(Feature::Segment(12, 3, 4))};
  };
  ExpectRefused(cross(0), reason::kSegmentsCross, {12, 11});
  ExpectRefused(cross(limit / 2), reason::kTooClose, {12, 11});
  ExpectLegal(cross(2 * limit));
}

TEST(SpacePlc, SaysWhereThingsMeet) {
  const auto message = [](const EditBatch& batch) {
    return std::string(Plc3(Cube(0, 1)).Check(batch).status().message());
  };
  const std::string cross =
      message({AddPoint3(1, 0.125, 0.25, 0.5), AddPoint3(2, 0.875, 0.75, 0.5),
               AddPoint3(3, 0.125, 0.75, 0.5), AddPoint3(4, 0.875, 0.25, 0.5),
               Edit::Add(Feature::Segment(11, 1, 2)), Edit::Add(Feature::Segment(12, 3, 4))});
  EXPECT_NE(cross.find(" cross at (0.5, 0.5, 0.5); add a point there and split both, or remove "),
            std::string::npos)
      << cross;
  const std::string through =
      message(Plate() + EditBatch{AddPoint3(31, 0.375, 0.5, 0.25), AddPoint3(32, 0.5, 0.375, 0.75),
                                  Edit::Add(Feature::Segment(33, 31, 32))});
  EXPECT_NE(through.find(" in the inside of the polygon at (0.4375, 0.4375, 0.5); cut "),
            std::string::npos)
      << through;
  // Along the plane there is no one place.
  const std::string along = message(Plate() + EditBatch{Edit::Add(Feature::Segment(33, 1, 3))});
  EXPECT_NE(along.find(" meet in the inside of the polygon; cut "), std::string::npos) << along;
}

TEST(SpacePlc, BadFeaturesAreNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ExpectRefused({AddPoint3(1, 0.5, 0.5, nan)}, reason::kNotFinite, {1});
  ExpectRefused({AddPoint3(1, 0.5, 0.5, 1.5)}, reason::kOutsideBox, {1});
  EditBatch bad = Plate();
  bad[2] = AddPoint3(3, 0.75, 0.75, nan);
  ExpectRefused(bad, reason::kNotFinite, {3});
  ExpectRefused({AddPoint3(1, 0.5, 0.5, 0.5), AddPolygon(4, {{1, 2, 3}})}, reason::kUnknownEnd,
                {4, 2, 3});
  Plc3 plc(Cube(0, 1));
  Apply(plc, Plate());
  ExpectRefused(plc, {Edit::Remove(3)}, reason::kPointInUse, {3, 10});
  ExpectRefused(plc, {Edit::Add(Feature::SizePolygon(20, {{1, 2, 3}}, 0.1))}, reason::kBadSize,
                {20});
  Apply(plc, {Edit::Add(Feature::Size(20, {0.1, 0.2, 0.3}, {SizeShape::kBox, 0.1, 0, {1, 1, 1}}))});
  EXPECT_EQ(plc.store().FindSize(20)->at, (geometry::Point3{{0.1, 0.2, 0.3}}));
  const auto capsule = [](const Path& path, double radius) {
    return Edit::Add(Feature::SizeCapsule(21, path, radius, 0.1));
  };
  const Path line = {{0.1, 0.2, 0.3}, {0.1, 0.2, 0.4}};
  ExpectRefused(plc, {capsule({line[0], line[0]}, 0.1)}, reason::kBadSize, {21});
  ExpectRefused(plc, {capsule({line[0], {0.1, 0.2, 1.5}}, 0.1)}, reason::kOutsideBox, {21});
  ExpectRefused(plc, {capsule({line[0], {0.1, 0.2, nan}}, 0.1)}, reason::kNotFinite, {21});
  ExpectRefused(plc, {capsule(line, -0.1)}, reason::kBadSize, {21});
  Apply(plc, {capsule(line, 1.8)});
  EXPECT_EQ(plc.store().FindSize(21)->sizing.path, line);
}

TEST(SpacePlc, FacetsComeAndGoWithPolygonsAndFollowTheirCorners) {
  Plc3 plc(Cube(0, 1));
  const Delta<3> first = Apply(plc, Plate());
  ASSERT_EQ(first.added_facets.size(), 1u);
  EXPECT_EQ(first.added_facets[0].rings, (Rings{{1, 2, 3, 4}}));
  EXPECT_EQ(first.added_facets[0].positions[0][2], (geometry::Point3{{0.75, 0.75, 0.5}}));
  EXPECT_EQ(first.added_segments.size(), 4u);
  const Delta<3> moved = Apply(plc, {Edit::Move(3, 0.8, 0.8, 0.5)});
  EXPECT_EQ(moved.removed_facets, first.added_facets);
  ASSERT_EQ(moved.added_facets.size(), 1u);
  EXPECT_EQ(moved.added_facets[0].positions[0][2], (geometry::Point3{{0.8, 0.8, 0.5}}));
  EXPECT_TRUE(moved.added_polygons.empty());
  EXPECT_EQ(plc.FromNothing().added_facets, moved.added_facets);
  // The index follows.
  EXPECT_FALSE(plc.Check({AddPoint3(20, 0.77, 0.77, 0.5)}).ok());
  plc.Apply(moved.Inverse());
  EXPECT_TRUE(plc.Check({AddPoint3(20, 0.77, 0.77, 0.5)}).ok());
  EXPECT_EQ(plc.FromNothing(), first);
  // Another ring, another facet.
  const Delta<3> ring = Apply(plc, {Edit::Set(Feature::Polygon(10, {{4, 3, 2, 1}}))});
  EXPECT_EQ(ring.removed_facets.size(), 1u);
  EXPECT_EQ(ring.added_facets[0].rings, (Rings{{4, 3, 2, 1}}));
  const Delta<3> gone = Apply(plc, {Edit::Remove(10)});
  EXPECT_EQ(gone.removed_facets, ring.added_facets);
  EXPECT_TRUE(plc.Check({AddPoint3(20, 0.5, 0.5, 0.5)}).ok());
}

}  // namespace
}  // namespace dynmesh::plc::space_plc_test
