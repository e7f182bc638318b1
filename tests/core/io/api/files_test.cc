#include "dynmesh/files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "core/io/formats/formats.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/slot_mesh.h"
#include "gtest/gtest.h"
#include "tests/support/temp_folder.h"

namespace dynmesh {
namespace {

using test::TempFolder;

constexpr char kFrame[] =
    "8 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n5 .4 .4\n6 .6 .4\n7 .6 .6\n8 .4 .6\n"
    "8 1\n1 1 2 5\n2 2 3 0\n3 3 4 0\n4 4 1 0\n5 5 6 0\n6 6 7 0\n7 7 8 0\n8 8 5 0\n1\n1 .5 .5\n";
constexpr char kCube[] =
    "OFF\n8 12 0\n0 0 0\n4 0 0\n4 4 0\n0 4 0\n0 0 4\n4 0 4\n4 4 4\n0 4 4\n"
    "3 0 1 2\n3 0 2 3\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n"
    "3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n";

double SizeOf(const Mesh& mesh) {
  const auto slots = SlotMesh::FromMesh(mesh);
  EXPECT_TRUE(slots.ok());
  const auto d = static_cast<std::size_t>(mesh.dimension);
  double sum = 0;
  for (std::size_t i = 0; i < slots->simplex_count(); ++i) {
    std::array<std::array<double, 3>, 4> p{};
    for (std::size_t k = 0; k <= d; ++k) {
      for (std::size_t j = 0; j < d; ++j) {
        p[k][j] =
            slots->points()[d * static_cast<std::size_t>(slots->cells()[(d + 1) * i + k]) + j];
      }
    }
    const auto e = [&](std::size_t k, std::size_t j) { return p[k][j] - p[0][j]; };
    sum += d == 2 ? (e(1, 0) * e(2, 1) - e(1, 1) * e(2, 0)) / 2
                  : (e(1, 0) * (e(2, 1) * e(3, 2) - e(2, 2) * e(3, 1)) -
                     e(1, 1) * (e(2, 0) * e(3, 2) - e(2, 2) * e(3, 0)) +
                     e(1, 2) * (e(2, 0) * e(3, 1) - e(2, 1) * e(3, 0))) /
                        6;
  }
  return sum;
}

TEST(Files, AnInputBecomesAMeshOfItsInsideInAFile) {
  const TempFolder folder;
  const auto input = ReadInput(folder.Write("f.poly", kFrame));
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features.size(), 16U);
  ASSERT_EQ(input->features[8].id, 9U);
  EXPECT_EQ(*input->features[8].label, (FeatureLabel{5, ""}));
  EXPECT_FALSE(input->features[9].label);
  EXPECT_EQ(input->places.at(9), folder.Path("f.poly") + ":11");
  const auto mesh = BuildMesh(input->features, input->options);
  ASSERT_TRUE(mesh.ok());
  const auto inside = KeepInside(*mesh, input->holes);
  ASSERT_TRUE(inside.ok());
  EXPECT_NEAR(SizeOf(*inside), 0.96, 1e-14);
  for (const char* name : {"m.node", "m.vtu", "m.msh", "m.mesh"}) {
    EXPECT_TRUE(WriteMesh(*inside, input->options, folder.Path(name)).ok()) << name;
  }
  Mesh read = *ReadMesh(folder.Path("m.node"));
  EXPECT_EQ(read.hash, inside->hash);
  const auto again = ReadInput(folder.Path("m.msh"));
  ASSERT_TRUE(again.ok()) << again.status();
  const auto from_mesh = BuildMesh(again->features, again->options);
  EXPECT_NEAR(SizeOf(*KeepInside(*from_mesh, again->holes)), 0.96, 1e-14);
  EXPECT_FALSE(KeepInside(*BuildMesh({}, input->options)).ok());
}

TEST(Files, NamesAreWrittenAsGroups) {
  const TempFolder folder;
  const auto input = ReadInput(folder.Write(
      "n.dynmesh",
      "mesh box=0,0,4,4\nadd point 1 1 1\nadd point 2 3 1\nadd segment 3 1 2\nname 3 inlet\n"));
  ASSERT_TRUE(input.ok()) << input.status();
  const auto mesh = BuildMesh(input->features, input->options);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  ASSERT_TRUE(WriteMesh(*mesh, input->options, folder.Path("n.msh")).ok());
  EXPECT_NE(folder.Read("n.msh").find("\"inlet\""), std::string::npos);
  const auto again = ReadInput(folder.Path("n.msh"));
  ASSERT_TRUE(again.ok()) << again.status();
  const auto named = std::ranges::count_if(again->features, [](const Feature& f) {
    return f.kind == FeatureKind::kSegment && f.label->name == "inlet";
  });
  EXPECT_GT(named, 0);
}

TEST(Files, ANameThatNoLabelCanHaveIsRefused) {
  const TempFolder folder;
  const auto input = ReadInput(folder.Write(
      "n.dynmesh", "mesh box=0,0,4,4\nadd point 1 1 1\nname 1 " + std::string(256, 'x') + "\n"));
  ASSERT_TRUE(input.ok()) << input.status();
  const auto mesh = BuildMesh(input->features, input->options);
  EXPECT_EQ(mesh.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(mesh.status().message().find("feature 1"), std::string::npos) << mesh.status();
}

TEST(Files, SurfacesAreReadAndTheirFacesJoined) {
  const TempFolder folder;
  const auto input = ReadInput(folder.Write("c.off", kCube), true);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features.size(), 14U);  // eight points, six faces
  EXPECT_EQ(input->options.dimension, 3);
  const auto mesh = BuildMesh(input->features, input->options);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_NEAR(SizeOf(*KeepInside(*mesh)), 64, 1e-12);
}

// The square of two triangles is off its plane by two units of the last digit.
TEST(Files, FlatFacesAreOneUnlessTheyAreKept) {
  const TempFolder folder;
  const std::string off = folder.Write(
      "s.off",
      "OFF\n5 3 0\n0 0 1.10000\n2 0 1.1\n2 3 1.2\n0 3 1.20001\n1 1 3\n3 0 1 2\n3 0 2 3\n3 0 1 4\n");
  const auto joined = ReadInput(off);
  ASSERT_TRUE(joined.ok()) << joined.status();
  EXPECT_EQ(joined->features.size(), 7U);
  ASSERT_EQ(joined->warnings.size(), 1U);
  EXPECT_NE(joined->warnings[0].find("2 faces joined into 1 polygon(s), 4 corner(s) moved"),
            std::string::npos)
      << joined->warnings[0];
  EXPECT_TRUE(BuildMesh(joined->features, joined->options).ok());
  const auto kept = ReadInput(off, {.keep_facets = true});
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(kept->features.size(), 8U);
  EXPECT_TRUE(kept->warnings.empty());
  EXPECT_EQ(kept->places.at(7), off + ":9");
}

TEST(Files, ScriptsAreReadToTheirEnd) {
  const TempFolder folder;
  const auto input = ReadInput(folder.Write(
      "s.dynmesh",
      "mesh box=0,0,4,4 rho=1.2\nadd point 1 1 1\nadd point 2 2 2\ncommit\nremove 2\nname 1 A\n"));
  ASSERT_TRUE(input.ok()) << input.status();
  Feature point = Feature::Point(1, 1, 1);
  point.label = FeatureLabel{0, "A"};
  EXPECT_EQ(input->features, std::vector<Feature>{point});
  EXPECT_EQ(input->options.quality, 1.2);
  const auto bad = ReadInput(folder.Write("b.dynmesh", "mesh box=0,0,4,4\nremove 2\n"));
  EXPECT_TRUE(std::string(bad.status().message()).starts_with(folder.Path("b.dynmesh") + ":2: "))
      << bad.status();
}

std::string Npy() {
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2), }";
  header.resize(117, ' ');
  std::string text = std::string("\x93NUMPY\x01\x00\x76\x00", 10) + header + "\n";
  for (const double h : {0.25, 0.5}) text.append(reinterpret_cast<const char*>(&h), sizeof(h));
  return text;
}

