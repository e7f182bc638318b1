#include "core/io/script/edit_script.h"

#include <bit>
#include <random>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

absl::StatusOr<EditScript> Parse(std::string text, bool require_header = true) {
  return ParseEditScript(TextReader("s.txt", std::move(text)), {require_header});
}

TEST(EditScript, IsReadLineByLine) {
  const auto script = Parse(
      "# a script\n"
      "mesh dim=2 box=-1,-2,3,4.5 rho=1.25 criterion=thesis\n"
      "add segment 3 1 2   # before its points\n"
      "add point 1 0.5 -0\n"
      "add point 2 1 1e-3\n"
      "commit\n"
      "commit\n"
      "move point 1 2 2\n"
      "set point 2 3 3\n"
      "set segment 3 2 1\n"
      "commit\n"
      "remove 3\n");
  ASSERT_TRUE(script.ok()) << script.status();
  EXPECT_TRUE(script->has_header);
  const MeshOptions options = script->Options();
  EXPECT_EQ(options.box.lo[0], -1);
  EXPECT_EQ(options.box.lo[1], -2);
  EXPECT_EQ(options.box.hi[0], 3);
  EXPECT_EQ(options.box.hi[1], 4.5);
  EXPECT_EQ(options.quality, 1.25);
  EXPECT_EQ(options.criterion, Criterion::kThesis);
  ASSERT_EQ(script->batches.size(), 3U);  // the empty one is none
  EXPECT_EQ(script->batches[0].edits, (EditBatch{Edit::Add(Feature::Segment(3, 1, 2)),
                                                 Edit::Add(Feature::Point(1, 0.5, -0.0)),
                                                 Edit::Add(Feature::Point(2, 1, 1e-3))}));
  EXPECT_EQ(script->batches[0].lines, (std::vector<int>{3, 4, 5}));
  EXPECT_EQ(script->batches[1].edits,
            (EditBatch{Edit::Move(1, 2, 2), Edit::Set(Feature::Point(2, 3, 3)),
                       Edit::Set(Feature::Segment(3, 2, 1))}));
  EXPECT_EQ(script->batches[2].edits, (EditBatch{Edit::Remove(3)}));
  EXPECT_EQ(script->Where(1, 2), "s.txt:10");
  EXPECT_EQ(script->Where(1, std::nullopt), "s.txt:8");
  EXPECT_EQ(script->Where(9, 0), "s.txt");
}

TEST(EditScript, WithoutABoxTakesThatOfItsPoints) {
  const auto script =
      Parse("mesh\nadd point 1 3 4\nset point 1 -1 5\nmove point 1 0 9\nremove 1\n");
  ASSERT_TRUE(script.ok()) << script.status();
  const MeshOptions options = script->Options();
  EXPECT_EQ(options.box.lo[0], -1);
  EXPECT_EQ(options.box.lo[1], 4);
  EXPECT_EQ(options.box.hi[0], 3);
  EXPECT_EQ(options.box.hi[1], 9);
  EXPECT_EQ(options.quality, kDefaultQuality2D);
  EXPECT_EQ(options.criterion, Criterion::kEdge);
  EXPECT_EQ(Parse("mesh\n")->Options().box, Box());
}

TEST(EditScript, HasPolygonsOfAnyNumberOfRings) {
  const auto script = Parse(
      "mesh\n"
      "add polygon 9 1 2 3\n"
      "set polygon 9 1 2 3 4 / 5 6 7 / 3 2 1\n"
      "add size 10 polygon 1 2 3 0.5\n"
      "set size 10 polygon 1 2 3 / 4 5 6 7\n");  // the last number is always the length
  ASSERT_TRUE(script.ok()) << script.status();
  ASSERT_EQ(script->batches.size(), 1U);
  EXPECT_EQ(script->batches[0].edits,
            (EditBatch{Edit::Add(Feature::Polygon(9, {{1, 2, 3}})),
                       Edit::Set(Feature::Polygon(9, {{1, 2, 3, 4}, {5, 6, 7}, {3, 2, 1}})),
                       Edit::Add(Feature::SizePolygon(10, {{1, 2, 3}}, 0.5)),
                       Edit::Set(Feature::SizePolygon(10, {{1, 2, 3}, {4, 5, 6}}, 7))}));
}

