// OFF, STL and OBJ: the resulting points and faces, and the errors for invalid files.
#include "core/io/space/surface_files.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/base/text.h"
#include "tests/core/io/space/bad_text.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using testing::CountRefusalsOfDamage;
using testing::ExpectRefused;
using text::Concat;

absl::StatusOr<FileFeatures> Off(const std::string& text) {
  return ParseOffText(TextReader("a.off", text));
}
absl::StatusOr<FileFeatures> Stl(const std::string& text) {
  return ParseStlText(TextReader("a.stl", text));
}
absl::StatusOr<FileFeatures> Obj(const std::string& text) {
  return ParseObjText(TextReader("a.obj", text));
}

const std::vector<Feature> kTetrahedron = {
    Feature::Point(1, 0, 0, 0),       Feature::Point(2, 1, 0, 0),
    Feature::Point(3, 0, 2, 0),       Feature::Point(4, 0, 0, 0.5),
    Feature::Polygon(5, {{1, 3, 2}}), Feature::Polygon(6, {{1, 2, 4}}),
    Feature::Polygon(7, {{2, 3, 4}}), Feature::Polygon(8, {{3, 1, 4}})};

using Triangle = std::array<std::array<float, 3>, 3>;

std::vector<Triangle> TrianglesOf(const std::vector<Feature>& features) {
  std::vector<Triangle> triangles;
  for (const Feature& f : features) {
    if (f.kind != FeatureKind::kPolygon) continue;
    Triangle& t = triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t d = 0; d < 3; ++d) {
        t[k][d] = static_cast<float>(features[f.rings[0][k] - 1].position[d]);
      }
    }
  }
  return triangles;
}

std::string AsciiStl(const std::vector<Triangle>& triangles) {
  std::string text = "solid a b c\n";
  for (const Triangle& t : triangles) {
    text += "  facet normal nan 0 0\n    outer loop\n";
    for (const auto& p : t) {
      text += Concat("      vertex ", p[0], " ", p[1], " ", p[2], "\n");
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid a b c\n";
}

void AppendWord(std::string& bytes, std::uint32_t word) {
  for (int i = 0; i < 4; ++i, word >>= 8) bytes.push_back(static_cast<char>(word & 255));
}

std::string BinaryStl(const std::vector<Triangle>& triangles) {
  std::string bytes = "solid, but binary";
  bytes.resize(80);
  AppendWord(bytes, static_cast<std::uint32_t>(triangles.size()));
  for (const Triangle& t : triangles) {
    bytes += std::string(12, '\xff');
    for (const auto& p : t) {
      for (const float c : p) AppendWord(bytes, std::bit_cast<std::uint32_t>(c));
    }
    bytes += "#\n";
  }
  return bytes;
}

TEST(OffFile, FacesBecomePolygons) {
  for (const char* header :
       {"OFF\n4 4 6\n", "OFF 4 4 0\n", "# a\n\nOFF # b\n\n4 4\n", "COFF\n4 4 6\n"}) {
    const auto input = Off(std::string(header) +
                           "0 0 0 255 0 0\n1 0 0 # x\n0 2 0\n\n0 0 .5\n"
                           "3 0 2 1 1 0.5 0\n3 0 1 3\n3 1 2 3 200\n3 2 0 3\n");
    ASSERT_TRUE(input.ok()) << input.status();
    EXPECT_EQ(input->features, kTetrahedron) << header;
  }
  const auto input = Off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  ASSERT_TRUE(input.ok());
  EXPECT_EQ(input->Where(2), "a.off:4");
  EXPECT_EQ(input->Where(4), "a.off:6");
  EXPECT_EQ(input->Where(5), "");
}

TEST(StlFile, EqualCornersBecomeOnePoint) {
  // In the order in which the triangles come to their corners.
  const auto expect = [](const FileFeatures& input) {
    ASSERT_EQ(input.point_count, 4U);
    EXPECT_EQ(input.features.size(), 8U);
    EXPECT_EQ(input.features[1], Feature::Point(2, 0, 2, 0));
    EXPECT_EQ(input.features[4], Feature::Polygon(5, {{1, 2, 3}}));
    EXPECT_EQ(input.features[7], Feature::Polygon(8, {{2, 1, 4}}));
  };
  const std::vector<Triangle> triangles = TrianglesOf(kTetrahedron);
  const auto ascii = Stl(AsciiStl(triangles));
  ASSERT_TRUE(ascii.ok()) << ascii.status();
  expect(*ascii);
  EXPECT_EQ(ascii->Where(4), "a.stl:13");
  EXPECT_EQ(ascii->Where(6), "a.stl:9");
  const auto binary = Stl(BinaryStl(triangles));
  ASSERT_TRUE(binary.ok()) << binary.status();
  expect(*binary);
  EXPECT_EQ(binary->features, ascii->features);
  EXPECT_EQ(binary->Where(4), "a.stl:2");
}

TEST(StlFile, MinusZeroIsZeroAndSolidsMayBeSeveralInAnyCase) {
  const auto input =
      Stl("SOLID\nFacet Normal 0 0 1\nOUTER LOOP\nvertex 0 0 0\nvertex 1 0 0\nVERTEX 0 1 0\n"
          "endloop\nendfacet\nENDSOLID\n"
          "solid b\nfacet\nouter loop\nvertex -0 0 -0.0\nvertex 1 0 0\nvertex 0 0 1\nendloop\n"
          "endfacet\nendsolid\n");
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->point_count, 4U);
  EXPECT_EQ(input->features[5], Feature::Polygon(6, {{1, 2, 4}}));
}

TEST(StlFile, RandomTrianglesComeBackFromBothForms) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937 rng(seed);
  std::uniform_int_distribution<int> number(-3, 3);
  std::vector<Triangle> triangles(40);
  for (Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {  // never two equal ones, never one triangle twice
      t[k] = {static_cast<float>(number(rng)) / 3, static_cast<float>(k),
              static_cast<float>(&t - triangles.data()) / 7};
    }
  }
  for (const std::string& bytes : {AsciiStl(triangles), BinaryStl(triangles)}) {
    const auto input = Stl(bytes);
    ASSERT_TRUE(input.ok()) << input.status();
    EXPECT_EQ(TrianglesOf(input->features), triangles);
  }
}

