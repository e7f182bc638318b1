// Surfaces written as .poly, .smesh and .off, and read again.
#include "core/io/space/surface_output.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/io/space/space_input.h"
#include "core/io/space/surface_files.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

const std::vector<Feature> kSurface = {
    Feature::Point(1, 0, 0, 0),         Feature::Point(2, 1, 0, 0.1),
    Feature::Point(3, 1, 1, 1e-300),    Feature::Point(4, 0, 1.0 / 3, 0),
    Feature::Segment(5, 1, 3),          Feature::Polygon(6, {{1, 2, 3}}),
    Feature::Polygon(7, {{4, 3, 2, 1}})};

FeatureLabels LabelsOf() {
  FeatureLabels labels;
  labels.markers = {{2, 20}, {5, 50}, {7, -70}};
  return labels;
}

TEST(SurfaceOutput, TetGensFilesReadBackAsTheSame) {
  const test::TempFolder folder;
  const std::vector<SeedRow> holes = {{{0.5, 0.5, 0.25}, {}, 0}};
  const std::vector<SeedRow> regions = {{{0.25, 0.5, 0.25}, {3, 0.5}, 0}};
  const std::string poly = folder.Path("a.poly"), smesh = folder.Path("a.smesh");
  ASSERT_TRUE(WriteSpacePolyFile(poly, kSurface, holes, regions, LabelsOf()).ok());
  ASSERT_TRUE(WriteSmeshFile(smesh, kSurface, holes, regions, LabelsOf()).ok());
  for (const bool is_poly : {true, false}) {
    const auto input = is_poly ? ReadSpacePolyFile(poly) : ReadSmeshFile(smesh);
    ASSERT_TRUE(input.ok()) << input.status();
    EXPECT_EQ(input->features, kSurface);
    EXPECT_EQ(input->labels.markers, LabelsOf().markers);
    ASSERT_EQ(input->holes.size(), 1U);
    EXPECT_EQ(input->holes[0].position, holes[0].position);
    ASSERT_EQ(input->regions.size(), 1U);
    EXPECT_EQ(input->regions[0].more, regions[0].more);
  }
}

TEST(SurfaceOutput, OffHasPointsAndFaces) {
  const test::TempFolder folder;
  const std::string path = folder.Path("a.off");
  ASSERT_TRUE(WriteOffFile(path, kSurface).ok());
  const auto input = ReadOffFile(path);
  ASSERT_TRUE(input.ok()) << input.status();
  ASSERT_EQ(input->features.size(), 6U);
  EXPECT_EQ(input->features[2], kSurface[2]);
  EXPECT_EQ(input->features[5].rings, kSurface[6].rings);
}

TEST(SurfaceOutput, WhatHasNoPlaceIsRefused) {
  const test::TempFolder folder;
  const std::string path = folder.Path("a.off");
  const Feature frame = Feature::Polygon(8, {{1, 2, 3}, {4, 2, 3}});
  const Feature astray = Feature::Polygon(8, {{1, 2, 9}});
  for (const Feature& f : {frame, astray}) {
    std::vector<Feature> features = kSurface;
    features.push_back(f);
    const absl::Status status = WriteOffFile(path, features);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(status.message().find("8"), std::string::npos);
  }
  EXPECT_EQ(WriteOffFile(folder.Path("no/a.off"), kSurface).code(), absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace dynmesh::io
