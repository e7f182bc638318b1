// Target lengths from rasters, views and .mtr.
#include "core/io/sizes/size_fields.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;

MeshOptions Options(int dimension, double side) {
  MeshOptions options;
  options.dimension = dimension;
  options.box = {{0, 0, 0}, {side, side, side}};
  return options;
}

// The least target at a place.
double TargetAt(const std::vector<Feature>& sizes, const std::array<double, 3>& p, int dimension) {
  double least = HUGE_VAL;
  for (const Feature& f : sizes) {
    bool is_in = true;
    double square = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(dimension); ++k) {
      is_in &= f.position[k] <= p[k] && p[k] <= f.sizing.hi[k];
      square += (f.position[k] - p[k]) * (f.position[k] - p[k]);
    }
    if (f.sizing.shape != SizeShape::kBox) {
      is_in = std::sqrt(square) <= f.sizing.radius * (1 + 1e-12);
    }
    if (is_in) least = std::min(least, f.sizing.target);
  }
  return least;
}

std::string Npy(const std::string& shape, const std::string& type, const std::string& data) {
  std::string header =
      "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }\n";
  std::string file = "\x93NUMPY";
  file += std::string("\x01\0", 2);
  file += static_cast<char>(header.size() % 256);
  file += static_cast<char>(header.size() / 256);
  return file + header + data;
}

std::string Npy(const std::string& shape, const std::vector<double>& values) {
  return Npy(shape, "<f8",
             std::string(reinterpret_cast<const char*>(values.data()), 8 * values.size()));
}

TEST(SizeRaster, GivesEachCellAtMostItsLength) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937_64 random(seed);
  for (const int dimension : {2, 3}) {
    std::vector<double> values;
    const std::size_t n = dimension == 2 ? 64 : 512;
    for (std::size_t i = 0; i < n; ++i) {
      values.push_back(random() % 4 == 0 ? -1 : static_cast<double>(1 + random() % 2) / 8);
    }
    const auto raster = ParseNpy("a.npy", Npy(dimension == 2 ? "(8, 8)" : "(8, 8, 8)", values),
                                 Options(dimension, 8).box, dimension);
    ASSERT_TRUE(raster.ok()) << raster.status();
    const auto sizes = SizesOf(*raster, Options(dimension, 8).box, 100, dimension);
    ASSERT_TRUE(sizes.ok());
    EXPECT_EQ(sizes->front().id, 100U);
    for (std::size_t i = 0; i < n; ++i) {
      const std::array<double, 3> middle = {static_cast<double>(i % 8) + .5,
                                            static_cast<double>(i / 8 % 8) + .5,
                                            dimension == 3 ? static_cast<double>(i / 64) + .5 : 0};
      EXPECT_EQ(TargetAt(*sizes, middle, dimension), values[i] > 0 ? values[i] : HUGE_VAL) << i;
    }
  }
}

TEST(SizeRaster, JoinsCellsOfOneLength) {
  const auto raster =
      ParseNpy("a.npy", Npy("(4, 4)", std::vector<double>(16, 0.5)), Options(2, 4).box, 2);
  const auto sizes = SizesOf(*raster, Options(2, 4).box, 1, 2);
  ASSERT_EQ(sizes->size(), 1U);
  EXPECT_EQ((*sizes)[0].sizing.hi, (std::array<double, 3>{4, 4, 0}));
  // What lies beyond the mesh's box is left out.
  EXPECT_TRUE(SizesOf(*raster, {{9, 9, 0}, {10, 10, 0}}, 1, 2)->empty());
}

TEST(SizeRaster, OfEsriBeginsWithTheTopRow) {
  const auto raster = ParseEsriAscii(TextReader(
      "a.asc",
      "NCOLS 2\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 5\nNODATA_value -9\n1 2\n3 -9\n"));
  ASSERT_TRUE(raster.ok()) << raster.status();
  EXPECT_EQ(raster->values, (std::vector<double>{3, 0, 1, 2}));
  EXPECT_EQ(raster->box.lo, (std::array<double, 3>{10, 20, 0}));
  EXPECT_EQ(raster->box.hi, (std::array<double, 3>{20, 30, 0}));
}