TEST(ObjFile, FacesLinesAndPointsAreTaken) {
  const auto input = Obj(
      "mtllib a.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\nv 0 2 0 0.1 0.2 0.3\nv 0 0 .5\nvt 0 1\n"
      "vn 0 0 1\ng side\ns off\nf 1 3 2\nf 1/1 2/1 4/1\nf -3//1 3//1 -1//1\nf 3/1/1 1/1/1 4/1/1\n"
      "l 1 2/1 3\nl 2 1\np 4 -4\ncurv2 1 2\n");
  ASSERT_TRUE(input.ok()) << input.status();
  ASSERT_EQ(input->features.size(), 10U);
  EXPECT_EQ(input->features[4], Feature::Segment(5, 1, 2));
  EXPECT_EQ(input->features[5], Feature::Segment(6, 2, 3));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(input->features[i], kTetrahedron[i]);
    EXPECT_EQ(input->features[6 + i].rings, kTetrahedron[4 + i].rings);
  }
  EXPECT_EQ(input->Where(6), "a.obj:15");
  EXPECT_EQ(input->Where(7), "a.obj:11");
}

TEST(ObjFile, LinesThatEndInABackslashGoOn) {
  const auto input =
      Obj("v 0 0 0\nv 1 \\\r\n0 0\nv 0 2 0\nv 0 0 .5\nf 1 3\\\n2\nf 1 2 \\\n\\\n4\n");
  ASSERT_TRUE(input.ok()) << input.status();
  ASSERT_EQ(input->features.size(), 6U);
  EXPECT_EQ(input->features[5].rings, kTetrahedron[5].rings);
  EXPECT_EQ(input->Where(5), "a.obj:6");  // its first line
  EXPECT_EQ(input->Where(6), "a.obj:8");
  EXPECT_EQ(Obj("v 0 0 0\nf 1 \\\n9\n").status().message().substr(0, 8), "a.obj:2:");
}

TEST(StlFile, BytesBehindTheTrianglesDoNotMakeABinaryFileText) {
  const std::vector<Triangle> triangles = TrianglesOf(kTetrahedron);
  std::string bytes = BinaryStl(triangles) + "x";
  bytes.replace(0, 6, "solid ");
  const auto input = Stl(bytes);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(TrianglesOf(input->features), triangles);
  EXPECT_FALSE(Stl(bytes.substr(0, bytes.size() - 2)).ok());
}

TEST(MalformedSurface, OffIsRefusedWithFileAndLine) {
  const std::string p = "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";  // 6 lines
  ExpectRefused({{"", 1, "it has no line OFF"},
                 {"4 2 0\n", 1, "starts with OFF, this one with '4'"},
                 {"4OFF\n4 2 0\n", 1, "'4OFF' files are not supported"},
                 {"OFF BINARY\n", 1, "binary .off"},
                 {"OFF\n", 1, "ends before the counts"},
                 {"OFF\nx 1 0\n", 2, "number of vertices"},
                 {"OFF\n4\n", 2, "number of faces is missing"},
                 {"OFF\n4 1 0 0\n", 2, "more than the counts"},
                 {"OFF\n99999999999 1 0\n", 2, "more than 2^32"},
                 {"OFF\n4000000000 1 0\n0 0 0\n", 3, "ends after 1 of 4000000000 vertex"},
                 {"OFF\n1 1 0\n0 0\n", 3, "z is missing"},
                 {"OFF\n1 1 0\n0 nan 0\n", 3, "y is not a finite number"},
                 {p + "3 0 1 2\n", 7, "ends after 1 of 2 face"},
                 {p + "3 0 1 4\n", 7, "vertex 4 does not exist: they run from 0 to 3"},
                 {p + "3 0 1\n", 7, "a face of 3 corners has only 2"},
                 {p + "18446744073709551615 0 1\n", 7, "has only 2"},
                 {p + "3 0 1 1\n", 7, "visits vertex 1 twice"},
                 {p + "2 0 1\n", 7, "a face has 2 corners, fewer than 3"},
                 {p + "0\n", 7, "a face has 0 corners"},
                 {p + "3 0 1 2\n3 1 2 0\n", 8, "same corners as the one on line 7"},
                 {p + "3 0 1 2\n3 1 2 3\n3 0 1 3\n", 9, "more values after"}},
                "a.off", Off);
}

