// .vtu and .svg.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/io/meshes/vtu_writer.h"
#include "core/io/pictures/colour_ramp.h"
#include "core/io/pictures/svg_writer.h"
#include "gtest/gtest.h"
#include "tests/core/io/common/vtu_values.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/support/count_of.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::CountOf;
using test::TempFolder;
using testing::SampleMesh;
using testing::SampleMeshWithRegions;
using testing::VtuValues;

TEST(Vtu, HoldsTheMeshExactly) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(SampleMesh()).value();
  ASSERT_TRUE(WriteVtu(mesh, kDefaultQuality2D, folder.Path("m.vtu")).ok());
  const std::string xml = folder.Read("m.vtu");
  EXPECT_NE(xml.find("NumberOfPoints=\"9\" NumberOfCells=\"13\""), std::string::npos);
  const auto points = VtuValues<double>(xml, "Points");
  ASSERT_EQ(points.size(), 27U);
  const auto owners = VtuValues<std::int64_t>(xml, "owner");
  const auto dimensions = VtuValues<std::uint8_t>(xml, "containing_dimension");
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(points[3 * i], mesh.vertices[i].x);
    EXPECT_EQ(points[3 * i + 1], mesh.vertices[i].y);
    EXPECT_EQ(points[3 * i + 2], 0);
    EXPECT_EQ(dimensions[i], mesh.vertices[i].containing_dimension);
    EXPECT_EQ(owners[i], mesh.vertices[i].owner == kBoxFeature
                             ? -1
                             : static_cast<std::int64_t>(mesh.vertices[i].owner));
  }
  const auto corners = VtuValues<std::int64_t>(xml, "connectivity");
  ASSERT_EQ(corners.size(), 37U);  // with the two subsegments of segment 30
  for (std::size_t i = 0; i < 33; ++i) EXPECT_EQ(corners[i], mesh.triangles[i / 3][i % 3]);
  EXPECT_EQ(VtuValues<std::int64_t>(xml, "offsets")[10], 33);
  std::vector<std::uint8_t> types(11, 5);
  types.insert(types.end(), 2, 3);
  EXPECT_EQ(VtuValues<std::uint8_t>(xml, "types"), types);
  std::vector<std::int64_t> cell_owners(11, 0);
  cell_owners.insert(cell_owners.end(), 2, 30);
  EXPECT_EQ(VtuValues<std::int64_t>(xml.substr(xml.find("<CellData")), "owner"), cell_owners);
  const auto ratios = VtuValues<double>(xml, "quality");
  const auto angles = VtuValues<double>(xml, "min_angle");
  ASSERT_EQ(ratios.size(), 13U);
  ASSERT_EQ(angles.size(), 13U);
  for (std::size_t i = 0; i < 11; ++i) {
    const TriangleQuality q = MeasureTriangle(mesh, i);
    EXPECT_EQ(ratios[i], q.radius_edge);
    EXPECT_EQ(angles[i], q.min_angle_deg);
  }
  EXPECT_EQ(VtuValues<std::int64_t>(xml, "radius_edge"), VtuValues<std::int64_t>(xml, "quality"));
  EXPECT_EQ(VtuValues<std::int64_t>(xml, "min_angle_deg"),
            VtuValues<std::int64_t>(xml, "min_angle"));
  EXPECT_EQ(VtuValues<std::uint8_t>(xml, "exempt"), std::vector<std::uint8_t>(13, 0));
}

// Two segments from the origin, an angle of a few degrees apart, each cut at distance 4: the
// edge between the cuts is as short as the angle makes it.
IndexedMesh Wedge() {
  IndexedMesh mesh;
  const double c = std::cos(0.05), s = std::sin(0.05);
  mesh.vertices = {{0, 0, 0, 1},           {8, 0, 0, 2},         {8 * c, 8 * s, 0, 3},
                   {4, 0, 1, 4},           {4 * c, 4 * s, 1, 5}, {4, -4, 2, kNoFeature},
                   {12, -4, 2, kNoFeature}};
  mesh.triangles = {{0, 3, 4}, {0, 5, 3}, {1, 3, 6}, {3, 1, 2}};
  mesh.edges = {{0, 3, 4}, {1, 3, 4}, {0, 4, 5}, {2, 4, 5}};
  return mesh;
}

