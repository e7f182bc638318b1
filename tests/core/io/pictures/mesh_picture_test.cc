// The cut through a 3D mesh, and its picture.
#include "core/io/pictures/mesh_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "core/io/pictures/svg_writer.h"
#include "gtest/gtest.h"
#include "tests/core/io/meshes/good_space_mesh.h"
#include "tests/core/mesh_data/made_up_mesh.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;
using testing::kPlate;
using testing::MakeGoodSpaceMesh;
using testing::MakeRandom;

double AreaOf(const MeshPicture& picture, const MeshPicture::Cell& cell) {
  double twice = 0;
  for (std::uint32_t k = 0; k < cell.count; ++k) {
    const auto& p = picture.positions[cell.corners[k]];
    const auto& q = picture.positions[cell.corners[(k + 1) % cell.count]];
    twice += p[0] * q[1] - p[1] * q[0];
  }
  return std::abs(twice) / 2;
}

// Cells fill the cut of the box, at random heights and right through vertices.
TEST(CutThrough, FillsTheBox) {
  testing::Random random = MakeRandom();
  for (int round = 0; round < 12; ++round) {
    const IndexedMesh mesh =
        IndexMesh(MakeGoodSpaceMesh(random(), 80, round % 2 == 0).mesh).value();
    const double at = round % 3 == 0 ? 4 : static_cast<double>(random() % 7999 + 1) / 1000;
    const int axis = round % 3;
    const MeshPicture picture = CutThrough(mesh, axis, at);
    double area = 0;
    std::set<std::uint32_t> simplices;
    for (const MeshPicture::Cell& cell : picture.cells) {
      area += AreaOf(picture, cell);
      EXPECT_TRUE(simplices.insert(cell.simplex).second);
      for (std::uint32_t k = 0; k < cell.count; ++k) {
        for (std::uint32_t j = 0; j < k; ++j) EXPECT_NE(cell.corners[j], cell.corners[k]);
      }
    }
    EXPECT_NEAR(area, 64, 1e-9);
    // Each line inside is a side of two cells, each on the box of one.
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const MeshPicture::Cell& cell : picture.cells) {
      for (std::uint32_t k = 0; k < cell.count; ++k) {
        ++sides[std::minmax(cell.corners[k], cell.corners[(k + 1) % cell.count])];
      }
    }
    double around = 0;
    for (const auto& line : picture.lines) {
      const auto side = sides.find({line.a, line.b});
      ASSERT_TRUE(side != sides.end());
      if (line.owner != kBoxFeature) {
        EXPECT_EQ(side->second, 2);
        continue;
      }
      EXPECT_EQ(side->second, 1);
      const auto &p = picture.positions[line.a], &q = picture.positions[line.b];
      around += std::hypot(p[0] - q[0], p[1] - q[1]);
    }
    EXPECT_NEAR(around, 32, 1e-9);
    EXPECT_EQ(picture.lines.size(), sides.size());
  }
}

// The plate is a square of 3 with a hole of 1: where y is 4.2, two lines of one each.
TEST(CutThrough, ShowsWherePolygonsAreCut) {
  testing::Random random = MakeRandom();
  const IndexedMesh mesh = IndexMesh(MakeGoodSpaceMesh(random(), 80).mesh).value();
  double length = 0;
  const MeshPicture picture = CutThrough(mesh, 1, 4.2);
  for (const auto& line : picture.lines) {
    if (line.owner != kPlate) continue;
    const auto &p = picture.positions[line.a], &q = picture.positions[line.b];
    length += std::hypot(p[0] - q[0], p[1] - q[1]);
    for (const auto& [x, z] : {p, q}) EXPECT_NEAR((z - 4) / (x - 4), 0.75, 1e-9);
  }
  EXPECT_NEAR(length, 2, 1e-9);
}