TEST(MalformedSurface, StlIsRefusedWithFileAndLine) {
  const std::string good = AsciiStl(TrianglesOf(kTetrahedron));
  const std::string f = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
  ExpectRefused(
      {{"", 1, "neither 'solid' nor a binary file"},
       {std::string(200, 'x'), 1, "2021161080 triangles would have 101058054084 bytes, not 200"},
       {"solid\n", 1, "ends before 'endsolid'"},
       {"solids\n", 1, "'solid' expected here"},
       {"solid\nvertex 0 0 0\n", 2, "'facet' or 'endsolid' expected here, found 'vertex'"},
       {"solid\nfacet\nloop\n", 3, "'outer loop' expected here, found 'loop'"},
       {f, 4, "ends where 'vertex'"},
       {f + "vertex 0 0\n", 5, "z is missing"},
       {f + "vertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\n", 7, "'endloop' expected here"},
       {f + "vertex 1 0 0\nvertex 0 1 0\nendloop\nendsolid\n", 8, "'endfacet' expected here"},
       {f + "vertex 1 0 0\nvertex -0 0 0\nendloop\nendfacet\nendsolid\n", 2, "at one place"},
       {good + good, 32, "same corners as the one on line 2"},
       {good + "x\n", 31, "'solid' expected here"}},
      "a.stl", Stl);
}

TEST(MalformedSurface, BinaryStlIsRefusedWithTheNumberOfTheTriangle) {
  std::vector<Triangle> triangles = TrianglesOf(kTetrahedron);
  triangles[2][1][2] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(Stl(BinaryStl(triangles)).status().message(),
            "a.stl:3: triangle 3 of the file has a coordinate that is not finite");
  triangles[2] = triangles[0];
  EXPECT_EQ(Stl(BinaryStl(triangles)).status().message(),
            "a.stl:3: a face has the same corners as the one on line 1; leave one of them out");
  triangles[1][2] = triangles[1][0];
  EXPECT_EQ(Stl(BinaryStl(triangles)).status().message(),
            "a.stl:2: two corners of a triangle are at one place; leave it out");
}

TEST(MalformedSurface, ObjIsRefusedWithFileAndLine) {
  const std::string p = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  ExpectRefused({{"v 0 0\n", 1, "z is missing"},
                 {"v 0 x 0\n", 1, "y is not a finite number"},
                 {p + "f 1 2 4\n", 4, "vertex 4 does not exist: 3 stand above"},
                 {p + "f 1 2 -4\n", 4, "vertex -4 does not exist"},
                 {p + "f 1 2 -9223372036854775808\n", 4, "does not exist"},
                 {p + "f 1 2 0\n", 4, "no index of a vertex"},
                 {p + "f 1 2 /3\n", 4, "no index of a vertex"},
                 {p + "f 1 2 a\n", 4, "no index of a vertex"},
                 {p + "f 1 2 3 1\n", 4, "visits vertex 1 twice"},
                 {p + "f 1 2\n", 4, "fewer than 3"},
                 {p + "f\n", 4, "fewer than 3"},
                 {p + "f 1 2 3\nf 3 2 1\n", 5, "same corners as the one on line 4"},
                 {p + "l 1\n", 4, "fewer than 2 vertices"},
                 {p + "l 1 1\n", 4, "vertex 1 at both ends"},
                 {p + "p 4\n", 4, "vertex 4 does not exist"}},
                "a.obj", Obj);
}

TEST(MalformedSurface, CutOrDamagedFilesNeverCrash) {
  const std::vector<Triangle> triangles = TrianglesOf(kTetrahedron);
  const std::string off = "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 1 2 3\n";
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2//2 -1\nl 1 2 3\np 1\n";
  int refused = 0;
  for (const std::string& good : {off, obj, AsciiStl(triangles), BinaryStl(triangles)}) {
    for (const auto read : {Off, Stl, Obj}) refused += CountRefusalsOfDamage(good, read);
  }
  EXPECT_GT(refused, 1000);
}

TEST(SurfaceFiles, AreReadFromTheirPaths) {
  const test::TempFolder folder;
  EXPECT_TRUE(ReadOffFile(folder.Write("a.off", "OFF\n0 0 0\n")).ok());
  EXPECT_TRUE(ReadStlFile(folder.Write("a.stl", "solid\nendsolid\n")).ok());
  EXPECT_TRUE(ReadObjFile(folder.Write("a.obj", "")).ok());
  EXPECT_EQ(ReadOffFile(folder.Path("b.off")).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace dynmesh::io
