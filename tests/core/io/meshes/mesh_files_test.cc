#include "core/io/meshes/mesh_files.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <random>
#include <string>

#include "gtest/gtest.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;
using testing::SampleMesh;
using testing::SampleMeshWithRegions;

std::string FirstLines(const std::string& text, int count) {
  std::size_t end = 0;
  for (int i = 0; i < count; ++i) end = text.find('\n', end) + 1;
  return text.substr(0, end);
}

TEST(MeshFiles, HaveTheMarkersOfTheContract) {
  const TempFolder folder;
  ASSERT_TRUE(WriteMeshFiles(IndexMesh(SampleMesh()).value(), folder.Path("m.node")).ok());
  EXPECT_EQ(folder.FileCount(), 3U);
  const std::string nodes = folder.Read("m.node");
  EXPECT_EQ(FirstLines(nodes, 10),
            "9 2 0 1\n"
            "1 2 3.1 10\n"
            "2 10 3.1 20\n"
            "3 0 0 -1\n"
            "4 0 6 -1\n"
            "5 4 0 -1\n"
            "6 12 0 -1\n"
            "7 12 6 -1\n"
            "8 6 3.1 0\n"
            "9 8 0.3333333333333333 0\n");
  const std::string edges = folder.Read("m.edge");
  EXPECT_EQ(FirstLines(edges, 1), "19 1\n");
  EXPECT_NE(edges.find(" 1 8 30\n"), std::string::npos);
  EXPECT_NE(edges.find(" 2 8 30\n"), std::string::npos);
  EXPECT_NE(edges.find(" 3 5 -1\n"), std::string::npos);
  EXPECT_NE(edges.find(" 8 9 0\n"), std::string::npos);
  EXPECT_EQ(FirstLines(folder.Read("m.ele"), 1), "11 3 0\n");
}

TEST(MeshFiles, ReadBackAreTheSameMesh) {
  const TempFolder folder;
  const Mesh mesh = SampleMesh();
  const IndexedMesh indexed = IndexMesh(mesh).value();
  ASSERT_TRUE(WriteMeshFiles(indexed, folder.Path("m")).ok());
  for (const char* name : {"m", "m.node", "m.ele", "m.edge"}) {
    const auto files = ReadMeshFiles(folder.Path(name));
    ASSERT_TRUE(files.ok()) << files.status();
    EXPECT_EQ(files->mesh.vertices, indexed.vertices);
    EXPECT_EQ(files->mesh.triangles, indexed.triangles);
    EXPECT_EQ(files->mesh.edges, indexed.edges);
    ASSERT_TRUE(files->recorded_hash.has_value());
    EXPECT_EQ(*files->recorded_hash, mesh.hash);
    EXPECT_EQ(ToMesh(files->mesh).hash, mesh.hash);
    EXPECT_TRUE(files->has_edges);
  }
}

TEST(MeshFiles, SayWhichRegionATriangleIsIn) {
  const TempFolder folder;
  ASSERT_TRUE(WriteMeshFiles(IndexMesh(SampleMeshWithRegions()).value(), folder.Path("m")).ok());
  const std::string triangles = folder.Read("m.ele");
  EXPECT_EQ(FirstLines(triangles, 2),
            "11 3 1\n"
            "1 1 3 5 0\n");
  EXPECT_TRUE(
      triangles.ends_with("\n# dynmesh region 1 12\n"
                          "# dynmesh region 2 12 40\n"
                          "# dynmesh region 3 40\n"
                          "# dynmesh region 4 40 18446744073709551614\n"))
      << triangles;
}

TEST(MeshFiles, ReadBackHaveTheSameRegions) {
  const TempFolder folder;
  Mesh mesh = SampleMeshWithRegions();
  ASSERT_TRUE(WriteMeshFiles(IndexMesh(mesh).value(), folder.Path("m")).ok());
  const auto files = ReadMeshFiles(folder.Path("m"));
  ASSERT_TRUE(files.ok()) << files.status();
  Mesh back = ToMesh(files->mesh);
  EXPECT_EQ(back.hash, mesh.hash);
  EXPECT_EQ(files->recorded_hash, mesh.hash);
  Canonicalize(mesh);
  Canonicalize(back);
  EXPECT_EQ(back.simplices, mesh.simplices);
  EXPECT_EQ(back.regions, mesh.regions);
  EXPECT_EQ(back.region_sets, mesh.region_sets);
}