TEST(Vtu, TellsWhatASmallInputAngleExcuses) {
  const TempFolder folder;
  const IndexedMesh mesh = Wedge();
  const std::vector<SimplexVerdict> verdicts = JudgeSimplices(mesh, 1.0);
  ASSERT_EQ(verdicts.size(), 4U);
  // 0-3-4 has the short edge; 3-1-2 is as bad, but its short edge joins input points.
  EXPECT_EQ(verdicts[0], SimplexVerdict::kSmallInputAngle);
  EXPECT_EQ(verdicts[3], SimplexVerdict::kOverRho);
  ASSERT_TRUE(WriteVtu(mesh, 1.0, folder.Path("m.vtu")).ok());
  const std::vector<std::uint8_t> expected = {1, 0, 0, 0, 0, 0, 0, 0};  // four of them are of lines
  EXPECT_EQ(VtuValues<std::uint8_t>(folder.Read("m.vtu"), "exempt"), expected);
  // Within a generous rho nothing needs an excuse.
  ASSERT_TRUE(WriteVtu(mesh, 100.0, folder.Path("m.vtu")).ok());
  EXPECT_EQ(VtuValues<std::uint8_t>(folder.Read("m.vtu"), "exempt"),
            std::vector<std::uint8_t>(8, 0));
}

TEST(Vtu, SaysWhichRegionATriangleIsInAndWhatThatMeans) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(SampleMeshWithRegions()).value();
  ASSERT_TRUE(WriteVtu(mesh, kDefaultQuality2D, folder.Path("m.vtu")).ok());
  const std::string xml = folder.Read("m.vtu");
  std::vector<std::uint32_t> regions = mesh.regions.numbers;
  regions.resize(regions.size() + 2, 0);  // of the subsegments
  EXPECT_EQ(VtuValues<std::uint32_t>(xml, "region"), regions);
  EXPECT_EQ(VtuValues<std::int64_t>(xml, "region_polygons"),
            (std::vector<std::int64_t>{12, 12, 40, 40, 40, -2}));
  EXPECT_EQ(VtuValues<std::int64_t>(xml, "region_ends"), (std::vector<std::int64_t>{1, 3, 4, 6}));
  EXPECT_NE(xml.find("Name=\"region_polygons\" NumberOfTuples=\"6\""), std::string::npos);
  EXPECT_LT(xml.find("</FieldData>"), xml.find("<Piece"));
  // Without polygons the file is what it was before there were any.
  ASSERT_TRUE(WriteVtu(IndexMesh(SampleMesh()).value(), 2, folder.Path("m.vtu")).ok());
  EXPECT_EQ(folder.Read("m.vtu").find("region"), std::string::npos);
}

TEST(Vtu, OfNothingIsStillAFile) {
  const TempFolder folder;
  ASSERT_TRUE(WriteVtu(IndexedMesh(), kDefaultQuality2D, folder.Path("m.vtu")).ok());
  EXPECT_EQ(VtuValues<double>(folder.Read("m.vtu"), "Points"), std::vector<double>());
}

TEST(Svg, DrawsEveryTriangleOnceAndSegmentsOnTop) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(SampleMesh()).value();
  SvgOptions options;
  options.width = 640;
  ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  const std::string svg = folder.Read("m.svg");
  EXPECT_NE(svg.find("viewBox=\"0 0 640 "), std::string::npos);
  EXPECT_EQ(CountOf(svg, "z"), 11U);             // one closed path a triangle
  EXPECT_EQ(CountOf(svg, "fill=\"none\""), 3U);  // edges, box, segments
  EXPECT_EQ(CountOf(svg, "<circle"), 2U);
  EXPECT_LT(svg.find("#7a8794"), svg.find("stroke=\"#14213d\""));
}

// How many triangles are drawn in a colour.
std::size_t Filled(const std::string& svg, const std::string& colour) {
  const std::size_t at = svg.find("<path fill=\"" + colour + "\"");
  return at == std::string::npos ? 0 : CountOf(svg.substr(at, svg.find("/>", at) - at), "z");
}

TEST(Svg, ShowsWhatIsExempt) {
  const TempFolder folder;
  SvgOptions options;
  options.fill = SvgOptions::Fill::kExempt;
  options.rho = 1;
  const std::vector<SimplexVerdict> verdicts = JudgeSimplices(Wedge(), 1);
  ASSERT_TRUE(WriteSvg(Wedge(), options, folder.Path("m.svg")).ok());
  const std::string svg = folder.Read("m.svg");
  const auto count = [&](SimplexVerdict verdict) {
    return static_cast<std::size_t>(std::count(verdicts.begin(), verdicts.end(), verdict));
  };
  EXPECT_EQ(Filled(svg, "#f6a821"), 1U);
  EXPECT_EQ(Filled(svg, "#b2182b"), count(SimplexVerdict::kOverRho));
  EXPECT_EQ(Filled(svg, "#eaf1f6"), count(SimplexVerdict::kGood));
  for (const char* label : {">within rho<", ">over rho, exempt<", ">over rho<"}) {
    EXPECT_EQ(CountOf(svg, label), 1U) << label;
  }
  EXPECT_EQ(CountOf(svg, "dihedral"), 0U);
}

