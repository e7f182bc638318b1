#include "core/io/plane/planar_output.h"

#include <bit>
#include <cmath>
#include <random>

#include "core/io/plane/planar_input.h"
#include "core/io/script/edit_script.h"
#include "gtest/gtest.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;

// Coordinates of every size, as features 1..n and n+1..n+m.
std::vector<Feature> AnyFeatures() {
  std::mt19937_64 random(11);
  std::vector<Feature> features;
  const auto any = [&] {
    return std::ldexp(static_cast<double>(static_cast<std::int64_t>(random())),
                      static_cast<int>(random() % 200) - 150);
  };
  for (FeatureId id = 1; id <= 500; ++id) features.push_back(Feature::Point(id, any(), any()));
  for (FeatureId id = 501; id <= 700; ++id) {
    features.push_back(Feature::Segment(id, random() % 500 + 1, random() % 500 + 1));
  }
  return features;
}

TEST(PolyOutput, ReadsBackBitForBit) {
  const TempFolder folder;
  const std::vector<Feature> features = AnyFeatures();
  ASSERT_TRUE(WritePolyFile(folder.Path("a.poly"), features).ok());
  const auto input = ReadPolyFile(folder.Path("a.poly"));
  ASSERT_TRUE(input.ok()) << input.status();
  ASSERT_EQ(input->features, features);
  for (std::size_t i = 0; i < 500; ++i) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(input->features[i].position[0]),
              std::bit_cast<std::uint64_t>(features[i].position[0]));
  }
}

TEST(PolyOutput, OtherIdsAreNumberedAsTheyCome) {
  const TempFolder folder;
  ASSERT_TRUE(WritePolyFile(
                  folder.Path("a.poly"),
                  {Feature::Segment(3, 90, 4), Feature::Point(90, 0, 0), Feature::Point(4, 1, 0.1)})
                  .ok());
  EXPECT_EQ(folder.Read("a.poly"), "2 2 0 0\n1 0 0\n2 1 0.1\n1 0\n1 1 2\n0\n");
}

TEST(PolyOutput, ASegmentWithoutEndsIsRefused) {
  const TempFolder folder;
  EXPECT_EQ(WritePolyFile(folder.Path("a.poly"), {Feature::Segment(3, 90, 4)}).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(folder.FileCount(), 0U);
}

TEST(FeatureScript, ReadsBackAsOneBatch) {
  const TempFolder folder;
  const std::vector<Feature> features = AnyFeatures();
  MeshOptions options;
  options.box = BoundingBox(features);
  options.quality = 1.1;
  ASSERT_TRUE(WriteFeatureScript(folder.Path("a.dynmesh"), options, features).ok());
  const auto script = ReadEditScript(folder.Path("a.dynmesh"));
  ASSERT_TRUE(script.ok()) << script.status();
  EXPECT_EQ(script->Options(), options);
  ASSERT_EQ(script->batches.size(), 1U);
  ASSERT_EQ(script->batches[0].edits.size(), features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    EXPECT_EQ(script->batches[0].edits[i], Edit::Add(features[i]));
  }
}

}  // namespace
}  // namespace dynmesh::io