absl::StatusOr<MeshFiles> ParseTriangles(const std::string& triangles) {
  return ParseMeshFiles(TextReader("m.node", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n"),
                        TextReader("m.ele", triangles), std::nullopt);
}

TEST(MeshFiles, SkipAttributesThatAreNoRegions) {
  const auto files = ParseTriangles("1 3 2\n1 1 2 3 0.25 x\n");
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_EQ(files->mesh.regions, RegionNumbers());
}

TEST(MeshFiles, RefuseRegionsThatMakeNoSense) {
  const auto expect_refused = [](const std::string& text, const std::string& message) {
    const absl::Status status = ParseTriangles(text).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_TRUE(std::string(status.message()).starts_with("m.ele:")) << status;
    EXPECT_NE(std::string(status.message()).find(message), std::string::npos) << status;
  };
  const std::string rows = "1 3 1\n1 1 2 3 1\n";
  EXPECT_TRUE(ParseTriangles(rows + "# dynmesh region 1 4 5\n").ok());
  expect_refused(rows + "# dynmesh region 2 4\n", "region 1 expected, found '2'");
  expect_refused(rows + "# dynmesh region 1 4\n# dynmesh region 1 5\n", "region 2 expected");
  expect_refused(rows + "# dynmesh region x 4\n", "region 1 expected, found 'x'");
  expect_refused(rows + "# dynmesh region 1\n", "has no polygon");
  expect_refused(rows + "# dynmesh region 1 0\n", "names no polygon: '0'");
  expect_refused(rows + "# dynmesh region 1 18446744073709551615\n", "names no polygon");
  expect_refused(rows + "# dynmesh region 1 5 4\n", "not in ascending order");
  expect_refused(rows + "# dynmesh region 1 5 5\n", "not in ascending order");
  expect_refused("1 3 0\n1 1 2 3\n# dynmesh region 1 5\n", "no attribute");
  for (const char* bad : {"2", "-1", "0.5", "nan", "x"}) {
    const std::string row = std::string("1 3 1\n1 1 2 3 ") + bad + "\n# dynmesh region 1 5\n";
    expect_refused(row, ":2: the attribute is no region");
  }
}

TEST(MeshFiles, WrittenAgainAreTheSameBytes) {
  const TempFolder folder;
  Mesh mesh = SampleMesh();
  ASSERT_TRUE(WriteMeshFiles(IndexMesh(mesh).value(), folder.Path("a")).ok());
  Canonicalize(mesh);  // other rows, same mesh
  mesh.revision = 17;  // no part of it
  ASSERT_TRUE(WriteMeshFiles(IndexMesh(mesh).value(), folder.Path("b")).ok());
  for (const char* extension : {".node", ".ele", ".edge"}) {
    EXPECT_EQ(folder.Read(std::string("a") + extension), folder.Read(std::string("b") + extension));
  }
}

TEST(MeshFiles, KeepEveryBitOfCoordinatesAndOwners) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937_64 random(seed);
  const TempFolder folder;
  IndexedMesh mesh;
  using Limits = std::numeric_limits<double>;
  const double special[] = {
      0.0, -0.0,   Limits::min(), Limits::denorm_min(), Limits::max(), -Limits::denorm_min(),
      0.1, 1.0 / 3};
  for (int i = 0; i < 5000; ++i) {
    double c[2];
    for (double& x : c) {
      do {
        x = random() % 4 == 0 ? special[random() % 8] : std::bit_cast<double>(random());
      } while (!std::isfinite(x));
    }
    mesh.vertices.push_back({c[0], c[1], 0, std::max<FeatureId>(1, random())});
  }
  for (std::uint32_t i = 0; i + 2 < 5000; ++i) {
    mesh.triangles.push_back({i, i + 2, i + 1});
    mesh.edges.push_back({i, i + 1, random() % 2 == 0 ? kNoFeature : random()});
  }
  ASSERT_TRUE(WriteMeshFiles(mesh, folder.Path("m.node")).ok());
  const auto files = ReadMeshFiles(folder.Path("m"));
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_EQ(files->mesh.triangles, mesh.triangles);
  EXPECT_EQ(files->mesh.edges, mesh.edges);
  ASSERT_EQ(files->mesh.vertices.size(), mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto& a = mesh.vertices[i];
    const auto& b = files->mesh.vertices[i];
    ASSERT_EQ(std::bit_cast<std::uint64_t>(a.x), std::bit_cast<std::uint64_t>(b.x));
    ASSERT_EQ(std::bit_cast<std::uint64_t>(a.y), std::bit_cast<std::uint64_t>(b.y));
    ASSERT_EQ(a.owner, b.owner);
  }
}

