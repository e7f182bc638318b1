#include "dynmesh/surfaces.h"

#include <optional>
#include <string>

#include "client/preparation/prepare.h"
#include "dynmesh/error.h"
#include "gtest/gtest.h"
#include "tests/client/preparation/solids.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::surfaces_test {
namespace {

using test::BoxSolid;
using test::CrackedBox;
using test::Solid;

class Surfaces : public ::testing::Test {
 protected:
  test::TempFolder folder_;
};

TEST_F(Surfaces, WhatIsMendedIsTold) {
  const std::string path = folder_.Write("crack.off", CrackedBox(1e-6).Off());
  const auto prepared = PrepareSurface(path);
  ASSERT_TRUE(prepared.ok()) << prepared.status();
  const SurfaceReport& report = prepared->report;
  EXPECT_TRUE(report.mended);
  EXPECT_FALSE(report.found.ok());
  EXPECT_EQ(report.open_edges_read, 8U);
  EXPECT_EQ(report.open_edges, 0U);
  EXPECT_FALSE(report.least_tolerance);
  EXPECT_LE(report.farthest, report.within);
  EXPECT_TRUE(BuildMesh(prepared->input.features, prepared->input.options).ok());
  // The same as the function below it.
  const auto same = preparation::Prepare(path, {}, {});
  EXPECT_EQ(same->geometry.features, prepared->input.features);
}

TEST_F(Surfaces, ChoicesAreThoseOfPreparation) {
  Solid open = BoxSolid({0, 0, 0}, {1, 2, 3});
  open.faces.resize(10);
  const std::string path = folder_.Write("open.off", open.Off());
  const auto holes = PrepareSurface(path);
  ASSERT_EQ(holes->report.open_loops.size(), 1U);
  EXPECT_EQ(holes->report.open_loops[0].points.size(), 4U);
  EXPECT_EQ(holes->report.open_loops[0].length, 10);
  EXPECT_EQ(PrepareSurface(path, {.fill_holes = 11.0})->report.open_edges, 0U);
  EXPECT_EQ(PrepareSurface(path, {.within = 0.0}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(PrepareSurface(folder_.Path("none.off")).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(PrepareSurface(path, {.mending_tolerance = 1e-5})->report.least_tolerance, 1e-5);
}

TEST_F(Surfaces, OneThatIsTooFineIsMendedWithALargerTolerance) {
  const std::string path =
      folder_.Write("needle.off",
                    "OFF\n6 8 0\n0.05685775 0.0002748734 -2.727833e-05\n"
                    "-0.06876524 0.02404099 4.281872e-05\n-0.07475285 0.0003367258 -2.022409e-06\n"
                    "-0.04555911 -0.01938796 -3.444687e-05\n-0.138661 -0.008725009 2.689457e-05\n"
                    "-0.079188 -0.005978653 1\n3 0 1 4\n3 1 0 5\n3 1 2 4\n3 2 1 5\n3 2 3 4\n"
                    "3 3 2 5\n3 3 0 4\n3 0 3 5\n");
  const auto made = BuildSurface(path);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_FALSE(made->attempts.empty());
  const SurfaceReport& report = made->surface.report;
  ASSERT_TRUE(report.least_tolerance);
  const auto again = PrepareSurface(path, {.mending_tolerance = *report.least_tolerance});
  EXPECT_EQ(again->input.features, made->surface.input.features);
  const FileInput& input = made->surface.input;
  EXPECT_EQ(made->mesh.hash, BuildMesh(input.features, input.options)->hash);
  EXPECT_TRUE(KeepInside(made->mesh).ok());
}

TEST_F(Surfaces, MapsAndInterruptedBuildsHaveOneAttempt) {
  const auto map =
      BuildSurface(folder_.Write("square.node", "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n"));
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_TRUE(map->attempts.empty());
  BuildOptions build;
  build.interrupted = [] { return true; };
  EXPECT_EQ(BuildSurface(folder_.Write("box.off", BoxSolid({0, 0, 0}, {1, 1, 2}).Off()), {}, build)
                .status()
                .code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace dynmesh::surfaces_test