// Of each format that is read and not written as a mesh: a file, in 3D a surface.
const std::map<std::string, std::string>& Examples() {
  static const std::map<std::string, std::string> examples = {
      {".node", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n"},
      {".poly", kFrame},
      {".smesh", "3 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0\n3 1 2 3\n0\n0\n"},
      {".off", kCube},
      {".stl",
       "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
       "vertex 0 1 0\nendloop\nendfacet\nendsolid s\n"},
      {".obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
      {".ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
       "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
      {".geojson", R"({"type": "Polygon", "coordinates": [[[0,0],[1,0],[0,1],[0,0]]]})"},
      {".topojson", R"({"type": "Topology", "objects": {"o": {"type": "LineString", "arcs": [0]}},)"
                    R"( "arcs": [[[0,0],[1,0]]]})"},
      {".json", R"({"type": "Polygon", "coordinates": [[[0,0],[1,0],[0,1],[0,0]]]})"},
      {".dynmesh", "mesh box=0,0,4,4\nadd point 1 1 1\n"},
      {".asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize .5\n.25 .5\n"},
      {".npy", Npy()},
      {".pos", "View \"h\" {\nSP(.5,.5,0){.25};\n};\n"},
      {".mtr", "8 1\n.1\n.1\n.1\n.1\n.1\n.1\n.1\n.1\n"}};
  return examples;
}

TEST(Files, EachFormatOfTheTableThatIsGeometryIsRead) {
  const TempFolder folder;
  for (const io::Format& f : io::Formats()) {
    if (f.read_geometry == nullptr || f.write_mesh != nullptr) continue;
    SCOPED_TRACE(f.extension);
    const std::string extension(f.extension);
    ASSERT_TRUE(Examples().contains(extension)) << "a row without an example";
    const auto input = ReadInput(folder.Write("a" + extension, Examples().at(extension)));
    ASSERT_TRUE(input.ok()) << input.status();
    EXPECT_FALSE(input->features.empty());
    EXPECT_TRUE(f.IsOf(input->options.dimension));
    for (const Feature& feature : input->features) EXPECT_NE(input->places.at(feature.id), "");
  }
}

TEST(Files, EachFormatOfTheTableThatHasSizesIsRead) {
  const TempFolder folder;
  const auto input = ReadInput(folder.Write("f.poly", kFrame));
  ASSERT_TRUE(input.ok());
  for (const io::Format& f : io::Formats()) {
    if (f.read_sizes == nullptr) continue;
    SCOPED_TRACE(f.extension);
    const std::string extension(f.extension);
    ASSERT_TRUE(Examples().contains(extension)) << "a row without an example";
    const auto sizes = ReadSizes(folder.Write("a" + extension, Examples().at(extension)), *input);
    ASSERT_TRUE(sizes.ok()) << sizes.status();
    ASSERT_FALSE(sizes->empty());
    EXPECT_EQ(sizes->front().id, input->features.back().id + 1);
    EXPECT_EQ(sizes->front().kind, FeatureKind::kSize);
    EXPECT_FALSE(ReadInput(folder.Path("a" + extension)).ok());
  }
}

TEST(Files, EachFormatOfTheTableThatIsAMeshIsWrittenAndRead) {
  const TempFolder folder;
  for (const char* name : {"f.poly", "c.off"}) {
    const auto input =
        ReadInput(folder.Write(name, name[0] == 'f' ? kFrame : kCube), {.merge_coplanar = true});
    ASSERT_TRUE(input.ok()) << input.status();
    const int dimension = input->options.dimension;
    const auto mesh = BuildMesh(input->features, input->options);
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    for (const io::Format& f : io::Formats()) {
      SCOPED_TRACE(f.extension);
      const std::string stem = folder.Path("m" + std::to_string(dimension));
      const std::string path = stem + std::string(f.extension);
      const bool is_written = f.write_mesh != nullptr && f.IsOf(dimension);
      EXPECT_EQ(WriteMesh(*mesh, input->options, path).ok(), is_written);
      if (!is_written) continue;
      EXPECT_TRUE(std::filesystem::exists(f.Is(io::kBesideNode) ? stem + ".node" : path));
      if (f.read_mesh != nullptr) {
        EXPECT_EQ(ReadMesh(path)->simplex_count(), mesh->simplex_count());
      }
      if (f.read_elements == nullptr) continue;
      const auto border = ReadInput(path), all = ReadInput(path, {.refine = true});
      ASSERT_TRUE(border.ok() && all.ok()) << border.status() << all.status();
      EXPECT_FALSE(border->features.empty());
      EXPECT_EQ(all->options.dimension, dimension);
      EXPECT_TRUE(dimension == 3 || all->features.size() > mesh->vertices.size());
    }
  }
}

// The second number below the heading of the nodes in a .msh: how many there are.
std::size_t NodesIn(const std::string& path) {
  std::ifstream in(path);
  std::string word;
  while (in >> word && word != "$Nodes") {
  }
  std::size_t blocks = 0, nodes = 0;
  in >> blocks >> nodes;
  return nodes;
}

TEST(Files, AMeshIsWrittenAsIsChosen) {
  const TempFolder folder;
  const auto input = ReadInput(folder.Write("f.poly", kFrame));
  ASSERT_TRUE(input.ok()) << input.status();
  const auto mesh = BuildMesh(input->features, input->options);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  const auto write = [&](const char* name, const OutputChoices& choices) {
    return WriteMesh(*mesh, input->options, folder.Path(name), choices);
  };

  ASSERT_TRUE(write("1.msh", {}).ok());
  ASSERT_TRUE(write("2.msh", {.order = 2}).ok());
  EXPECT_EQ(NodesIn(folder.Path("1.msh")), mesh->vertices.size());
  // Euler: there are as many edges as vertices and triangles, less one.
  EXPECT_EQ(NodesIn(folder.Path("2.msh")), 2 * mesh->vertices.size() + mesh->simplex_count() - 1);
  ASSERT_TRUE(write("1.svg", {}).ok() && write("2.svg", {.order = 2}).ok());
  EXPECT_EQ(std::filesystem::file_size(folder.Path("1.svg")),
            std::filesystem::file_size(folder.Path("2.svg")));
  const absl::Status no_second_order = write("m.mesh", {.order = 2});
  EXPECT_TRUE(absl::IsInvalidArgument(no_second_order));
  EXPECT_NE(std::string(no_second_order.message()).find("order 2 is for .node, .vtu"),
            std::string::npos)
      << no_second_order;
  EXPECT_TRUE(absl::IsInvalidArgument(write("3.msh", {.order = 3})));

  ASSERT_TRUE(write("m.node", {.from_zero = true, .neighbours = true, .voronoi = true}).ok());
  EXPECT_EQ(ReadMesh(folder.Path("m.node"))->hash, mesh->hash);
  for (const char* name : {"m.neigh", "m.v.node", "m.v.edge"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.Path(name))) << name;
  }
  std::ifstream in(folder.Path("m.node"));
  std::string line;
  while (std::getline(in, line) && line[0] == '#') {
  }
  while (std::getline(in, line) && line[0] == '#') {
  }
  EXPECT_EQ(line.substr(0, 2), "0 ") << line;
}

TEST(Files, EachFormatOfTheTableThatHasLeavesIsWrittenAndRead) {
  const TempFolder folder;
  auto input = ReadInput(folder.Write("f.poly", kFrame));
  ASSERT_TRUE(input.ok());
  input->options.kind = MeshKind::kQuadtree;
  const auto tree = BuildMesh(input->features, input->options);
  ASSERT_TRUE(tree.ok()) << tree.status();
  for (const io::Format& f : io::Formats()) {
    SCOPED_TRACE(f.extension);
    const std::string path = folder.Path("t" + std::string(f.extension));
    EXPECT_EQ(WriteMesh(*tree, input->options, path).ok(), f.write_leaves != nullptr);
    if (f.read_leaves == nullptr) continue;
    EXPECT_EQ(ReadMesh(path)->hash, tree->hash);
  }
}

TEST(Files, RingsOfAMapArePolygonsOnRequest) {
  const TempFolder folder;
  const std::string path = folder.Write("m.geojson", Examples().at(".geojson"));
  const auto polygons = [&](const InputChoices& choices) {
    return std::ranges::count(ReadInput(path, choices)->features, FeatureKind::kPolygon,
                              &Feature::kind);
  };
  EXPECT_EQ(polygons({}), 0);
  EXPECT_EQ(polygons({.polygons = true}), 1);
}

TEST(Files, FacesOfDifferentMarkersAreNotJoined) {
  const TempFolder folder;
  const auto faces = [&](const std::string& marker) {
    const std::string text =
        "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n2 1\n3 1 2 3 1\n3 1 3 4 " + marker +
        "\n0\n0\n";
    const auto input = ReadInput(folder.Write("m.smesh", text), true);
    EXPECT_TRUE(input.ok()) << input.status();
    return std::ranges::count(input->features, FeatureKind::kPolygon, &Feature::kind);
  };
  EXPECT_EQ(faces("1"), 1);
  EXPECT_EQ(faces("2"), 2);
}

TEST(Files, WhatIsWrongIsNamed) {
  const TempFolder folder;
  EXPECT_EQ(ReadInput(folder.Path("none.poly")).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ReadInput(folder.Path("a.xyz")).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(WriteMesh(Mesh(), MeshOptions(), folder.Path("a.xyz")).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadMesh(folder.Path("none.node")).status().code(), absl::StatusCode::kNotFound);
  const auto input = ReadInput(folder.Write("f.poly", kFrame));
  const auto mesh = BuildMesh(input->features, input->options);
  ASSERT_TRUE(WriteMesh(*mesh, input->options, folder.Path("m.node")).ok());
  std::string nodes = folder.Read("m.node");
  nodes.replace(nodes.find("1 0 0 1\n"), 8, "1 0 0 2\n");
  folder.Write("m.node", nodes);
  EXPECT_EQ(ReadMesh(folder.Path("m.node")).status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace dynmesh