TEST(EditScript, SaysWhatStaysWhole) {
  const auto script = Parse(
      "mesh\n"
      "add segment 3 1 2 unsplit\n"
      "set segment 3 1 2\n"
      "add polygon 9 1 2 3 / 4 5 6 unsplit  # whole\n");
  ASSERT_TRUE(script.ok()) << script.status();
  const EditBatch wanted = {Edit::Add(Feature::Segment(3, 1, 2).Unsplit()),
                            Edit::Set(Feature::Segment(3, 1, 2)),
                            Edit::Add(Feature::Polygon(9, {{1, 2, 3}, {4, 5, 6}}).Unsplit())};
  EXPECT_EQ(script->batches.at(0).edits, wanted);
  std::string text = "mesh\n";
  for (const Edit& edit : wanted) text += FormatEdit(edit, 2) + "\n";
  EXPECT_EQ(Parse(text)->batches.at(0).edits, wanted);
  for (const char* bad :
       {"add segment 3 1 unsplit", "add segment 3 1 2 whole", "add segment 3 1 2 unsplit unsplit",
        "add polygon 9 unsplit", "add polygon 9 1 2 3 / unsplit", "add point 1 0 0 unsplit"}) {
    EXPECT_FALSE(Parse(std::string("mesh\n") + bad + "\n").ok()) << bad;
  }
}

TEST(EditScript, HasCapsulesOfAnyNumberOfVertices) {
  const auto script = Parse(
      "mesh\n"
      "add size 4 capsule 1 2 3 4 0.5 0.25\n"
      "set size 4 capsule 1 2 3 4 5 6 -1 0 0.5 0.25\n"
      "set size 4 capsule 1 2 0.5 0.25\n");  // validation asks for a second vertex
  ASSERT_TRUE(script.ok()) << script.status();
  EXPECT_EQ(
      script->batches[0].edits,
      (EditBatch{Edit::Add(Feature::SizeCapsule(4, {{1, 2}, {3, 4}}, 0.5, 0.25)),
                 Edit::Set(Feature::SizeCapsule(4, {{1, 2}, {3, 4}, {5, 6}, {-1, 0}}, 0.5, 0.25)),
                 Edit::Set(Feature::SizeCapsule(4, {{1, 2}}, 0.5, 0.25))}));
  EXPECT_EQ(script->Options().box, (Box{{-1, 0, 0}, {5, 6, 1}}));
  std::string text = "mesh\n";
  for (const Edit& edit : script->batches[0].edits) text += FormatEdit(edit, 2) + "\n";
  EXPECT_EQ(Parse(text)->batches[0].edits, script->batches[0].edits) << text;
  std::vector<Feature> features;
  for (const Edit& edit : script->batches[0].edits) features.push_back(edit.feature);
  EXPECT_EQ(BoundingBox(features), script->Options().box);
}

Feature Labelled(Feature feature, FeatureLabel label) {
  feature.label = std::move(label);
  return feature;
}

