// Leaves of quadtrees in files.
#include "core/io/quadtrees/leaf_list.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/io/pictures/leaf_svg.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/support/count_of.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::CountOf;

MeshOptions Options(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  options.kind = MeshKind::kQuadtree;
  return options;
}

LeafList Sample(int dimension) {
  const std::vector<Feature> features = {Feature::Point(1, 0.1, 0.3, 0.5),
                                         Feature::Point(2, 0.1, 0.31, 0.5),
                                         Feature::Point(3, 0.9, 0.7, 0.25)};
  const MeshOptions options = Options(dimension);
  return *LeavesOf(*BuildMesh(features, options), options);
}

TEST(LeafList, CsvReadsBackToTheBit) {
  test::TempFolder folder;
  for (const int dimension : {2, 3}) {
    const LeafList list = Sample(dimension);
    ASSERT_TRUE(WriteLeafCsv(list, folder.Path("t.csv")).ok());
    const auto back = ReadLeafCsv(folder.Path("t.csv"));
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->dimension, dimension);
    ASSERT_EQ(back->leaves.size(), list.leaves.size());
    for (std::size_t i = 0; i < list.leaves.size(); ++i) {
      EXPECT_EQ(back->leaves[i].centre, list.leaves[i].centre);
      EXPECT_EQ(back->leaves[i].cell.side, list.leaves[i].cell.side);
      EXPECT_EQ(back->leaves[i].cell.level, list.leaves[i].cell.level);
    }
  }
}

TEST(LeafList, CsvMayHaveBlanksAndOtherLineEnds) {
  test::TempFolder folder;
  folder.Write("t.csv", "x,y,side,level\r\n1,1,2,0\r\n\r\n");
  const auto list = ReadLeafCsv(folder.Path("t.csv"));
  ASSERT_TRUE(list.ok()) << list.status();
  EXPECT_EQ(list->leaves.size(), 1u);
}

TEST(LeafList, BadCsvIsNamedByItsLine) {
  test::TempFolder folder;
  const std::pair<const char*, const char*> bad[] = {
      {"", ":1: "},
      {"x,y\n", ":1: expected the first line"},
      {"x,y,side,level\n1,1,2\n", ":2: expected 4 values, found 3"},
      {"x,y,side,level\n1,1,2,0\n1,nan,2,0\n", ":3: no finite coordinate"},
      {"x,y,side,level\n1,1,0,0\n", ":2: no side above 0"},
      {"x,y,side,level\n1,1,2,-1\n", ":2: no level"},
      {"x,y,z,side,level\n1,1,2,0\n", ":2: expected 5 values"}};
  for (const auto& [text, message] : bad) {
    folder.Write("t.csv", text);
    const auto list = ReadLeafCsv(folder.Path("t.csv"));
    ASSERT_FALSE(list.ok()) << text;
    EXPECT_NE(list.status().message().find(message), absl::string_view::npos) << list.status();
  }
  EXPECT_EQ(ReadLeafCsv(folder.Path("none.csv")).status().code(), absl::StatusCode::kNotFound);
}

TEST(LeafList, AVertexThatIsNoCentreIsRefused) {
  const MeshOptions options = Options(2);
  Mesh mesh = *BuildMesh({}, options);
  mesh.vertices.coordinates[0] += 0.1;
  EXPECT_EQ(LeavesOf(mesh, options).status().code(), absl::StatusCode::kDataLoss);
}

TEST(LeafList, VtuSharesCorners) {
  test::TempFolder folder;
  const LeafList root = *LeavesOf(*BuildMesh({}, Options(3)), Options(3));
  ASSERT_TRUE(WriteLeafVtu(root, folder.Path("t.vtu")).ok());
  EXPECT_NE(folder.Read("t.vtu").find("NumberOfPoints=\"8\" NumberOfCells=\"1\""),
            std::string::npos);
  const std::vector<Feature> two = {Feature::Point(1, 0, 0), Feature::Point(2, 1, 1)};
  const LeafList list = *LeavesOf(*BuildMesh(two, Options(2)), Options(2));
  ASSERT_TRUE(WriteLeafVtu(list, folder.Path("t.vtu")).ok());
  const std::string text = folder.Read("t.vtu");
  EXPECT_NE(text.find("NumberOfCells=\"" + std::to_string(list.leaves.size()) + "\""),
            std::string::npos);
  for (const char* name : {"\"level\"", "\"side\"", "\"id\"", "\"connectivity\""}) {
    EXPECT_NE(text.find(name), std::string::npos) << name;
  }
}

TEST(LeafList, APictureHasASquareForEachLeafInView) {
  test::TempFolder folder;
  SvgOptions svg;
  svg.fill = SvgOptions::Fill::kSize;
  const LeafList list = Sample(2);
  ASSERT_TRUE(WriteLeafSvg(list, svg, folder.Path("t.svg")).ok());
  std::string text = folder.Read("t.svg");
  EXPECT_EQ(CountOf(text, "M"), list.leaves.size());
  EXPECT_EQ(CountOf(text, "<text"), 0u);
  svg.legend = true;
  ASSERT_TRUE(WriteLeafSvg(list, svg, folder.Path("t.svg")).ok());
  text = folder.Read("t.svg");
  EXPECT_EQ(CountOf(text, ">side of a cell<"), 1u);
  EXPECT_EQ(CountOf(text, "<text"), 3u);  // with the sides of the finest and the coarsest leaves
  svg.legend = false;
  svg.crop = Box{{0, 0, 0}, {0.01, 0.01, 0}};
  ASSERT_TRUE(WriteLeafSvg(list, svg, folder.Path("t.svg")).ok());
  EXPECT_EQ(CountOf(folder.Read("t.svg"), "M"), 1u);
  // The squares of a cut cover the root's side of the octree.
  svg.crop.reset();
  const LeafList octree = Sample(3);
  double area = 0;
  for (const LeafList::Leaf& leaf : octree.leaves) {
    if (leaf.cell.box.lo[2] <= 0.5 && 0.5 < leaf.cell.box.hi[2])
      area += std::pow(leaf.cell.side, 2);
  }
  EXPECT_EQ(area, 4);
  svg.cut_at = 0.5;
  ASSERT_TRUE(WriteLeafSvg(octree, svg, folder.Path("t.svg")).ok());
  text = folder.Read("t.svg");
  EXPECT_EQ(
      CountOf(text, "M"),
      static_cast<std::size_t>(std::ranges::count_if(octree.leaves, [](const LeafList::Leaf& leaf) {
        return leaf.cell.box.lo[2] <= 0.5 && 0.5 < leaf.cell.box.hi[2];
      })));
  svg.fill = SvgOptions::Fill::kAngle;
  EXPECT_FALSE(WriteLeafSvg(octree, svg, folder.Path("t.svg")).ok());
}

}  // namespace
}  // namespace dynmesh::io
