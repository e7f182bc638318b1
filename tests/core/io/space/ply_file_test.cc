// PLY in its three formats: the resulting points, segments and faces, and the errors for invalid
// files.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "core/base/text.h"
#include "core/io/space/surface_files.h"
#include "tests/core/io/space/bad_text.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using testing::CountRefusalsOfDamage;
using testing::ExpectRefused;
using text::Concat;

absl::StatusOr<FileFeatures> Ply(const std::string& text) {
  return ParsePlyText(TextReader("a.ply", text));
}

std::string HeaderOf(const std::string& format, const std::string& float_type = "double") {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex 4\nproperty " +
         float_type + " x\nproperty uchar red\nproperty " + float_type + " y\nproperty " +
         float_type +
         " z\nelement face 2\nproperty list uchar int vertex_indices\nproperty short flags\n"
         "element edge 1\nproperty uint vertex1\nproperty int vertex2\n"
         "element extra 1\nproperty list ushort float things\nend_header\n";
}

const std::string kText = HeaderOf("ascii") +
                          "0 255 0 0\n1 0 0 0\n0 7 2 0\n0 0 0 -0.5\n"
                          "3 0 1 2 -4\n3 2 1 3 9\n"
                          "0 3\n"
                          "2 1.5 2.5\n";

const std::vector<Feature> kFeatures = {
    Feature::Point(1, 0, 0, 0),      Feature::Point(2, 1, 0, 0), Feature::Point(3, 0, 2, 0),
    Feature::Point(4, 0, 0, -0.5),   Feature::Segment(5, 1, 4),  Feature::Polygon(6, {{1, 2, 3}}),
    Feature::Polygon(7, {{3, 2, 4}})};

template <class T>
std::string Bytes(T value, bool big) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

template <class Float>
std::string Binary(bool big) {
  std::string file = HeaderOf(big ? "binary_big_endian" : "binary_little_endian",
                              sizeof(Float) == 4 ? "float" : "float64");
  for (std::size_t i = 0; i < 4; ++i) {
    file += Bytes(static_cast<Float>(kFeatures[i].position[0]), big) + "\xff";
    file += Bytes(static_cast<Float>(kFeatures[i].position[1]), big);
    file += Bytes(static_cast<Float>(kFeatures[i].position[2]), big);
  }
  for (const std::vector<std::int32_t>& face :
       std::vector<std::vector<std::int32_t>>{{0, 1, 2}, {2, 1, 3}}) {
    file += '\3';
    for (const std::int32_t v : face) file += Bytes(v, big);
    file += Bytes(std::int16_t{-2}, big);
  }
  file += Bytes(std::uint32_t{0}, big) + Bytes(std::int32_t{3}, big);
  return file + Bytes(std::uint16_t{2}, big) + Bytes(1.5F, big) + Bytes(2.5F, big);
}

TEST(PlyFile, TextHasPointsSegmentsAndFaces) {
  const auto input = Ply(kText);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features, kFeatures);
  EXPECT_EQ(input->Where(1), "a.ply:18");
  EXPECT_EQ(input->Where(5), "a.ply:24");
  EXPECT_EQ(input->Where(7), "a.ply:23");
}

TEST(PlyFile, BinaryOfEitherByteOrderIsTheSame) {
  for (const std::string& file :
       {Binary<double>(false), Binary<double>(true), Binary<float>(false), Binary<float>(true)}) {
    const auto input = Ply(file);
    ASSERT_TRUE(input.ok()) << input.status();
    EXPECT_EQ(input->features, kFeatures);
    EXPECT_EQ(input->Where(7), "a.ply:2");
  }
}

TEST(PlyFile, LinesMayEndAsInWindows) {
  std::string text = kText;
  for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += 2) {
    text.replace(i, 1, "\r\n");
  }
  const auto input = Ply(text);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features, kFeatures);
}

