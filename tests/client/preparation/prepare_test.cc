#include "client/preparation/prepare.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/preparation/farthest.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "gtest/gtest.h"
#include "tests/client/preparation/solids.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::preparation {
namespace {

using test::BoxSolid;
using test::CrackedBox;
using test::Solid;

class PrepareTest : public ::testing::Test {
 protected:
  Prepared Of(const std::string& name, const std::string& text, PrepareOptions options = {}) {
    io::GeometryOptions reading;
    reading.polygons = true;
    absl::StatusOr<Prepared> prepared = Prepare(folder_.Write(name, text), reading, options);
    EXPECT_TRUE(prepared.ok()) << prepared.status();
    return prepared.ok() ? *std::move(prepared) : Prepared();
  }
  absl::StatusOr<Mesh> MeshOf(const Prepared& prepared) {
    return BuildMesh(prepared.geometry.features, prepared.geometry.options);
  }
  static std::size_t Count(const Prepared& prepared, FeatureKind kind) {
    return static_cast<std::size_t>(
        std::ranges::count(prepared.geometry.features, kind, &Feature::kind));
  }

  test::TempFolder folder_;
};

TEST_F(PrepareTest, WhatAMeshAcceptsStaysAsItIsRead) {
  const std::string off = BoxSolid({0, 0, 0}, {1, 2, 3}).Off();
  const Prepared prepared = Of("box.off", off);
  EXPECT_FALSE(prepared.report.is_mended);
  EXPECT_TRUE(prepared.report.found.ok());
  EXPECT_EQ(prepared.report.open_edges, 0U);
  EXPECT_EQ(prepared.geometry.features, io::ReadGeometry(folder_.Path("box.off"))->features);
}

TEST_F(PrepareTest, ShellsThatCrossBecomeOneInput) {
  Solid solid = BoxSolid({0, 0, 0}, {1, 1, 1});
  solid.Add(BoxSolid({0.3, 0.4, 0.5}, {1.5, 1.6, 1.7}));
  const Prepared prepared = Of("boxes.off", solid.Off());
  EXPECT_TRUE(prepared.report.is_mended);
  EXPECT_FALSE(prepared.report.found.ok());
  EXPECT_LE(prepared.report.farthest, 1e-9);
  EXPECT_EQ(prepared.report.open_edges_after, 0U);
  EXPECT_TRUE(MeshOf(prepared).ok());
  // Each box has three faces that the other one cuts: 12 polygons, 6 of which have a part within.
  EXPECT_EQ(Count(prepared, FeatureKind::kPolygon), 18U);
}

TEST_F(PrepareTest, ACrackIsClosedWithinTheDistance) {
  for (const double gap : {1e-9, 1e-7, 1e-6, 3e-5}) {
    const Prepared prepared = Of("crack.off", CrackedBox(gap).Off());
    EXPECT_TRUE(prepared.report.is_mended) << gap;
    EXPECT_EQ(prepared.report.open_edges, 8U) << gap;
    EXPECT_EQ(prepared.report.open_edges_after, 0U) << gap;
    EXPECT_GE(prepared.report.farthest, gap / 2);
    EXPECT_LE(prepared.report.farthest, prepared.report.within);
    EXPECT_TRUE(MeshOf(prepared).ok()) << gap;
  }
}

TEST_F(PrepareTest, AWiderCrackStaysUnlessTheDistanceAllowsIt) {
  const std::string off = CrackedBox(0.01).Off();
  const Prepared stays = Of("crack.off", off);
  EXPECT_FALSE(stays.report.is_mended);
  EXPECT_EQ(stays.report.open_edges_after, 8U);
  const Prepared closed = Of("crack.off", off, {0.05});
  EXPECT_TRUE(closed.report.is_mended);
  EXPECT_EQ(closed.report.open_edges_after, 0U);
  EXPECT_LE(closed.report.farthest, 0.05);
}

TEST_F(PrepareTest, NeedlesOfAFanBecomeOneEdge) {
  // Three points of the ring are seen from the tips at less than 0.001 degrees.
  const Solid solid = test::DoublePyramid(
      {{1, 0}, {0.2, 1}, {0.2 - 1e-5, 1}, {0.2 - 2.2e-5, 1 - 1e-6}, {-1, -0.5}});
  const Prepared prepared = Of("needles.off", solid.Off());
  ASSERT_FALSE(prepared.report.found.ok());
  EXPECT_TRUE(prepared.report.is_mended);
  EXPECT_EQ(prepared.report.open_edges_after, 0U);
  EXPECT_LE(prepared.report.farthest, prepared.report.within);
  const auto mesh = MeshOf(prepared);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_LT(mesh->vertices.size(), 2000U);
}

TEST_F(PrepareTest, FacesThatAreNotFlatAreComparedAsTheyAreCut) {
  // A cut along the other diagonal is farther away than may be. (Few digits mean large roundings.)
  const std::string box =
      "OFF\n16 12 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1.1\n0 1 1\n"
      "0.20000000000001 0.20000000000001 0.5\n0.40000000000001 0.20000000000001 "
      "0.5\n0.40000000000001 0.40000000000001 0.5\n0.20000000000001 0.40000000000001 0.5\n"
      "0.20000000000001 0.20000000000001 2\n0.40000000000001 0.20000000000001 2\n0.40000000000001 "
      "0.40000000000001 2\n0.20000000000001 0.40000000000001 2\n"
      "4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n"
      "4 11 10 9 8\n4 12 13 14 15\n4 8 9 13 12\n4 9 10 14 13\n4 10 11 15 14\n4 11 8 12 15\n";
  const Prepared prepared = Of("boxes.off", box);
  EXPECT_TRUE(prepared.report.is_mended);
  EXPECT_LE(prepared.report.farthest, 1e-6);
  EXPECT_TRUE(MeshOf(prepared).ok());
}

TEST_F(PrepareTest, AnOpenSurfaceStaysOpen) {
  Solid solid = BoxSolid({0, 0, 0}, {1, 1, 1});
  solid.faces.resize(10);
  const Prepared prepared = Of("open.off", solid.Off());
  EXPECT_FALSE(prepared.report.is_mended);
  EXPECT_EQ(prepared.report.open_edges, 4U);
}

TEST_F(PrepareTest, DoesNotDependOnTheOrderOfFaces) {
  Solid solid = BoxSolid({0, 0, 0}, {1, 1, 1});
  solid.Add(BoxSolid({0.3, 0.4, 0.5}, {1.5, 1.6, 1.7}));
  const auto places = [](const Prepared& prepared) {
    std::map<FeatureId, std::array<double, 3>> at;
    std::set<std::set<std::array<double, 3>>> polygons;
    for (const Feature& f : prepared.geometry.features) {
      if (f.kind == FeatureKind::kPoint) at[f.id] = f.position;
    }
    for (const Feature& f : prepared.geometry.features) {
      if (f.kind != FeatureKind::kPolygon) continue;
      std::set<std::array<double, 3>> corners;
      for (const auto& ring : f.rings) {
        for (const FeatureId id : ring) corners.insert(at.at(id));
      }
      polygons.insert(corners);
    }
    return polygons;
  };
  const auto before = places(Of("a.off", solid.Off()));
  std::ranges::reverse(solid.faces);
  for (auto& face : solid.faces) std::ranges::rotate(face, face.begin() + 1);
  EXPECT_EQ(places(Of("b.off", solid.Off())), before);
}

TEST_F(PrepareTest, ADistanceMustBePositive) {
  const std::string path = folder_.Write("box.off", BoxSolid({0, 0, 0}, {1, 1, 1}).Off());
  for (const double within : {0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    const auto status = Prepare(path, {}, {within}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(status.message().find("--within"), std::string::npos);
  }
}

TEST_F(PrepareTest, FacetsOfTetGenAreMendedOnRequest) {
  // Two squares that cross.
  const std::string poly =
      "8 3 0 0\n1 0 0 0\n2 2 0 0\n3 2 2 0\n4 0 2 0\n5 1 1 -1\n6 3 1 -1\n7 3 1 1\n8 1 1 1\n"
      "2 0\n1 0\n4 1 2 3 4\n1 0\n4 5 6 7 8\n0\n";
  const Prepared as_is = Of("squares.poly", poly);
  EXPECT_FALSE(as_is.report.is_mended);
  EXPECT_FALSE(MeshOf(as_is).ok());
  const Prepared mended = Of("squares.poly", poly, {1e-6});
  EXPECT_TRUE(mended.report.is_mended);
  EXPECT_TRUE(MeshOf(mended).ok());
}

TEST_F(PrepareTest, AScriptOfAnyExtensionIsMendedOnRequest) {
  io::GeometryOptions reading;
  reading.any_script = true;
  const std::string path =
      folder_.Write("cross.edits",
                    "mesh dim=2 box=0,0,4,4\nadd point 1 1 1\nadd point 2 3 3\nadd point 3 3 1\n"
                    "add point 4 1 3\nadd segment 5 1 2\nadd segment 6 3 4\ncommit\n");
  const auto as_is = Prepare(path, reading, {});
  ASSERT_TRUE(as_is.ok()) << as_is.status();
  EXPECT_FALSE(as_is->report.is_mended);
  const auto mended = Prepare(path, reading, {1e-6});
  ASSERT_TRUE(mended.ok()) << mended.status();
  EXPECT_TRUE(mended->report.is_mended);
  EXPECT_TRUE(MeshOf(*mended).ok());
}

std::string MapOf(const std::string& rings) {
  return R"({"type": "FeatureCollection", "features": [{"type": "Feature", "id": "one",)"
         R"( "properties": {"name": "field"}, "geometry": {"type": "Polygon", "coordinates": [)" +
         rings + "]}}]}";
}

TEST_F(PrepareTest, ARingThatCrossesItselfIsMended) {
  const Prepared prepared = Of("bow.geojson", MapOf("[[0,0],[2,2],[2,0],[0,2],[0,0]]"));
  EXPECT_TRUE(prepared.report.is_mended);
  EXPECT_TRUE(MeshOf(prepared).ok());
  ASSERT_EQ(Count(prepared, FeatureKind::kPolygon), 1U);
  EXPECT_EQ(prepared.geometry.labels->names.begin()->second, "field");
}

TEST_F(PrepareTest, ARingWithoutAreaSpoilsItselfOnly) {
  const Prepared prepared =
      Of("ring.geojson", MapOf("[[0,0],[4,0],[4,4],[0,4],[0,0]],[[1,1],[2,2],[1,1]]"));
  EXPECT_TRUE(MeshOf(prepared).ok());
  EXPECT_EQ(Count(prepared, FeatureKind::kPolygon), 1U);
}

TEST_F(PrepareTest, APolygonWithoutAreaIsAnError) {
  io::GeometryOptions reading;
  reading.polygons = true;
  const auto status =
      Prepare(folder_.Write("flat.geojson", MapOf("[[0,0],[4,0],[2,0],[0,0]]")), reading, {})
          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("flat.geojson: nothing is left: 0 polygons and 0 segments"),
            std::string::npos)
      << status;
}

TEST_F(PrepareTest, GapsThatTakeTooManyVerticesAreClosed) {
  // Two squares 1e-8 apart.
  const Prepared prepared =
      Of("gap.geojson",
         R"({"type": "MultiPolygon", "coordinates": [[[[0,0],[1,0],[1,1],[0,1],[0,0]]],)"
         R"( [[[1.00000001,0],[2,0],[2,1],[1.00000001,1],[1.00000001,0]]]]})");
  EXPECT_TRUE(prepared.report.is_mended);
  const auto mesh = MeshOf(prepared);
  ASSERT_TRUE(mesh.ok());
  EXPECT_LT(mesh->vertices.size(), 1000U);
  EXPECT_LE(prepared.report.farthest, prepared.report.within);
}

TEST_F(PrepareTest, AGapThatTakesSomeThousandVerticesMayBeMeant) {
  const auto gap_of = [&](const std::string& x) {
    return Of("gap.geojson",
              R"({"type": "MultiPolygon", "coordinates": [[[[0,0],[1,0],[1,1],[0,1],[0,0]]],)"
              R"( [[[)" +
                  x + ",0],[2,0],[2,1],[" + x + ",1],[" + x + ",0]]]]}");
  };
  EXPECT_TRUE(gap_of("1.000001").report.is_mended);
  EXPECT_FALSE(gap_of("1.0001").report.is_mended);
}

// A needle pyramid, refused for 0.04 degrees at an edge after each tolerance within D.
TEST_F(PrepareTest, FacesAtASmallAngleBecomeOneIfNothingElseHelps) {
  const Prepared prepared = Of("flap.off",
                               "OFF\n5 6 0\n0.384 0.00981 8.12e-05\n-0.191 0.42 7.66e-05\n"
                               "-0.274 -0.0264 6.54e-05\n-0.391 -0.012 -2.08e-05\n"
                               "-0.286 -0.0333 1\n3 0 1 3\n3 1 0 4\n3 1 2 3\n3 2 1 4\n"
                               "3 2 0 3\n3 0 2 4\n");
  EXPECT_EQ(GetErrorDetail(prepared.report.found)->reason, reason::kSmallAngle);
  EXPECT_TRUE(prepared.report.is_mended);
  EXPECT_LE(prepared.report.farthest, prepared.report.within);
  EXPECT_TRUE(MeshOf(prepared).ok());
}

TEST_F(PrepareTest, TheLeastToleranceIsKept) {
  const std::string off = BoxSolid({0, 0, 0}, {1, 2, 3}).Off();
  PrepareOptions options;
  options.least_tolerance = 1e-5;
  const Prepared prepared = Of("box.off", off, options);
  EXPECT_TRUE(prepared.report.is_mended);
  EXPECT_GE(prepared.report.tolerance, 1e-5);
  EXPECT_TRUE(MeshOf(prepared).ok());
  // None within D.
  options.least_tolerance = 0.1;
  EXPECT_FALSE(Of("box.off", off, options).report.is_mended);
}

TEST_F(PrepareTest, OfWhatIsTooFineALargerToleranceMayHelp) {
  const auto refusal = [](const char* why) {
    return MakeError(absl::StatusCode::kResourceExhausted, "too much", {why, {}, {}});
  };
  Report report;
  report.within = 1;
  EXPECT_EQ(ToleranceIfTooFine(report, refusal(reason::kVertexLimit)), 0.1);
  report.tolerance = 0.1;
  EXPECT_EQ(ToleranceIfTooFine(report, refusal(reason::kDepthLimit)), 0.5);
  report.tolerance = 0.9;
  EXPECT_EQ(ToleranceIfTooFine(report, refusal(reason::kVertexLimit)), 1);
  EXPECT_EQ(ToleranceIfTooFine(report, refusal(reason::kSizeLimit)), std::nullopt);
  EXPECT_EQ(ToleranceIfTooFine(report, absl::OkStatus()), std::nullopt);
  // A soup encloses nothing, whatever its tolerance.
  report.open_edges_after = 3;
  EXPECT_EQ(ToleranceIfTooFine(report, refusal(reason::kVertexLimit)), LargerTolerance(report));
  EXPECT_EQ(ToleranceIfTooFine(report, refusal(reason::kDepthLimit)), std::nullopt);
  report.tolerance = 1;
  EXPECT_EQ(ToleranceIfTooFine(report, refusal(reason::kVertexLimit)), std::nullopt);
}

TEST_F(PrepareTest, PartsOfASegmentKeepItsMarker) {
  const Prepared prepared = Of("cross.poly",
                               "4 2 0 0\n1 0 0\n2 2 2\n3 2 0\n4 0 2\n"
                               "2 1\n1 1 2 5\n2 3 4 6\n0\n");
  EXPECT_TRUE(prepared.report.is_mended);
  EXPECT_TRUE(MeshOf(prepared).ok());
  std::map<std::int64_t, int> segments;
  for (const Feature& f : prepared.geometry.features) {
    if (f.kind == FeatureKind::kSegment) ++segments[prepared.geometry.labels->MarkerOf(f.id)];
  }
  EXPECT_EQ(segments, (std::map<std::int64_t, int>{{5, 2}, {6, 2}}));
}

}  // namespace
}  // namespace dynmesh::preparation