TEST(CutThrough, BesideTheMeshShowsNothing) {
  const IndexedMesh mesh = IndexMesh(MakeGoodSpaceMesh(3, 20).mesh).value();
  for (const double at : {-1.0, 9.0, std::numeric_limits<double>::infinity()}) {
    const MeshPicture picture = CutThrough(mesh, 0, at);
    EXPECT_TRUE(picture.cells.empty() && picture.lines.empty());
  }
}

TEST(Svg, OfAMeshOfSpaceShowsACut) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(MakeGoodSpaceMesh(3, 60).mesh).value();
  using Fill = SvgOptions::Fill;
  for (const Fill fill : {Fill::kAngle, Fill::kDihedral, Fill::kQuality, Fill::kSize, Fill::kExempt,
                          Fill::kRegion, Fill::kPlain, Fill::kNone}) {
    SvgOptions options;
    options.fill = fill;
    options.cut_axis = 1;
    options.cut_at = 4.25;
    ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
    const std::string svg = folder.Read("m.svg");
    EXPECT_NE(svg.find(" tetrahedra, cut at y = 4.25</title>"), std::string::npos);
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    if (fill != Fill::kNone) {
      // Each cell is a closed path.
      const std::size_t cells = CutThrough(mesh, 1, 4.25).cells.size();
      EXPECT_EQ(static_cast<std::size_t>(std::count(svg.begin(), svg.end(), 'z')), cells);
    }
  }
  SvgOptions options;
  ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  EXPECT_NE(folder.Read("m.svg").find("cut at z = 4</title>"), std::string::npos);
  options.cut_axis = 3;
  EXPECT_EQ(WriteSvg(mesh, options, folder.Path("m.svg")).code(),
            absl::StatusCode::kInvalidArgument);
}

// From a fill's paths to the first line, what a picture draws.
std::string FillsOf(const std::string& svg) {
  const std::size_t from = svg.find("<path");
  return svg.substr(from, svg.find("<path fill=\"none\"") - from);
}

TEST(Svg, OfDihedralAnglesHasTheColoursOfAngleAndALegend) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(MakeGoodSpaceMesh(3, 60).mesh).value();
  SvgOptions options;
  ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("a.svg")).ok());
  options.fill = SvgOptions::Fill::kDihedral;
  ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("d.svg")).ok());
  const std::string svg = folder.Read("d.svg");
  EXPECT_EQ(FillsOf(svg), FillsOf(folder.Read("a.svg")));
  EXPECT_NE(svg.find(">least dihedral angle, degrees<"), std::string::npos);
  for (const char* tick : {">0<", ">10<", ">70<"}) EXPECT_NE(svg.find(tick), std::string::npos);
  EXPECT_EQ(svg.find(">80<"), std::string::npos);
}

TEST(Svg, ShowsWhatIsBelowADihedralAngleInAColourOfItsOwn) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(MakeGoodSpaceMesh(3, 60).mesh).value();
  SvgOptions options;
  options.fill = SvgOptions::Fill::kExempt;
  options.rho = 3;
  constexpr char kColour[] = "<path fill=\"#7b3294\"";
  ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  EXPECT_EQ(folder.Read("m.svg").find("#7b3294"), std::string::npos);
  options.min_dihedral = 20;
  ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  const std::string svg = folder.Read("m.svg");
  EXPECT_NE(svg.find(">dihedral angle below 20 degrees<"), std::string::npos);
  const std::vector<SimplexVerdict> verdicts = JudgeSimplices(mesh, 3, 20);
  std::ptrdiff_t expected = 0;
  for (const MeshPicture::Cell& cell : CutThrough(mesh, 2, 4).cells) {
    expected += verdicts[cell.simplex] == SimplexVerdict::kBelowDihedral;
  }
  ASSERT_GT(expected, 0);
  const std::size_t at = svg.find(kColour);
  ASSERT_NE(at, std::string::npos);
  const std::string path = svg.substr(at, svg.find("/>", at) - at);
  EXPECT_EQ(std::count(path.begin(), path.end(), 'z'), expected);
}

}  // namespace
}  // namespace dynmesh::io