TEST(SizeRaster, OfEsriMayGiveTheCentreOfTheFirstCellOnOneAxis) {
  const auto raster = ParseEsriAscii(
      TextReader("a.asc", "ncols 2\nnrows 1\nxllcenter 10\nyllcorner 20\ncellsize 4\n1 2\n"));
  ASSERT_TRUE(raster.ok()) << raster.status();
  EXPECT_EQ(raster->box.lo, (std::array<double, 3>{8, 20, 0}));
  EXPECT_EQ(raster->box.hi, (std::array<double, 3>{16, 24, 0}));
}

TEST(SizeRaster, OfNumpyMayBeOfEitherByteOrder) {
  const Box box = Options(2, 4).box;
  const std::vector<double> expected = {1, 2};
  const std::pair<std::string, std::string> files[] = {
      {"<f8", std::string("\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\0\x40", 16)},
      {">f8", std::string("\x3f\xf0\0\0\0\0\0\0\x40\0\0\0\0\0\0\0", 16)},
      {"<f4", std::string("\0\0\x80\x3f\0\0\0\x40", 8)},
      {">f4", std::string("\x3f\x80\0\0\x40\0\0\0", 8)},
      {">i8", std::string("\0\0\0\0\0\0\0\1\0\0\0\0\0\0\0\2", 16)},
      {"<i4", std::string("\1\0\0\0\2\0\0\0", 8)},
      {">i2", std::string("\0\1\0\2", 4)},
      {"<u2", std::string("\1\0\2\0", 4)},
      {"|u1", std::string("\1\2", 2)}};
  for (const auto& [type, data] : files) {
    const auto raster = ParseNpy("a.npy", Npy("(1, 2)", type, data), box, 2);
    ASSERT_TRUE(raster.ok()) << type << ": " << raster.status();
    EXPECT_EQ(raster->values, expected) << type;
  }
}

// As programs that read maps give it: a band of rows.
TEST(SizeRaster, OfNumpyMayHaveOneLayerMore) {
  const Box box = Options(2, 4).box;
  const auto raster = ParseNpy("a.npy", Npy("(1, 2, 2)", {1, 2, 3, 4}), box, 2);
  ASSERT_TRUE(raster.ok()) << raster.status();
  EXPECT_EQ(raster->counts, (std::array<std::size_t, 3>{2, 2, 1}));
  EXPECT_EQ(SizesOf(*raster, box, 1, 2)->size(), 4U);
  // In 3D it is a raster of one layer.
  const Box cube = Options(3, 4).box;
  const auto layer = ParseNpy("a.npy", Npy("(1, 2, 2)", {1, 2, 3, 4}), cube, 3);
  ASSERT_TRUE(layer.ok()) << layer.status();
  const auto sizes = SizesOf(*layer, cube, 1, 3);
  ASSERT_TRUE(sizes.ok()) << sizes.status();
  EXPECT_EQ(TargetAt(*sizes, {3, 1, 3.9}, 3), 2);
}

TEST(SizeView, GivesNoPlaceMoreThanTheLinearLength) {
  const auto view = ParsePos("a.pos",
                             "// a comment\nView \"h\" {\nST(0,0,0, 8,0,0, 0,8,0){.25, 1, 2};\n"
                             "SP(7,7,0){.125};SL(0,0,0,1,1,0){-1,1};\n};\n");
  ASSERT_TRUE(view.ok()) << view.status();
  const auto sizes = SizesOf(*view, Options(2, 8).box, 1, 2);
  ASSERT_TRUE(sizes.ok());
  for (double x = 0.1; x < 8; x += 0.3) {
    for (double y = 0.1; x + y < 8; y += 0.3) {
      const double linear = .25 + x / 8 * .75 + y / 8 * 1.75;
      const double target = TargetAt(*sizes, {x, y, 0}, 2);
      EXPECT_LE(target, linear);
      EXPECT_GE(target, linear / 3);  // and not much less
    }
  }
  EXPECT_EQ(TargetAt(*sizes, {7, 7, 0}, 2), .125);
}