TEST(MeshFiles, WithoutEdgesAreRead) {
  const TempFolder folder;
  folder.Write("m.node", "3 2 0 0\n0 0 0\n1 1 0\n2 0 1\n");
  folder.Write("m.ele", "1 3 1\n0 0 1 2 9\n");
  const auto files = ReadMeshFiles(folder.Path("m"));
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_FALSE(files->has_edges);
  EXPECT_FALSE(files->recorded_hash.has_value());
  EXPECT_EQ(files->mesh.triangles, (std::vector<IndexedMesh::Triangle>{{0, 1, 2}}));
}

struct Damage {
  const char* file;
  const char* text;
  const char* message;
};

TEST(MeshFiles, MalformedAreRefusedWithFileAndLine) {
  const Damage damages[] = {
      {"m.node", "3 2 0 1\n1 0 0 0\n2 1 0 0\n", "m.node:3: the file ends after 2 of 3"},
      {"m.node", "3 2 0 1\n1 0 0 0\n2 1 0 0\n3 0 1 0\n# dynmesh hash abc\n", "32 hexadecimal"},
      {"m.node", "3 2 0 1\n1 0 0 0\n2 1 0 0\n3 0 1 0\n# dynmesh box-side-vertices 4\n",
       "names no vertex: 4"},
      {"m.node", "3 2 0 1\n1 0 0 0\n2 1 0 0\n3 0 1 0\n# dynmesh box-side-vertices 0\n",
       "names no vertex: 0"},
      {"m.ele", "", "no triangle header"},
      {"m.ele", "1 6 0\n1 1 2 3 1 2 3\n", "m.ele:1: 6 nodes a triangle"},
      {"m.ele", "1 3 0\n1 1 2 4\n", "m.ele:2: vertex 4 does not exist"},
      {"m.ele", "1 3 0\n1 1 2\n", "m.ele:2: a triangle row"},
      {"m.ele", "2 3 0\n1 1 2 3\n", "m.ele:2: the file ends after 1 of 2"},
      {"m.ele", "1 3 0\n1 1 2 3\n2 1 2 3\n", "m.ele:3: more values"},
      {"m.ele", "1 3 9999999\n1 1 2 3\n", "m.ele:1: more than 1000 attributes"},
      {"m.edge", "1 1\n1 1 9 0\n", "m.edge:2: vertex 9 does not exist"},
      {"m.edge", "1 1\n1 1 2\n", "m.edge:2: a edge row"},
      {"m.edge", "1 1\n1 1 2 0\nx\n", "m.edge:3: more values"},
  };
  for (const Damage& damage : damages) {
    const TempFolder folder;
    folder.Write("m.node", "3 2 0 1\n1 0 0 0\n2 1 0 0\n3 0 1 0\n");
    folder.Write("m.ele", "1 3 0\n1 1 2 3\n");
    folder.Write("m.edge", "1 1\n1 1 2 7\n");
    ASSERT_TRUE(ReadMeshFiles(folder.Path("m")).ok());
    folder.Write(damage.file, damage.text);
    const absl::Status status = ReadMeshFiles(folder.Path("m")).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << damage.text;
    EXPECT_NE(std::string(status.message()).find(damage.message), std::string::npos) << status;
  }
}

TEST(MeshFiles, MissingOnesAreNamed) {
  const TempFolder folder;
  EXPECT_EQ(ReadMeshFiles(folder.Path("m")).status().code(), absl::StatusCode::kNotFound);
  folder.Write("m.node", "0 2 0 1\n");
  const absl::Status status = ReadMeshFiles(folder.Path("m.edge")).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_NE(std::string(status.message()).find("m.ele"), std::string::npos);
}

TEST(MeshFiles, ThatCannotBeWrittenLeaveTheOldOnes) {
  const TempFolder folder;
  folder.Write("m.node", "old");
  std::filesystem::create_directory(folder.Path("m.edge"));  // blocks the file
  EXPECT_FALSE(WriteMeshFiles(IndexMesh(SampleMesh()).value(), folder.Path("m")).ok());
  EXPECT_EQ(folder.Read("m.node"), "old");
  EXPECT_EQ(folder.FileCount(), 2U);
}

}  // namespace
}  // namespace dynmesh::io
