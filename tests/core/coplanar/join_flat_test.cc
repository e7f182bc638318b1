// Joining rounded faces, and its parts, in single cases.
#include "core/coplanar/join_flat.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <vector>

#include "core/coplanar/coplanar_regions.h"
#include "core/coplanar/cut_face.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/flatten.h"
#include "core/coplanar/flatten_system.h"
#include "core/coplanar/lone_faces.h"
#include "core/coplanar/needles.h"
#include "core/coplanar/plane_fit.h"
#include "core/geometry/circumball.h"
#include "core/geometry/point.h"
#include "core/geometry/space_predicates.h"
#include "dynmesh/feature.h"

namespace dynmesh::coplanar::join_flat_test {
namespace {

using geometry::Point3;
using geometry::Vector3;

std::vector<Vector3> Alike(std::size_t n, double rounding) {
  return std::vector<Vector3>(n, Vector3{rounding, rounding, rounding});
}

double WorstHeight(const FaceRings& rings, const std::vector<Point3>& positions) {
  std::vector<Point3> corners;
  PointRing ring;
  for (const Corner c : rings.front()) ring.push_back(positions[c]);
  const PlaneFit plane(ring, AreaVector(ring));
  double worst = 0;
  for (const Point3& p : ring) worst = std::max(worst, std::abs(plane.Height(p)));
  return worst;
}

// ---- planes

TEST(PlaneFit, LiesBetweenItsCorners) {
  const std::vector<Point3> corners = {Point3{{0, 0, 1}}, Point3{{0, 2, 0}}, Point3{{2, 0, 0}},
                                       Point3{{2, 2, 1}}};
  const PlaneFit plane(corners, {0, 0, 3});
  EXPECT_EQ(plane.normal(), (Vector3{0, 0, 1}));
  EXPECT_DOUBLE_EQ(plane.Height({{1, 1, 0.5}}), 0);
  EXPECT_DOUBLE_EQ(plane.Height({{7, -3, 2}}), 1.5);
  // In the middle of four corners half of one's error; far away more, up to a bound.
  EXPECT_DOUBLE_EQ(plane.ErrorAt({{1, 1, 0}}), 0.5);
  EXPECT_LT(plane.ErrorAt({{2, 2, 0}}), 1);
  EXPECT_EQ(plane.ErrorAt({{1000, 0, 0}}), 4);
}

TEST(PlaneFit, GoesThroughCornersThatAreExact) {
  const std::vector<Point3> corners = {Point3{{0, 0, 1}}, Point3{{0, 2, 0}}, Point3{{2, 0, 0}},
                                       Point3{{2, 2, 0}}};
  const PlaneFit plane(corners, {0, 0, 1}, {1, 1e-4, 1e-4, 1e-4});
  for (const std::size_t i : {1, 2, 3}) EXPECT_LT(std::abs(plane.Height(corners[i])), 1e-7);
  EXPECT_NEAR(plane.Height(corners[0]), 1, 1e-6);
}

TEST(PlaneFit, RoundingsCountAlongTheNormal) {
  EXPECT_DOUBLE_EQ(RoundingAlong({0, -1, 0}, {1, 2, 4}), 2);
  EXPECT_EQ(RoundingsAlong({0, 0, 5}, {1, 0}, {{1, 2, 4}, {3, 3, 3}}), (std::vector<double>{3, 4}));
}

// ---- flattening

TEST(Flatten, CornersMoveLeastOntoAPlane) {
  std::vector<Point3> at = {Point3{{0, 0, 0}}, Point3{{0, 1, 1}}, Point3{{1, 0, 0}},
                            Point3{{1, 1, 1 + 4e-6}}};
  const std::vector<Point3> before = at;
  EXPECT_TRUE(Flatten({{{0, 1, 3, 2}}}, Alike(4, 1e-6), at).empty());
  EXPECT_LT(WorstHeight({{0, 1, 3, 2}}, at), 1e-15);
  for (std::size_t c = 0; c < 4; ++c) {
    const double moved = std::sqrt(geometry::SquaredDistance(at[c], before[c]));
    EXPECT_NEAR(moved, 1e-6 / std::sqrt(2), 1e-9);
  }
}

TEST(Flatten, WhatWouldMoveFartherIsReturnedAndNothingMoves) {
  std::vector<Point3> at = {Point3{{0, 0, 0}}, Point3{{0, 1, 1}}, Point3{{1, 0, 0}},
                            Point3{{1, 1, 1.001}}};
  const std::vector<Point3> before = at;
  EXPECT_EQ(Flatten({{{0, 1, 3, 2}}}, Alike(4, 1e-6), at), std::vector<std::size_t>{0});
  EXPECT_EQ(at, before);
}

// A box whose one wall leans and is off its plane: floor, ceiling and the other walls stay exact.
TEST(Flatten, ExactPlanesStayExact) {
  std::vector<Point3> at = {Point3{{-8e-11, 1, 2}}, Point3{{-2e-12, 1, 0}}, Point3{{0.2, -1, 0}},
                            Point3{{0.2, -1, 2}},   Point3{{3, -1, 0}},     Point3{{3, -1, 2}},
                            Point3{{3, 1, 0}},      Point3{{3, 1, 2}}};
  const std::vector<FaceRings> patches = {{{0, 1, 2, 3}}, {{0, 1, 6, 7}}, {{0, 3, 5, 7}},
                                          {{1, 2, 4, 6}}, {{2, 3, 5, 4}}, {{4, 5, 7, 6}}};
  EXPECT_TRUE(Flatten(patches, Alike(8, 1e-7), at).empty());
  EXPECT_LT(WorstHeight(patches[0], at), 1e-15);
  for (const Corner c : {0, 1, 6, 7}) EXPECT_EQ(at[c][1], 1);
  for (const Corner c : {2, 3, 4, 5}) EXPECT_EQ(at[c][1], -1);
  for (const Corner c : {1, 2, 4, 6}) EXPECT_EQ(at[c][2], 0);
  for (const Corner c : {0, 3, 5, 7}) EXPECT_EQ(at[c][2], 2);
  for (const Corner c : {4, 5, 6, 7}) EXPECT_EQ(at[c][0], 3);
}

TEST(Flatten, APlaneOfOneCoordinateGetsItsValue) {
  std::vector<Point3> at = {Point3{{0, 0, 5}}, Point3{{0, 1, 5.000001}}, Point3{{1, 0, 5}},
                            Point3{{1, 1, 4.999999}}};
  EXPECT_TRUE(Flatten({{{0, 1, 3, 2}}}, Alike(4, 1e-6), at).empty());
  for (const Point3& p : at) EXPECT_EQ(p[2], 5);
}

// Two squares at a common edge, one of them exact. If it stays so, the other cannot be flat.
TEST(Flatten, AnExactPlaneMovesWhereOthersNeedIt) {
  std::vector<Point3> at = {Point3{{0, 0, 0}},          Point3{{0, 1, 0}}, Point3{{1, 0, 0}},
                            Point3{{1, 1, 0}},          Point3{{2, 0, 1}}, Point3{{2, 1, 1 + 9e-6}},
                            Point3{{2.5, 0.5, 1.5 + 0}}};
  const std::vector<FaceRings> patches = {{{0, 1, 3, 2}}, {{2, 3, 5, 4}}};
  EXPECT_TRUE(Flatten(patches, Alike(7, 1e-6), at).empty());
  for (const FaceRings& patch : patches) EXPECT_LT(WorstHeight(patch, at), 1e-14);
}

// Patches of different slopes and a common corner that stays: each takes a step or two of its own
// corners.
TEST(Flatten, PatchesThatDoNotDependOnEachOtherAreSolvedApart) {
  constexpr std::size_t kPatches = 200;
  std::vector<Vector3> weights(1 + 3 * kPatches, Vector3{1, 1, 1});
  weights[0] = {1, 1, 0};
  FlattenSystem system(weights);
  const auto off = [](std::size_t p) { return 1e-3 * static_cast<double>(p + 1); };
  for (std::size_t p = 0; p < kPatches; ++p) {
    const std::size_t c = 1 + 3 * p;
    system.AddPatch({0, 0, 1},
                    {{0, 0, 0, 0}, {c, 0, 1, 0}, {c + 1, 1, 0, 0}, {c + 2, 1, 1, off(p)}},
                    1 + 0.1 * static_cast<double>(p), /*fixed=*/false);
  }
  const std::vector<Vector3> motions = system.Solve(1e-12, 400);
  for (std::size_t p = 0; p < kPatches; ++p) {
    const std::size_t c = 1 + 3 * p;
    EXPECT_NEAR(motions[c + 2][2] + off(p), motions[c][2] + motions[c + 1][2], 1e-11);
    EXPECT_NEAR(motions[c][2], off(p) / 3, 1e-11);  // they move least
  }
  EXPECT_EQ(motions[0], (Vector3{0, 0, 0}));
  EXPECT_LE(system.taken(), 3 * system.size());
}

// ---- faces

TEST(LoneFaces, AreThoseThatTurnAway) {
  const std::vector<Point3> at = {Point3{{0, 0, 0}}, Point3{{0, 1, 0}}, Point3{{1, 0, 0}},
                                  Point3{{1, 1, 1e-6}}, Point3{{2, 0, 0.5}}};
  const std::vector<CornerRing> faces = {{0, 1, 2}, {1, 2, 3}, {2, 3, 4}, {}};
  EXPECT_EQ(LoneFaces(at, Alike(5, 1e-6), faces), (std::vector<bool>{false, false, true, true}));
  EXPECT_EQ(LoneFaces(at, Alike(5, 1e-9), faces), (std::vector<bool>{true, true, true, true}));
}

TEST(Needles, GiveTheirCornerToTheLongEdge) {
  // By coordinates: the ends, and between them a corner that is nearly on the line.
  const std::vector<Point3> at = {Point3{{0, 0, 0}}, Point3{{1, 1e-7, 0}}, Point3{{1, 2, 0}},
                                  Point3{{2, 0, 0}}};
  std::vector<CornerRing> rings = {{0, 1, 3}, {0, 3, 2}};
  const std::vector<CornerRing> before = rings;
  EXPECT_EQ(DropNeedles(
                at, [](Corner) { return 1e-8; }, {}, rings),
            0U);
  EXPECT_EQ(rings, before);
  // Not if a segment lies on the long edge.
  EXPECT_EQ(DropNeedles(
                at, [](Corner) { return 1e-6; }, {{0, 3}}, rings),
            0U);
  EXPECT_EQ(DropNeedles(
                at, [](Corner) { return 1e-6; }, {}, rings),
            1U);
  EXPECT_EQ(rings, (std::vector<CornerRing>{{}, {0, 1, 3, 2}}));
}

TEST(CutFace, TakesTheEarsWithTheLargestAngles) {
  // A notch: the only cuts are between its corner and the two at the far side.
  const std::vector<Point3> at = {Point3{{0, 0, 0}}, Point3{{0, 4, 0.1}}, Point3{{1, 2, 0}},
                                  Point3{{4, 0, 0}}, Point3{{4, 4, 0}}};
  const std::vector<CornerRing> cut = CutFace(at, {0, 2, 1, 4, 3});
  ASSERT_EQ(cut.size(), 3U);
  double area = 0;
  for (const CornerRing& triangle : cut) {
    EXPECT_NE(std::set<Corner>(triangle.begin(), triangle.end()), (std::set<Corner>{0, 1, 2}));
    const Vector3 vector = AreaVector({at[triangle[0]], at[triangle[1]], at[triangle[2]]});
    area += std::abs(vector[2]) / 2;
  }
  EXPECT_DOUBLE_EQ(area, 14);
  EXPECT_EQ(CutFace(at, {3, 4, 1, 2, 0}).size(), 3U);
  EXPECT_TRUE(CutFace(at, {0, 1, 2}).empty());
}

// ---- all of it

std::vector<Feature> Points(const std::vector<std::array<double, 3>>& places) {
  std::vector<Feature> features;
  for (const auto& [x, y, z] : places) {
    features.push_back(Feature::Point(features.size() + 1, x, y, z));
  }
  return features;
}

void Add(std::vector<Feature>& features, const std::vector<FeatureId>& ring) {
  features.push_back(Feature::Polygon(features.size() + 1, {ring}));
}

std::map<FeatureId, Rings> PolygonsOf(const JoinedFaces& joined) {
  std::map<FeatureId, Rings> polygons;
  for (const Feature& f : joined.features) {
    if (f.kind == FeatureKind::kPolygon) polygons[f.id] = f.rings;
  }
  return polygons;
}

JoinOptions Within(double rounding) {
  JoinOptions options;
  options.rounding = [rounding](double) { return rounding; };
  return options;
}

// Two triangles of a square that is off its plane by 2e-6, and a third on one of its edges.
std::vector<Feature> Square() {
  std::vector<Feature> features =
      Points({{0, 0, 0}, {0, 1, 0.5}, {1, 0, 0}, {1, 1, 0.5 + 2e-6}, {0.5, 2, 2}});
  Add(features, {1, 2, 4});
  Add(features, {1, 4, 3});
  Add(features, {2, 4, 5});
  return features;
}

TEST(JoinFlat, FacesWithinTheRoundingBecomeOne) {
  const JoinedFaces joined = JoinFlat(Square(), Within(1e-6));
  EXPECT_EQ(joined.joined, 2U);
  EXPECT_EQ(joined.polygons, 1U);
  EXPECT_EQ(joined.moved, 4U);
  EXPECT_GT(joined.most_moved, 0.3e-6);
  EXPECT_LT(joined.most_moved, 1e-6);
  const auto polygons = PolygonsOf(joined);
  ASSERT_EQ(polygons.size(), 2U);
  EXPECT_EQ(polygons.at(6).front().size(), 4U);
  EXPECT_EQ(JoinFlat(Square(), Within(1e-8)).joined, 0U);
}

// At the ends of what predicates take: the same, scaled.
TEST(JoinFlat, TheUnitDoesNotMatter) {
  const JoinedFaces usual = JoinFlat(Square(), Within(0x1p-20));
  for (const double scale : {0x1p190, 0x1p-170}) {
    std::vector<Feature> features = Square();
    for (Feature& f : features) {
      for (double& x : f.position) x *= scale;
    }
    const JoinedFaces joined = JoinFlat(features, Within(0x1p-20 * scale));
    EXPECT_EQ(PolygonsOf(joined), PolygonsOf(usual));
    EXPECT_EQ(joined.moved, usual.moved);
    EXPECT_DOUBLE_EQ(joined.most_moved, usual.most_moved * scale);
  }
}

TEST(JoinFlat, OfTwoGroupsTheyDoNot) {
  JoinOptions options = Within(1e-6);
  options.group = [](FeatureId id) { return id == 7 ? 1 : 0; };
  EXPECT_EQ(JoinFlat(Square(), options).joined, 0U);
  options.group = [](FeatureId id) { return id == 8 ? 1 : 0; };
  EXPECT_EQ(JoinFlat(Square(), options).joined, 2U);
}

TEST(JoinFlat, WhatIsInConflictStaysAsItWas) {
  JoinOptions options = Within(1e-6);
  std::size_t asked = 0;
  options.conflicts = [&](const std::vector<Feature>& features, const auto& is_looked_at,
                          const auto& is_new, const auto& found) {
    ++asked;
    for (const Feature& f : features) {
      if (f.kind != FeatureKind::kPolygon || f.rings.front().size() == 3) continue;
      EXPECT_TRUE(is_looked_at(f.id));
      EXPECT_TRUE(is_new(f.id));
      found(f.id);
    }
  };
  const std::vector<Feature> features = Square();
  const JoinedFaces joined = JoinFlat(features, options);
  EXPECT_EQ(joined.features, features);
  EXPECT_EQ(joined.joined, 0U);
  EXPECT_EQ(joined.moved, 0U);
  EXPECT_EQ(asked, 1U);
}

// A triangle is blamed for a corner that the square has moved.
TEST(JoinFlat, WhatHoldsAMovedCornerIsLetGo) {
  JoinOptions options = Within(1e-6);
  options.conflicts = [&](const std::vector<Feature>&, const auto& is_looked_at, const auto&,
                          const auto& found) {
    if (is_looked_at(8)) found(8);
  };
  const std::vector<Feature> features = Square();
  EXPECT_EQ(JoinFlat(features, options).features, features);
}

TEST(JoinFlat, ConflictsThatDoNotEndLeaveAllAsItWas) {
  std::vector<Feature> features = Square();
  // A needle, within the rounding of a line.
  features.push_back(Feature::Point(20, 0.5, 1e-7, 0));
  features.push_back(Feature::Polygon(21, {{1, 3, 20}}));
  JoinOptions options = Within(1e-6);
  EXPECT_EQ(JoinFlat(features, options).needles, 1U);
  options.conflicts = [&](const std::vector<Feature>& all, const auto& is_looked_at, const auto&,
                          const auto& found) {
    for (const Feature& f : all) {
      if (is_looked_at(f.id)) found(f.id);
    }
  };
  const JoinedFaces joined = JoinFlat(features, options);
  EXPECT_EQ(PolygonsOf(joined).size(), 4U);
  EXPECT_EQ(joined.needles, 0U);
  EXPECT_EQ(joined.moved, 0U);
}

// What has not changed since the round before is not judged again.
TEST(JoinFlat, OfALaterRoundOnlyWhatIsNewIsJudged) {
  std::vector<Feature> features = Square();
  for (const Feature& f : Square()) {  // another one, far away
    Feature other = f;
    other.id += 100;
    other.position[0] += 10;
    for (auto& ring : other.rings) {
      for (FeatureId& id : ring) id += 100;
    }
    features.push_back(std::move(other));
  }
  JoinOptions options = Within(1e-6);
  int round = 0;
  options.conflicts = [&](const std::vector<Feature>& all, const auto& is_looked_at,
                          const auto& is_new, const auto& found) {
    ++round;
    for (const Feature& f : all) {
      if (f.kind != FeatureKind::kPolygon || f.rings.front().size() == 3) continue;
      EXPECT_TRUE(is_looked_at(f.id));
      EXPECT_EQ(is_new(f.id), round == 1) << f.id;
      if (f.id < 100) found(f.id);
    }
    // The faces of the square that is let go.
    if (round == 2) {
      EXPECT_TRUE(is_new(7));
    }
  };
  EXPECT_EQ(JoinFlat(features, options).polygons, 1U);
  EXPECT_EQ(round, 2);
}

TEST(JoinFlat, NothingIsJudgedIfAllIsAccepted) {
  JoinOptions options = Within(1e-6);
  int asked = 0, judged = 0;
  bool is_accepted = true;
  options.accepts = [&](const std::vector<Feature>&) { return ++asked, is_accepted; };
  options.conflicts = [&](const auto&, const auto&, const auto&, const auto&) { ++judged; };
  const JoinedFaces joined = JoinFlat(Square(), options);
  EXPECT_TRUE(joined.is_accepted);
  EXPECT_EQ(joined.polygons, 1U);
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(judged, 0);
  is_accepted = false;
  EXPECT_FALSE(JoinFlat(Square(), options).is_accepted);
  EXPECT_EQ(asked, 2);
  EXPECT_EQ(judged, 1);
}

TEST(JoinFlat, WithoutJoiningOnlyWhatIsNotFlatIsCut) {
  std::vector<Feature> features = Square();
  Add(features, {1, 3, 4, 5});
  JoinOptions options = Within(1e-6);
  options.join = false;
  const JoinedFaces kept = JoinFlat(features, options);
  EXPECT_EQ(kept.cut, 1U);
  EXPECT_EQ(kept.moved, 0U);
  EXPECT_EQ(PolygonsOf(kept).size(), 5U);
  ASSERT_EQ(kept.parts.size(), 1U);
  EXPECT_EQ(kept.parts.front().second, 9U);
}

}  // namespace
}  // namespace dynmesh::coplanar::join_flat_test