// Cut to its lengths this line would have 10^12 parts.
TEST(SizeView, DoesNotCutWhatIsOutsideTheBox) {
  const auto view =
      ParsePos("a.pos", "View \"\" {SL(100,100,0,1000,1000,0){1e-9,1e-9};SP(1,1,0){.5};};\n");
  ASSERT_TRUE(view.ok()) << view.status();
  const auto sizes = SizesOf(*view, Options(2, 8).box, 1, 2);
  ASSERT_TRUE(sizes.ok());
  EXPECT_EQ(*sizes, std::vector<Feature>{Feature::SizeAt(1, 1, 1, .5)});
}

TEST(SizeView, NumbersEndAtAnyBlank) {
  const auto view =
      ParsePos("a.pos", "View\t\"\" {\r\nSL(0\t,0\r\n,0\t, 1,1 ,0){1\r\n,2\t};\r\n};\r\n");
  ASSERT_TRUE(view.ok()) << view.status();
  EXPECT_EQ(view->elements.at(0).values, (std::vector<double>{1, 2}));
}

// A line beyond the box whose only piece's disc reaches in.
TEST(SizeView, CoversWhatADiscFromOutsideReaches) {
  for (const int dimension : {2, 3}) {
    SizeView view;
    view.file = "a.pos";
    view.elements = {{{{-3, 1, 1}, {1, 1, 1}}, {2, 2}}, {{{-9, 1, 1}, {-5, 1, 1}}, {2, 2}}};
    const Box box = Options(dimension, 8).box;
    const auto sizes = SizesOf(view, box, 1, dimension);
    ASSERT_TRUE(sizes.ok());
    ASSERT_EQ(sizes->size(), 1U);
    const Feature& f = sizes->front();
    EXPECT_GE(f.position[0], box.lo[0]);  // validation refuses centres outside
    EXPECT_EQ(TargetAt(*sizes, {.9, 1, 1}, dimension), 2);
    // What the ball of the piece has in the box is in the ball that stands for it.
    for (double y = 0; y < 3; y += 0.01) {
      const double d = std::hypot(1., y - 1);
      if (d > 2) continue;
      EXPECT_EQ(TargetAt(*sizes, {0, y, 1}, dimension), 2) << y;
    }
    EXPECT_EQ(TargetAt(*sizes, {2, 1, 1}, dimension), HUGE_VAL);
  }
}

TEST(SizeView, OfAnMtrIsOfPointsOrOfAMeshOfItsOwn) {
  const TempFolder folder;
  const std::vector<Feature> input = {Feature::Point(1, 1, 1), Feature::Point(2, 5, 5),
                                      Feature::Segment(3, 1, 2)};
  const MeshOptions options = Options(2, 8);
  folder.Write("p.mtr", "2 1\n.5\n0\n");
  auto sizes = ReadMtrFile(folder.Path("p.mtr"), {input, options, 9});
  ASSERT_TRUE(sizes.ok()) << sizes.status();
  EXPECT_EQ(*sizes, std::vector<Feature>{Feature::SizeAt(9, 1, 1, .5)});
  folder.Write("b.mtr", "3 1\n.5\n.5\n.5\n");
  folder.Write("b.node", "3 2 0 0\n1 0 0\n2 8 0\n3 0 8\n");
  folder.Write("b.ele", "1 3 0\n1 1 2 3\n");
  sizes = ReadMtrFile(folder.Path("b.mtr"), {input, options, 9});
  ASSERT_TRUE(sizes.ok()) << sizes.status();
  EXPECT_EQ(TargetAt(*sizes, {2, 2, 0}, 2), .5);
}

