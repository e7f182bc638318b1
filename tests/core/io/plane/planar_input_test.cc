#include "core/io/plane/planar_input.h"

#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;

TEST(NodeFile, PointsBecomeFeaturesFromOne) {
  const TempFolder folder;
  const auto input = ReadNodeFile(folder.Write("a.node",
                                               "# a comment\n"
                                               "3 2 0 0\n\n"
                                               "1 0.5 -0\n"
                                               "2 1e3 2.5 # another\n"
                                               "3 +1 .25\n"));
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features,
            (std::vector<Feature>{Feature::Point(1, 0.5, -0.0), Feature::Point(2, 1000, 2.5),
                                  Feature::Point(3, 1, 0.25)}));
  EXPECT_EQ(input->Where(2), folder.Path("a.node") + ":5");
  EXPECT_EQ(input->Where(4), "");
  EXPECT_EQ(input->Where(0), "");
}

TEST(NodeFile, NumbersFromZeroAttributesAndMarkersAreTaken) {
  const TempFolder folder;
  const auto input =
      ReadNodeFile(folder.Write("a.node", "2 2 2 1\n0 1 2 0.5 7 -1\n1 3 4 0.5 7 9\n"));
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features,
            (std::vector<Feature>{Feature::Point(1, 1, 2), Feature::Point(2, 3, 4)}));
  EXPECT_EQ(input->labels.attributes, 2U);
  EXPECT_EQ(input->labels.values, (std::vector<double>{0.5, 7, 0.5, 7}));
  EXPECT_EQ(input->labels.MarkerOf(1), -1);
  EXPECT_EQ(input->labels.MarkerOf(2), 9);
}

TEST(NodeFile, AHeaderMayLeaveOutWhatIsUsual) {
  const TempFolder folder;
  EXPECT_TRUE(ReadNodeFile(folder.Write("a.node", "1\n1 5 6\n")).ok());
  const auto empty = ReadNodeFile(folder.Write("b.node", "0 2 0 0\n"));
  ASSERT_TRUE(empty.ok());
  EXPECT_TRUE(empty->features.empty());
}

TEST(PolyFile, SegmentsFollowThePoints) {
  const TempFolder folder;
  const auto input = ReadPolyFile(folder.Write("a.poly",
                                               "3 2 0 1\n1 0 0 5\n2 1 0 5\n3 0 1 5\n"
                                               "2 1\n1 1 2 3\n2 3 1 -4\n"
                                               "1\n1 0.2 0.2\n"
                                               "2\n1 0.1 0.1 3\n2 0.1 0.1 3 0.5\n"));
  ASSERT_TRUE(input.ok()) << input.status();
  ASSERT_EQ(input->features.size(), 5U);
  EXPECT_EQ(input->point_count, 3U);
  EXPECT_EQ(input->segment_count, 2U);
  EXPECT_EQ(input->features[3], Feature::Segment(4, 1, 2));
  EXPECT_EQ(input->features[4], Feature::Segment(5, 3, 1));
  EXPECT_EQ(input->holes, (std::vector<SeedRow>{{{0.2, 0.2}, {}, 9}}));
  EXPECT_EQ(input->regions,
            (std::vector<SeedRow>{{{0.1, 0.1}, {3}, 11}, {{0.1, 0.1}, {3, 0.5}, 12}}));
  EXPECT_EQ(input->Where(5), folder.Path("a.poly") + ":7");
}

TEST(PolyFile, NumbersFromZeroMeanTheSameVertices) {
  const TempFolder folder;
  const auto input = ReadPolyFile(folder.Write("a.poly", "2 2 0 0\n0 0 0\n1 1 1\n1 0\n0 0 1\n0\n"));
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features[2], Feature::Segment(3, 1, 2));
}

TEST(PolyFile, TakesItsPointsFromTheNodeFileBesideIt) {
  const TempFolder folder;
  folder.Write("a.node", "2 2 0 0\n0 5 6\n1 7 8\n");
  const auto input = ReadPolyFile(folder.Write("a.poly", "0 2 0 0\n1 0\n1 0 1\n0\n"));
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features, (std::vector<Feature>{Feature::Point(1, 5, 6), Feature::Point(2, 7, 8),
                                                   Feature::Segment(3, 1, 2)}));
  EXPECT_EQ(input->Where(1), folder.Path("a.node") + ":2");
  EXPECT_EQ(input->Where(3), folder.Path("a.poly") + ":3");
}

struct BadFile {
  const char* extension;
  const char* text;
  int line;             // that the message must name
  const char* message;  // a required part of it
};