TEST(PlyFile, BadTextIsNamedByLine) {
  const std::string start = "ply\nformat ascii 1.0\n";
  const std::string v = start +
                        "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                        "element face 1\nproperty list uchar int vertex_index\nend_header\n";
  const std::string p = v + "0 0 0\n1 0 0\n0 1 0\n";
  ExpectRefused({{"", 1, "starts with a line 'ply'"},
                 {"plyx\n", 1, "starts with a line 'ply'"},
                 {"ply\nend_header\n", 2, "no line 'format'"},
                 {"ply\nformat ascii 2.0\n", 2, "'format NAME 1.0'"},
                 {"ply\nformat middle_endian 1.0\n", 2, "no format"},
                 {start + "element face\n", 3, "'element NAME COUNT'"},
                 {start + "element face -1\n", 3, "the number of elements"},
                 {start + "property int x\n", 3, "before any element"},
                 {start + "element vertex 1\nproperty long x\n", 4, "no type"},
                 {start + "element vertex 1\nproperty list float int x\n", 4, "no integer"},
                 {start + "element vertex 9\nend_header\n", 4, "has no property"},
                 {start + "elements\n", 3, "no line of a header"},
                 {start + "element vertex 1\n", 3, "ends before 'end_header'"},
                 {start + "element vertex 1\nproperty int x\nend_header\n", 5, "no property 'y'"},
                 {start + "element face 1\nproperty int x\nend_header\n", 5, "vertex_indices"},
                 {start + "element edge 1\nproperty int vertex1\nend_header\n", 5, "'vertex2'"},
                 {start + "element tristrips 1\nproperty int x\nend_header\n", 5, "strips"},
                 {v + "0 0\n", 10, "fewer values"},
                 {v + "0 0 0 0\n", 10, "more values"},
                 {v + "0 0 nan\n", 10, "nan"},
                 {p, 12, "face"},
                 {p + "3 0 1\n", 13, "fewer values"},
                 {p + "3 0 1 3\n", 13, "vertex 3 does not exist"},
                 {p + "3 0 1 -1\n", 13, "vertex -1 does not exist"},
                 {p + "3 0 1 1.5\n", 13, "no integer"},
                 {p + "-3 0 1 2\n", 13, "negative length"},
                 {p + "3 0 1 1\n", 13, "visits vertex 1 twice"},
                 {p + "2 0 1\n", 13, "fewer than 3"},
                 {p + "3 0 1 2\n3 0 1 2\n", 14, "more"}},
                "a.ply", Ply);
}

TEST(PlyFile, BadBinaryIsNamedByByteAndElement) {
  const std::string good = Binary<double>(false);
  const auto refusal = [](const std::string& file) {
    return std::string(Ply(file).status().message());
  };
  EXPECT_EQ(refusal(good + "x"),
            Concat("a.ply: byte ", good.size(), ": more bytes than the header announces"));
  EXPECT_EQ(refusal(good.substr(0, good.size() - 1)),
            Concat("a.ply: byte ", good.size() - 4, ", extra 0: the file ends here"));
  const std::size_t body = good.find("end_header\n") + 11;
  std::string bad = good;
  bad.replace(body, 8, Bytes(std::numeric_limits<double>::infinity(), false));
  EXPECT_EQ(refusal(bad),
            Concat("a.ply: byte ", body + 25, ", vertex 0: a vertex with a coordinate not finite"));
  bad = good;
  bad[body + 4 * 25 + 1] = '\x09';
  EXPECT_NE(refusal(bad).find("face 0: vertex 9 does not exist"), std::string::npos)
      << refusal(bad);
}

TEST(PlyFile, CutOrDamagedFilesNeverCrash) {
  int refused = 0;
  for (const std::string& good : {kText, Binary<float>(true), Binary<double>(false)}) {
    refused += CountRefusalsOfDamage(good, Ply);
  }
  EXPECT_GT(refused, 1000);
}

TEST(PlyFile, IsReadFromItsPath) {
  const test::TempFolder folder;
  const auto input = ReadPlyFile(folder.Write("a.ply", kText));
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features, kFeatures);
  EXPECT_EQ(ReadPlyFile(folder.Path("b.ply")).status().code(), absl::StatusCode::kNotFound);
}

TEST(SurfaceFiles, FacesAsTheyComeMayBeDegenerateAndTwice) {
  const auto off = ParseOffText(
      TextReader("a.off", "OFF\n3 4 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 2 1 0\n3 0 0 1\n2 0 1\n"),
      FaceRules::kAsTheyCome);
  ASSERT_TRUE(off.ok()) << off.status();
  EXPECT_EQ(off->features.size(), 7U);
  EXPECT_EQ(off->features[5].rings, (Rings{{1, 1, 2}}));
  const auto stl =
      ParseStlText(TextReader("a.stl",
                              "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 0\n"
                              "vertex 1 0 0\nendloop\nendfacet\nendsolid\n"),
                   FaceRules::kAsTheyCome);
  ASSERT_TRUE(stl.ok()) << stl.status();
  EXPECT_EQ(stl->features.back().rings, (Rings{{1, 1, 2}}));
}

}  // namespace
}  // namespace dynmesh::io