TEST(SizeFields, SayWhereAndWhatIsWrong) {
  const TempFolder folder;
  const std::string head = "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
  const struct {
    std::string name, text, message;
  } bad[] = {
      {"a.asc", head + "1 x\n", "a.asc:6: a value is not a finite number"},
      {"b.asc", head + "1 2\n3\n", "b.asc:7: the file has 3 values, not 2"},
      {"c.asc", "nrows 1\n1\n", "no count ncols"},
      {"d.asc", "ncols 99999\nnrows 99999\ncellsize 1\n1\n", "too short"},
      {"e.asc", "ncols 1\nnrows 1\ncellsize 0\n1\n", "e.asc:3: cellsize must be above 0"},
      {"f.asc", "ncols 2.5\n" + head.substr(8) + "1 2\n",
       "f.asc:1: ncols must be a whole number from 1 to 10^9"},
      {"g.asc", "ncols 2\nnrows 1\nyllcorner 0\ncellsize 1\n1 2\n",
       "g.asc:5: the header has no xllcorner"},
      {"h.asc", "yllcenter 0\n" + head + "1 2\n",
       "h.asc:7: the header has both yllcorner and yllcenter"},
      {"e.npy", Npy("(1, 2)", "<c16", std::string(32, 'x')), "type '<c16' cannot be read"},
      {"f.npy", Npy("(2, 1, 2)", {1, 2, 3, 4}), "the array has 3 dimensions, the mesh 2"},
      {"e.pos", "View \"h\" {\nSP(1,1,0){1};};\n" + std::string(1, '\0'), "e.pos:3: expected View"},
      {"f.pos", "View \"h\" {\nSP(1,1,0){1};", "f.pos:2: the file ends before }"},
      {"g.pos", "View \"h\" {\nSP(1,1,0){1,", "g.pos:2: not a finite number: ''"},
      {"a.npy", "numpy", "a.npy: not a file of numpy"},
      {"b.npy", Npy("(2, 2)", {1, 2, 3}), "24 bytes, not 32"},
      {"c.npy", Npy("(2,)", {1, 2}), "the array has 1 dimensions, the mesh 2"},
      {"d.npy", Npy("(0, 2)", {}), "the shape is"},
      {"a.pos", "View \"h\" {\nSQ(0,0,0){1};};", "a.pos:2: elements 'SQ' cannot be read"},
      {"b.pos", "View \"h\" {\nST(0,0,0){1};};", "b.pos:2: ST takes 9 coordinates and 3 values"},
      {"c.pos", "View \"h\" {\nSP(0,0,x){1};};", "c.pos:2: not a finite number: 'x'"},
      {"d.pos", "nothing", "d.pos:1: expected View"},
      {"a.mtr", "2 3\n1 2 3\n", "a.mtr:1: only a length for each point"},
      {"b.mtr", "2 1\n1\n", "the file ends after 1 lengths"},
      {"c.mtr", "1 1\n1\n", "c.mtr:1: 1 lengths for 0 points"},
  };
  const std::vector<Feature> none;
  const MeshOptions options = Options(2, 1);
  for (const auto& [name, text, message] : bad) {
    folder.Write(name, text);
    const auto read = name.ends_with("asc")   ? ReadAscFile
                      : name.ends_with("npy") ? ReadNpyFile
                      : name.ends_with("pos") ? ReadPosFile
                                              : ReadMtrFile;
    const auto sizes = read(folder.Path(name), {none, options, 1});
    ASSERT_FALSE(sizes.ok()) << name;
    EXPECT_NE(std::string(sizes.status().message()).find(message), std::string::npos)
        << sizes.status();
  }
  EXPECT_EQ(ReadAscFile(folder.Path("no.asc"), {none, options, 1}).status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace dynmesh::io