TEST(Svg, RegionsHaveColoursOfTheirOwn) {
  const TempFolder folder;
  SvgOptions options;
  options.fill = SvgOptions::Fill::kRegion;
  const IndexedMesh mesh = IndexMesh(SampleMeshWithRegions()).value();
  ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  const std::string svg = folder.Read("m.svg");
  EXPECT_EQ(Filled(svg, "#eaf1f6"), 4U);
  const std::size_t expected[] = {0, 1, 4, 1, 1};
  for (std::size_t k = 1; k <= 4; ++k) EXPECT_EQ(Filled(svg, DistinctColour(k)), expected[k]) << k;
  ASSERT_TRUE(WriteSvg(IndexMesh(SampleMesh()).value(), options, folder.Path("m.svg")).ok());
  EXPECT_EQ(Filled(folder.Read("m.svg"), "#eaf1f6"), 11U);
}

TEST(Svg, QualityIsRedOverRhoOnly) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(SampleMesh()).value();
  for (const double rho : {1.0, 2.0, 100.0}) {
    SvgOptions options;
    options.fill = SvgOptions::Fill::kQuality;
    options.rho = rho;
    ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
    std::size_t over = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      over += MeasureTriangle(mesh, i).radius_edge > rho ? 1 : 0;
    }
    EXPECT_EQ(Filled(folder.Read("m.svg"), "#b2182b"), over) << rho;
  }
}

TEST(Svg, LeavesOutWhatIsFarFromTheCrop) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(SampleMesh()).value();
  SvgOptions options;
  options.fill = SvgOptions::Fill::kPlain;
  options.crop = Box{{0, 4, 0}, {0.1, 4.1, 1}};  // inside the triangle at the left side
  ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  // This triangle and two with bounding boxes that reach there, of eleven.
  EXPECT_EQ(CountOf(folder.Read("m.svg"), "z"), 3U);
}

TEST(Svg, HighlightsWhatIsAsked) {
  const TempFolder folder;
  const Mesh mesh = SampleMesh();
  const IndexedMesh indexed = IndexMesh(mesh).value();
  SvgOptions options;
  options.fill = SvgOptions::Fill::kNone;
  options.highlight =
      FindSimplices(indexed, {mesh.simplices[0], mesh.simplices[1], mesh.simplices[2], 1, 2, 3});
  ASSERT_EQ(options.highlight.size(), 1U);
  options.highlight.push_back(999);  // nothing there: nothing drawn
  ASSERT_TRUE(WriteSvg(indexed, options, folder.Path("m.svg")).ok());
  EXPECT_EQ(CountOf(folder.Read("m.svg"), "z"), 1U);
}

TEST(Svg, TakesOddOptionsWithoutHarm) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(SampleMesh()).value();
  SvgOptions options;
  options.crop = Box{{5, 2, 0}, {5, 2, 1}};  // no extent
  EXPECT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  options.crop = Box{{5, 2, 0}, {5 + 1e-15, 2 + 1e-15, 1}};
  EXPECT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  EXPECT_EQ(CountOf(folder.Read("m.svg"), "nan"), 0U);
  options = {};
  options.fill = SvgOptions::Fill::kSize;
  EXPECT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  EXPECT_TRUE(WriteSvg(IndexedMesh(), options, folder.Path("m.svg")).ok());
  options.width = std::nan("");
  EXPECT_FALSE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  options.width = 100;
  options.rho = std::nan("");
  EXPECT_FALSE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  options = {};
  options.fill = SvgOptions::Fill::kExempt;
  for (const double width : {1.0, 100.0, 1e5}) {
    options.width = width;
    EXPECT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
    EXPECT_EQ(CountOf(folder.Read("m.svg"), "nan"), 0U);
  }
  for (const double degrees : {-1.0, 21.0, std::nan("")}) {
    options.min_dihedral = degrees;
    EXPECT_FALSE(WriteSvg(mesh, options, folder.Path("m.svg")).ok()) << degrees;
  }
  options = {};
  options.fill = SvgOptions::Fill::kDihedral;  // in 2D
  EXPECT_EQ(WriteSvg(mesh, options, folder.Path("m.svg")).code(),
            absl::StatusCode::kInvalidArgument);
  for (const char* fill :
       {"angle", "dihedral", "quality", "size", "exempt", "region", "plain", "none"}) {
    EXPECT_TRUE(ParseFill(fill).ok()) << fill;
  }
  EXPECT_FALSE(ParseFill("blue").ok());
}

}  // namespace
}  // namespace dynmesh::io