TEST(EditScript, LabelsGoIntoTheBatchesThatTheyStandIn) {
  const auto script = Parse(
      "mesh\n"
      "marker 4 7\n"  // of a point that comes later
      "add point 1 0 0\n"
      "add point 2 1 0\n"
      "marker 1 5\n"
      "name 1 The corner\n"
      "name 9 Of the mesh\n"  // the script does not add it
      "commit\n"
      "marker 2 3\n"
      "commit\n"  // no batch by itself: the line belongs to the next
      "set point 2 1 1\n"
      "remove 1\n"
      "marker 1 6\n"
      "add point 4 0 1\n"
      "commit\n"
      "add point 1 0 0\n"
      "remove 4\n"
      "add point 4 1 0\n"
      "marker 4 0\n"
      "commit\n"
      "name 2 Behind\n");
  ASSERT_TRUE(script.ok()) << script.status();
  ASSERT_EQ(script->batches.size(), 3U);
  for (const ScriptBatch& batch : script->batches) {
    for (const Edit& edit : batch.edits) EXPECT_FALSE(edit.feature.label) << "for files only";
  }
  const std::vector<ScriptBatch> batches = LabelledBatches(*script);
  ASSERT_EQ(batches.size(), 3U);
  EXPECT_EQ(batches[0].edits,
            (EditBatch{Edit::Add(Labelled(Feature::Point(1, 0, 0), {5, "The corner"})),
                       Edit::Add(Feature::Point(2, 1, 0)), Edit::SetLabel(9, {0, "Of the mesh"})}));
  EXPECT_EQ(batches[0].lines, (std::vector<int>{3, 4, 7}));
  EXPECT_EQ(batches[1].edits, (EditBatch{Edit::Set(Feature::Point(2, 1, 1)), Edit::Remove(1),
                                         Edit::Add(Labelled(Feature::Point(4, 0, 1), {7, ""})),
                                         Edit::SetLabel(2, {3, ""})}));
  EXPECT_EQ(
      batches[2].edits,
      (EditBatch{Edit::Add(Labelled(Feature::Point(1, 0, 0), {6, "The corner"})), Edit::Remove(4),
                 Edit::Add(Feature::Point(4, 1, 0)), Edit::SetLabel(2, {3, "Behind"})}));
  EXPECT_EQ(batches[2].lines.back(), 21);
}

TEST(EditScript, LabelsAloneAreABatch) {
  const auto script = Parse("marker 1 5\ncommit\nmarker 2 0\nname 1 A b\n", false);
  ASSERT_TRUE(script.ok()) << script.status();
  EXPECT_TRUE(script->batches.empty());
  const std::vector<ScriptBatch> batches = LabelledBatches(*script);
  ASSERT_EQ(batches.size(), 1U);
  EXPECT_EQ(batches[0].edits, (EditBatch{Edit::SetLabel(1, {5, "A b"}), Edit::SetLabel(2, {})}));
  EXPECT_EQ(batches[0].lines, (std::vector<int>{4, 3}));
  EXPECT_TRUE(LabelledBatches(*Parse("mesh\n")).empty());
}

TEST(EditScript, LabelsAreFormattedAsLines) {
  EXPECT_EQ(FormatLabel(3, {}), "");
  EXPECT_EQ(FormatLabel(3, {-7, "In # let"}), "marker 3 -7\nname 3 In   let\n");
  EXPECT_EQ(FormatEdit(Edit::SetLabel(3, {4, ""})), "marker 3 4");
  EXPECT_EQ(FormatEdit(Edit::SetLabel(3, {4, "a"})), "marker 3 4\nname 3 a");
  EXPECT_EQ(FormatEdit(Edit::SetLabel(3, {})), "marker 3 0");
}

TEST(EditScript, PolygonsHaveNoPlaceOfTheirOwn) {
  const auto script =
      Parse("mesh\nadd point 1 3 4\nadd polygon 2 1 1 1\nadd size 3 polygon 1 1 1 0.5\n");
  ASSERT_TRUE(script.ok()) << script.status();
  EXPECT_EQ(script->Options().box.lo[0], 3);
  EXPECT_EQ(script->Options().box.lo[1], 4);
}