const BadFile kBadFiles[] = {
    {"node", "", 1, "no vertex header"},
    {"node", "# nothing\n", 1, "no vertex header"},
    {"node", "x 2 0 0\n", 1, "number of vertices"},
    {"node", "-1 2 0 0\n", 1, "number of vertices"},
    {"node", "1.5 2 0 0\n1 0 0\n", 1, "number of vertices"},
    {"node", "5000000000 2 0 0\n", 1, "more than 2^32"},
    {"node", "99999999999999999999 2 0 0\n", 1, "number of vertices"},
    {"node", "1 4 0 0\n1 0 0\n", 1, "dimension 4"},
    {"node", "1 2 0 2\n1 0 0\n", 1, "must be 0 or 1"},
    {"node", "1 2 100000 0\n1 0 0\n", 1, "attributes"},
    {"node", "1 2 0 0 0\n1 0 0\n", 1, "more than 4 values"},
    {"node", "4000000000 2 0 0\n1 0 0\n", 2, "ends after 1 of 4000000000"},
    {"node", "3 2 0 0\n1 0 0\n2 1 0\n", 3, "ends after 2 of 3"},
    {"node", "2 2 0 0\n1 0 0\n3 1 0\n", 3, "vertex number 2 expected here, found 3"},
    {"node", "2 2 0 0\n1 0 0\n1 1 0\n", 3, "vertex number 2 expected here, found 1"},
    {"node", "1 2 0 0\n2 0 0\n", 2, "vertex number 1 expected here, found 2"},
    {"node", "1 2 0 0\n1 0\n", 2, "3 values according to its header, this one 2"},
    {"node", "1 2 0 0\n1 0 0 0\n", 2, "this one 4"},
    {"node", "1 2 1 0\n1 0 0\n", 2, "this one 3"},
    {"node", "1 2 0 0\n1 0 zero\n", 2, "y is not a finite number"},
    {"node", "1 2 0 0\n1 nan 0\n", 2, "x is not a finite number"},
    {"node", "1 2 0 0\n1 1e999 0\n", 2, "x is not a finite number"},
    {"node", "1 2 1 0\n1 0 0 blue\n", 2, "attribute 1"},
    {"node", "1 2 0 1\n1 0 0 1.5\n", 2, "marker"},
    {"node", "1 2 0 0\n1 0 0\n2 1 1\n", 3, "more values after the last row"},
    {"poly", "1 2 0 0\n1 0 0\n", 2, "no segment header"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\nx 0\n", 4, "number of segments"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n1 0 0\n1 1 2\n0\n", 4, "more than 2 values"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n1 0\n1 1 3\n0\n", 5, "vertex 3 does not exist: they run"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n1 0\n1 0 1\n0\n", 5, "vertex 0 does not exist"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n1 0\n1 1\n0\n", 5, "this one 2"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n2 0\n1 1 2\n", 5, "ends after 1 of 2 segment"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n1 1\n1 1 2 red\n0\n", 5, "marker"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n0 0\n1\n1 0\n", 6, "a hole row"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n0 0\n1\n1 0 y\n", 6, "value 3 of a hole"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n0 0\n2\n1 0 0\n", 6, "ends after 1 of 2 hole"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n0 0\n0\n1\n1 0 0 0 0 0\n", 7, "a region row"},
    {"poly", "2 2 0 0\n1 0 0\n2 1 1\n0 0\n0\n0\n5\n", 7, "more values after the last row"},
    {"poly", "0 2 0 0\n0 0\n0\n", 1, "there is no"},
};

TEST(MalformedInput, IsRefusedWithFileAndLine) {
  for (const BadFile& bad : kBadFiles) {
    const TempFolder folder;
    const std::string path = folder.Write(std::string("bad.") + bad.extension, bad.text);
    const bool node = std::string(bad.extension) == "node";
    const absl::Status status = node ? ReadNodeFile(path).status() : ReadPolyFile(path).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << bad.text;
    const std::string message(status.message());
    EXPECT_TRUE(message.starts_with(path + ":" + std::to_string(bad.line) + ": "))
        << bad.text << "\n"
        << message;
    EXPECT_NE(message.find(bad.message), std::string::npos) << bad.text << "\n" << message;
  }
}

TEST(MalformedInput, InASecondFileNamesThatFile) {
  const TempFolder folder;
  folder.Write("a.node", "1 2 0 0\n1 x 0\n");
  const absl::Status status = ReadPolyFile(folder.Write("a.poly", "0 2 0 0\n0 0\n0\n")).status();
  EXPECT_TRUE(std::string(status.message()).starts_with(folder.Path("a.node") + ":2: ")) << status;
}

TEST(MalformedInput, ThreeDimensionsAreSaidToBeToCome) {
  const TempFolder folder;
  const absl::Status status = ReadNodeFile(folder.Write("a.node", "1 3 0 0\n1 0 0 0\n")).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented);
  EXPECT_NE(std::string(status.message()).find("not supported yet in this version"),
            std::string::npos);
}

// Simple fuzzing: damage of any byte must give an answer, never a crash.
TEST(MalformedInput, ByteByByteNeverCrashes) {
  const TempFolder folder;
  const std::string good =
      "3 2 1 1\n1 0 0 0.5 1\n2 1 0 0.5 1\n3 0 1 0.5 1\n2 1\n1 1 2 3\n2 3 1 4\n1\n1 .2 .2\n0\n";
  ASSERT_TRUE(ReadPolyFile(folder.Write("f.poly", good)).ok());
  int refused = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (const char c : {'9', '-', 'e', '#', '\n', '\0', '\xff', ' '}) {
      std::string bad = good;
      bad[i] = c;
      const auto input = ReadPolyFile(folder.Write("f.poly", bad));
      if (!input.ok()) ++refused;
    }
    const auto cut = ReadPolyFile(folder.Write("f.poly", good.substr(0, i)));
    if (!cut.ok()) ++refused;
  }
  EXPECT_GT(refused, 200);
}

}  // namespace
}  // namespace dynmesh::io