TEST(EditScript, OfSpaceHasAThirdCoordinate) {
  const auto script = Parse(
      "mesh box=0,1,2,3,4,5 dim=3\n"
      "add point 1 0.5 1.5 2.5\n"
      "move point 1 1 2 3\n"
      "add polygon 9 1 2 3 / 4 5 6\n"
      "add size 10 point 1 2 3 0.5\n"
      "add size 11 disc 1 2 3 0.25 0.5\n"
      "set size 12 box 1 2 3 4 5 6 0.5\n"
      "add size 13 polygon 1 2 3 0.5\n"
      "add size 14 capsule 1 2 3 4 5 6 7 8 9 0.25 0.5\n");
  ASSERT_TRUE(script.ok()) << script.status();
  const MeshOptions options = script->Options();
  EXPECT_EQ(options.dimension, 3);
  EXPECT_EQ(options.quality, kDefaultQuality3D);
  EXPECT_EQ(options.box, (Box{{0, 1, 2}, {3, 4, 5}}));
  ASSERT_EQ(script->batches.size(), 1U);
  EXPECT_EQ(
      script->batches[0].edits,
      (EditBatch{
          Edit::Add(Feature::Point(1, 0.5, 1.5, 2.5)), Edit::Move(1, 1, 2, 3),
          Edit::Add(Feature::Polygon(9, {{1, 2, 3}, {4, 5, 6}})),
          Edit::Add(Feature::Size(10, {1, 2, 3}, {SizeShape::kPoint, 0.5, 0, {}})),
          Edit::Add(Feature::Size(11, {1, 2, 3}, {SizeShape::kDisc, 0.5, 0.25, {}})),
          Edit::Set(Feature::Size(12, {1, 2, 3}, {SizeShape::kBox, 0.5, 0, {4, 5, 6}})),
          Edit::Add(Feature::SizePolygon(13, {{1, 2, 3}}, 0.5)),
          Edit::Add(Feature::SizeCapsule(14, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}, 0.25, 0.5))}));
  EXPECT_EQ(Parse("mesh dim=3 rho=3\n")->Options().quality, 3);
  EXPECT_EQ(Parse("mesh dim=3\n")->Options().min_dihedral, kDefaultMinDihedral3D);
  EXPECT_EQ(Parse("mesh dim=3 min_dihedral=0\n")->Options().min_dihedral, 0);
  EXPECT_EQ(Parse("mesh dim=2\n")->Options().min_dihedral, 0);
}

TEST(EditScript, AHeaderNamesTheKind) {
  for (const int dim : {2, 3}) {
    const std::string text = "mesh dim=" + std::to_string(dim) + " kind=quadtree\n";
    const MeshOptions options = Parse(text)->Options();
    EXPECT_EQ(options.kind, MeshKind::kQuadtree);
    EXPECT_EQ(options.min_dihedral, 0);
    EXPECT_TRUE(ValidateOptions(options).ok());
    EXPECT_EQ(Parse(FormatMeshLine(options) + "\n")->Options(), options);
  }
  EXPECT_EQ(Parse("mesh kind=delaunay\n")->Options().kind, MeshKind::kDelaunay);
  EXPECT_FALSE(Parse("mesh kind=octagon\n").ok());
}

TEST(EditScript, OfSpaceWithoutABoxTakesThatOfItsPlaces) {
  const auto script = Parse("mesh dim=3\nadd point 1 3 4 5\nadd size 2 point -1 5 9 1\n");
  ASSERT_TRUE(script.ok()) << script.status();
  EXPECT_EQ(script->Options().box, (Box{{-1, 4, 5}, {3, 5, 9}}));
}

TEST(EditScript, WithoutAHeaderIsOfTheMeshsDimension) {
  const std::string text = "add point 1 3 4 5\n";
  const auto script = ParseEditScript(TextReader("s.txt", text), {false, 3});
  ASSERT_TRUE(script.ok()) << script.status();
  EXPECT_EQ(script->dimension, 3);
  EXPECT_EQ(script->batches[0].edits, EditBatch{Edit::Add(Feature::Point(1, 3, 4, 5))});
  EXPECT_FALSE(ParseEditScript(TextReader("s.txt", text), {false, 2}).ok());
  // A header counts.
  EXPECT_FALSE(ParseEditScript(TextReader("s.txt", "mesh dim=2\n" + text), {false, 3}).ok());
}

TEST(EditScript, OfSpaceFormattedReadsBack) {
  MeshOptions options;
  options.dimension = 3;
  options.box = {{-0.1, 1e-300, -0.0}, {1.0 / 3, 5e200, 0.7}};
  options.quality = 2.5;
  const double third = 1.0 / 3;
  const EditBatch edits = {
      Edit::Add(Feature::Point(1, third, -third, 1e-300)),
      Edit::Set(Feature::Point(1, 0, 0, -5e-324)),
      Edit::Move(1, 0.1, 0.2, third),
      Edit::Add(Feature::Polygon(2, {{1, 2, 3}, {4, 5, 6}})),
      Edit::Add(Feature::Segment(3, 1, 2)),
      Edit::Add(Feature::Size(4, {0.1, 0.2, third}, {SizeShape::kPoint, third, 0, {}})),
      Edit::Add(Feature::Size(4, {0.1, 0.2, third}, {SizeShape::kDisc, third, 0.7, {}})),
      Edit::Add(Feature::Size(4, {0, 0.2, third}, {SizeShape::kBox, 1, 0, {0.1, 0.3, third}})),
      Edit::Add(Feature::SizeCapsule(5, {{0, third, 1}, {-third, 1e-300, -0.0}}, 0.1, third)),
      Edit::Remove(4)};
  options.min_dihedral = 12.5;
  std::string text = FormatMeshLine(options) + "\n";
  for (const Edit& edit : edits) text += FormatEdit(edit, 3) + "\n";
  const auto script = Parse(text);
  ASSERT_TRUE(script.ok()) << script.status() << "\n" << text;
  EXPECT_EQ(script->Options(), options);
  EXPECT_EQ(script->batches[0].edits, edits);
}

TEST(EditScript, NeedsNoHeaderWhereAMeshIsThere) {
  const auto script = Parse("add point 1 3 4\n", false);
  ASSERT_TRUE(script.ok()) << script.status();
  EXPECT_FALSE(script->has_header);
  EXPECT_EQ(script->batches.size(), 1U);
  EXPECT_TRUE(Parse("", false).ok());
}

struct BadScript {
  const char* text;
  int line;
  const char* message;
};

const BadScript kBadScripts[] = {
    {"", 1, "must start with"},
    {"# only\n", 1, "must start with"},
    {"add point 1 0 0\n", 1, "must start with"},
    {"mesh dim=2\nmesh dim=2\n", 2, "must be the first"},
    {"mesh dim\n", 1, "expected key=value"},
    {"mesh dim=2 dim=2\n", 1, "stands twice"},
    {"mesh dim=4\n", 1, "dim must be 2 or 3"},
    {"mesh size=4\n", 1, "unknown key 'size'"},
    {"mesh box=0,0,1\n", 1, "a box is x0,y0,x1,y1"},
    {"mesh box=0,0,1,1,1\n", 1, "a box is x0,y0,x1,y1"},
    {"mesh box=0,0,1,x\n", 1, "a box is x0,y0,x1,y1"},
    {"mesh box=0,0,1,inf\n", 1, "a box is x0,y0,x1,y1"},
    {"mesh box=0,0,-1,1\n", 1, "x0 <= x1"},
    {"mesh rho=big\n", 1, "rho is not"},
    {"mesh criterion=best\n", 1, "edge or thesis"},
    {"mesh\njump 1\n", 2, "unknown command 'jump'"},
    {"mesh\nadd\n", 2, "add what?"},
    {"mesh\nadd circle 1 2 3\n", 2, "unknown kind of feature 'circle'"},
    {"mesh\nadd point\n", 2, "the point's id is missing"},
    {"mesh\nadd point 1\n", 2, "x is missing"},
    {"mesh\nadd point 1 0\n", 2, "y is missing"},
    {"mesh\nadd point 1 0 nan\n", 2, "y is not a finite number"},
    {"mesh\nadd point 1 0 0 0\n", 2, "unexpected '0'"},
    {"mesh\nadd point 0 0 0\n", 2, "reserved"},
    {"mesh\nadd point 18446744073709551615 0 0\n", 2, "reserved"},
    {"mesh\nadd point -5 0 0\n", 2, "the point's id is not"},
    {"mesh\nadd point 1.5 0 0\n", 2, "the point's id is not"},
    {"mesh\nadd segment 1 2\n", 2, "second end's id is missing"},
    {"mesh\nadd segment 1 2 0\n", 2, "reserved"},
    {"mesh\nadd segment 1 2 3 4\n", 2, "unexpected '4'"},
    {"mesh\nmove segment 1 2 3\n", 2, "only points move"},
    {"mesh\nmove point 1 2\n", 2, "y is missing"},
    {"mesh\nremove\n", 2, "is missing"},
    {"mesh\nremove one\n", 2, "is not a whole number"},
    {"mesh\nremove 1 2\n", 2, "unexpected '2'"},
    {"mesh\ncommit now\n", 2, "unexpected 'now'"},
    {"mesh dim=3 box=0,0,1,1\n", 1, "a box is x0,y0,z0,x1,y1,z1"},
    {"mesh box=0,0,1,1 dim=3\n", 1, "a box is x0,y0,z0,x1,y1,z1"},
    {"mesh dim=3 box=0,0,2,1,1,1\n", 1, "z0 <= z1"},
    {"mesh dim=2 box=0,0,0,1,1,1\n", 1, "a box is x0,y0,x1,y1"},
    {"mesh dim=3\nadd point 1 0 0\n", 2, "z is missing"},
    {"mesh dim=3\nadd point 1 0 0 0 0\n", 2, "unexpected '0'"},
    {"mesh dim=3\nmove point 1 0 0\n", 2, "z is missing"},
    {"mesh dim=3\nmove polygon 1 0 0\n", 2, "move point ID X Y Z"},
    {"mesh dim=3\nadd size 5 point 0 0 1\n", 2, "the target length is missing"},
    {"mesh dim=3\nadd size 5 disc 0 0 0 1\n", 2, "the target length is missing"},
    {"mesh dim=3\nadd size 5 box 0 0 0 1 1\n", 2, "z1 is missing"},
    {"mesh dim=3\nadd size 5 box 0 0 0 1 1 1 1 1\n", 2, "unexpected '1'"},
    {"mesh hmax=0\n", 1, "hmax is not a length above 0"},
    {"mesh hmax=much\n", 1, "hmax is not a length above 0"},
    {"mesh dim=3 min_dihedral=much\n", 1, "min_dihedral is not a finite number"},
    {"mesh\nadd polygon\n", 2, "the polygon's id is missing"},
    {"mesh\nadd polygon 5\n", 2, "a point's id is missing"},
    {"mesh\nadd polygon 5 1 2 x\n", 2, "a point's id is not a whole number"},
    {"mesh\nadd polygon 5 1 2 0\n", 2, "reserved"},
    {"mesh\nadd polygon 5 1 2 3/ 4 5 6\n", 2, "a point's id is not a whole number"},
    {"mesh\nadd polygon 5 / 4 5 6\n", 2, "no point stands before this /"},
    {"mesh\nadd polygon 5 1 2 3 / / 4 5 6\n", 2, "no point stands before this /"},
    {"mesh\nadd polygon 5 1 2 3 /\n", 2, "no point stands after the last /"},
    {"mesh\nmove polygon 5 1 2\n", 2, "only points move"},
    {"mesh\nset size 5 polygon\n", 2, "a point's id is missing"},
    {"mesh\nset size 5 polygon 0.1\n", 2, "a point's id is missing"},
    {"mesh\nset size 5 polygon 1 2 3 / 0.1\n", 2, "no point stands after the last /"},
    {"mesh\nset size 5 polygon 1 2 3 /\n", 2, "the target length is not"},
    {"mesh\nset size 5 polygon 1 2 3 far\n", 2, "the target length is not"},
    {"mesh\nset size 5 point 0 0\n", 2, "the target length is missing"},
    {"mesh\nadd size 5 disc 0 0 0.1\n", 2, "the target length is missing"},
    {"mesh\nadd size 5 disc 0 0 0.1 0.1 0.1\n", 2, "unexpected '0.1'"},
    {"mesh\nadd size 5 box 0 0 1 0.1\n", 2, "the target length is missing"},
    {"mesh\nadd size 5 capsule\n", 2, "a capsule's first vertex is missing"},
    {"mesh\nadd size 5 capsule 0 0 1\n", 2, "a capsule's first vertex is missing"},
    {"mesh\nadd size 5 capsule 0 0 1 1 0.1\n", 2, "has 2 coordinates a vertex"},
    {"mesh\nadd size 5 capsule 0 0 1 x 0.1 0.1\n", 2, "y is not a finite number"},
    {"mesh\nadd size 5 capsule 0 0 1 1 far 0.1\n", 2, "the radius is not"},
    {"mesh\nadd size 5 capsule 0 0 1 1 0.1 nan\n", 2, "the target length is not"},
    {"mesh dim=3\nadd size 5 capsule 0 0 0 1 1 0.1 0.1\n", 2, "has 3 coordinates a vertex"},
    {"mesh\nadd size 5 0 0 1\n", 2, "Expected point, disc, box, polygon or capsule"},
    {"mesh\nadd size 5\n", 2, "Expected point, disc, box, polygon or capsule"},
    {"mesh\nmove size 5 0 0\n", 2, "only points move"},
};

TEST(MalformedScript, IsRefusedWithFileAndLine) {
  for (const BadScript& bad : kBadScripts) {
    const absl::Status status = Parse(bad.text).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << bad.text;
    const std::string message(status.message());
    EXPECT_TRUE(message.starts_with("s.txt:" + std::to_string(bad.line) + ": ")) << bad.text << "\n"
                                                                                 << message;
    EXPECT_NE(message.find(bad.message), std::string::npos) << bad.text << "\n" << message;
  }
}

bool SameBits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

TEST(EditScript, FormattedReadsBackBitForBit) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937_64 random(seed);
  const auto coordinate = [&] {
    if (random() % 8 == 0) return random() % 2 == 0 ? -0.0 : std::bit_cast<double>(random() >> 12);
    return std::bit_cast<double>((random() >> 2) | 0x2000000000000000ULL) *
           (random() % 2 == 0 ? -1 : 1);
  };
  const auto id = [&] { return std::max<FeatureId>(1, random() >> (random() % 64) >> 1); };
  const auto rings = [&] {
    Rings made(1 + random() % 4);
    for (auto& ring : made) {
      for (std::size_t n = 1 + random() % 5; n > 0; --n) ring.push_back(id());
    }
    return made;
  };
  MeshOptions options;
  options.box.lo = {-0.1, 1e-300, 0};
  options.box.hi = {1.0 / 3, 5e200, 1};
  options.criterion = Criterion::kThesis;
  std::string text = FormatMeshLine(options) + "\n";
  EditBatch edits;
  for (int i = 0; i < 2000; ++i) {
    switch (random() % 9) {
      case 0:
        edits.push_back(Edit::Add(Feature::Point(id(), coordinate(), coordinate())));
        break;
      case 1:
        edits.push_back(Edit::Set(Feature::Point(id(), coordinate(), coordinate())));
        break;
      case 2:
        edits.push_back(Edit::Move(id(), coordinate(), coordinate()));
        break;
      case 3:
        edits.push_back(Edit::Add(Feature::Segment(id(), id(), id())));
        break;
      case 4:
        edits.push_back(Edit::Set(Feature::Segment(id(), id(), id())));
        break;
      case 5:
        edits.push_back(Edit::Add(Feature::Polygon(id(), rings())));
        break;
      case 6:
        edits.push_back(Edit::Set(Feature::Polygon(id(), rings())));
        break;
      case 7:
        edits.push_back(Edit::Add(Feature::SizePolygon(id(), rings(), coordinate())));
        break;
      default:
        edits.push_back(Edit::Remove(id()));
    }
    text += FormatEdit(edits.back()) + "\n";
  }
  const auto script = Parse(text);
  ASSERT_TRUE(script.ok()) << script.status();
  EXPECT_EQ(script->Options(), options);
  ASSERT_EQ(script->batches.size(), 1U);
  ASSERT_EQ(script->batches[0].edits.size(), edits.size());
  for (std::size_t i = 0; i < edits.size(); ++i) {
    const Edit& e = script->batches[0].edits[i];
    EXPECT_EQ(e, edits[i]);
    EXPECT_TRUE(SameBits(e.feature.position[0], edits[i].feature.position[0]));
    EXPECT_TRUE(SameBits(e.feature.position[1], edits[i].feature.position[1]));
  }
}

TEST(BoundingBox, HoldsThePointsAndNothingMore) {
  const Box box =
      BoundingBox({Feature::Point(1, 3, -4), Feature::Segment(2, 1, 1), Feature::Point(3, -1, 7)});
  EXPECT_EQ(box.lo[0], -1);
  EXPECT_EQ(box.lo[1], -4);
  EXPECT_EQ(box.hi[0], 3);
  EXPECT_EQ(box.hi[1], 7);
  EXPECT_EQ(BoundingBox({}), Box());
}

}  // namespace
}  // namespace dynmesh::io
