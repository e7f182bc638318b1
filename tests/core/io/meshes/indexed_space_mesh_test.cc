// IndexMesh, ToMesh and mesh files in 3D.
#include <algorithm>
#include <bit>
#include <map>
#include <set>
#include <string>

#include "core/io/meshes/indexed_mesh.h"
#include "core/io/meshes/mesh_files.h"
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
using testing::MakeUpLabelledMesh;
using Triple = std::array<std::uint32_t, 3>;

TEST(IndexSpaceMesh, AndBackIsTheSameMesh) {
  testing::Random random = MakeRandom();
  for (int round = 0; round < 20; ++round) {
    Mesh mesh = MakeUpLabelledMesh(random, 30 + 10 * round, 0, 3);
    mesh.labels.clear();  // an indexed mesh has none of features
    const auto indexed = IndexMesh(mesh);
    ASSERT_TRUE(indexed.ok()) << indexed.status();
    Mesh back = ToMesh(*indexed);
    Canonicalize(mesh);
    Canonicalize(back);
    EXPECT_TRUE(testing::Identical(back, mesh));
  }
}

TEST(IndexSpaceMesh, DoesNotDependOnTheOrderOfRows) {
  testing::Random random = MakeRandom();
  Mesh mesh = MakeUpLabelledMesh(random, 200, 0, 3);
  const IndexedMesh before = IndexMesh(mesh).value();
  Canonicalize(mesh);
  const IndexedMesh after = IndexMesh(mesh).value();
  EXPECT_EQ(before.vertices, after.vertices);
  EXPECT_EQ(before.tetrahedra, after.tetrahedra);
  EXPECT_EQ(before.edges, after.edges);
  EXPECT_EQ(before.faces, after.faces);
  EXPECT_EQ(before.regions, after.regions);
}

TEST(IndexSpaceMesh, ListsAllEdgesSubfacetsAndTheBorder) {
  testing::Random random = MakeRandom();
  const Mesh mesh = MakeUpLabelledMesh(random, 100, 0, 3);
  const IndexedMesh indexed = IndexMesh(mesh).value();
  std::map<Triple, int> uses;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges, listed_edges;
  for (IndexedMesh::Tetrahedron t : indexed.tetrahedra) {
    EXPECT_LT(t[0], t[1]);
    EXPECT_LT(t[1], std::min(t[2], t[3]));
    std::sort(t.begin(), t.end());
    for (const Triple& f : {Triple{t[0], t[1], t[2]}, Triple{t[0], t[1], t[3]},
                            Triple{t[0], t[2], t[3]}, Triple{t[1], t[2], t[3]}}) {
      ++uses[f];
    }
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) edges.emplace(t[j], t[i]);
    }
  }
  EXPECT_TRUE(std::is_sorted(indexed.tetrahedra.begin(), indexed.tetrahedra.end()));
  std::map<VertexId, std::uint32_t> number_of;
  {
    const Mesh rows = ToMesh(indexed);
    for (std::uint32_t v = 0; v < rows.vertices.size(); ++v) number_of[rows.vertices.ids[v]] = v;
  }
  std::set<std::pair<Triple, FeatureId>> faces, listed;
  std::set<Triple> owned;
  for (std::size_t i = 0; i < mesh.subfacets.size(); ++i) {
    Triple f;
    for (std::size_t k = 0; k < 3; ++k) f[k] = number_of.at(mesh.subfacets.corners[3 * i + k]);
    std::sort(f.begin(), f.end());
    faces.emplace(f, mesh.subfacets.owners[i]);
    owned.insert(f);
  }
  for (const auto& [f, count] : uses) {
    if (count == 1 && !owned.contains(f)) faces.emplace(f, kBoxFeature);
  }
  for (const auto& f : indexed.faces) listed.emplace(f.corners, f.owner);
  EXPECT_EQ(listed, faces);
  EXPECT_EQ(indexed.faces.size(), faces.size());
  for (std::size_t i = 0; i < mesh.subsegments.size(); ++i) {
    edges.insert(std::minmax(number_of.at(mesh.subsegments.ends[2 * i]),
                             number_of.at(mesh.subsegments.ends[2 * i + 1])));
  }
  for (const auto& e : indexed.edges) listed_edges.emplace(e.a, e.b);
  EXPECT_EQ(listed_edges, edges);
  EXPECT_EQ(indexed.subsegment_count(), mesh.subsegments.size());
  EXPECT_EQ(indexed.subfacet_count(), mesh.subfacets.size());
}

TEST(IndexSpaceMesh, RefusesSubfacetsOfUnknownVertices) {
  testing::Random random = MakeRandom();
  Mesh mesh = MakeUpLabelledMesh(random, 30, 0, 3);
  mesh.subfacets.corners[4] = 5;
  EXPECT_EQ(IndexMesh(mesh).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(FindSimplices, KnowsTetrahedraByTheirVertices) {
  const IndexedMesh mesh = IndexMesh(MakeGoodSpaceMesh(1, 20).mesh).value();
  const SimplexColumn all = ToMesh(mesh).simplices;
  const SimplexColumn some = {all.begin() + 8, all.begin() + 16};
  EXPECT_EQ(FindSimplices(mesh, some), (std::vector<std::uint32_t>{2, 3}));
}

void ExpectSameRows(const IndexedMesh& a, const IndexedMesh& b) {
  EXPECT_EQ(a.dimension, b.dimension);
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    ASSERT_EQ(a.vertices[i], b.vertices[i]) << i;
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(a.vertices[i].position()[k]),
                std::bit_cast<std::uint64_t>(b.vertices[i].position()[k]));
    }
  }
  EXPECT_EQ(a.tetrahedra, b.tetrahedra);
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.faces, b.faces);
  EXPECT_EQ(a.regions, b.regions);
}

TEST(SpaceMeshFiles, ReadBackAreTheSameMesh) {
  testing::Random random = MakeRandom();
  const TempFolder folder;
  for (int round = 0; round < 5; ++round) {
    Mesh mesh = MakeGoodSpaceMesh(random(), 60).mesh;
    if (round % 2 == 1) testing::Label(random, mesh);
    // Vertices of the box that refinement put there.
    int put = 0;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      if (mesh.vertices.owners[i] != kBoxFeature) continue;
      mesh.vertices.containing_dimensions[i] = static_cast<std::uint8_t>(++put % 3);
    }
    mesh.hash = ComputeHash(mesh);
    const IndexedMesh indexed = IndexMesh(mesh).value();
    ASSERT_TRUE(WriteMeshFiles(indexed, folder.Path("m.face")).ok());
    EXPECT_EQ(folder.FileCount(), 4U);
    for (const char* name : {"m", "m.node", "m.ele", "m.edge", "m.face"}) {
      const auto files = ReadMeshFiles(folder.Path(name));
      ASSERT_TRUE(files.ok()) << files.status();
      ExpectSameRows(files->mesh, indexed);
      EXPECT_EQ(files->recorded_hash, mesh.hash);
      EXPECT_EQ(ToMesh(files->mesh).hash, mesh.hash);
      EXPECT_TRUE(files->has_edges && files->has_faces);
    }
  }
}

TEST(SpaceMeshFiles, AreTetGens) {
  IndexedMesh mesh;
  mesh.dimension = 3;
  mesh.vertices = {
      {0, 0, 0, 10, 0}, {1, 0, 0, kBoxFeature, 0.5}, {0, 1, 2, 9, 0}, {0, 0, 3, kNoFeature, 1}};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  mesh.regions.polygons = {{4}};
  mesh.regions.numbers = {1};
  mesh.edges = {{0, 1, 7}, {0, 2, kNoFeature}, {1, 2, kBoxFeature}};
  mesh.faces = {{{0, 1, 2}, 9}, {{0, 1, 3}, kBoxFeature}};
  const TempFolder folder;
  ASSERT_TRUE(WriteMeshFiles(mesh, folder.Path("m")).ok());
  EXPECT_EQ(folder.Read("m.node"),
            "4 3 0 1\n1 0 0 0 10\n2 1 0 0.5 -1\n3 0 1 0 0\n4 0 0 1 0\n"
            "# dynmesh hash " +
                ToMesh(mesh).hash.ToHex() + "\n");
  EXPECT_EQ(folder.Read("m.ele"), "1 4 1\n1 1 2 3 4 1\n# dynmesh region 1 4\n");
  EXPECT_EQ(folder.Read("m.edge"), "3 1\n1 1 2 7\n2 1 3 0\n3 2 3 -1\n");
  EXPECT_EQ(folder.Read("m.face"), "2 1\n1 1 2 3 9\n2 1 2 4 -1\n");
}

TEST(SpaceMeshFiles, OfOthersAreRead) {
  const TempFolder folder;
  folder.Write("m.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n");
  folder.Write("m.ele", "1 4 0\n0 0 1 2 3\n");
  const auto files = ReadMeshFiles(folder.Path("m"));
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_FALSE(files->has_edges || files->has_faces);
  EXPECT_EQ(files->mesh.tetrahedra, (std::vector<IndexedMesh::Tetrahedron>{{0, 1, 2, 3}}));
  // `tetgen -f` lists every face, -nn the tetrahedra of each: without markers, or too wide.
  folder.Write("m.face", "2 0\n0 2 1 0\n1 3 1 0\n");
  EXPECT_EQ(ReadMeshFiles(folder.Path("m"))->mesh.faces,
            (std::vector<IndexedMesh::Face>{{{0, 1, 2}, kNoFeature}, {{0, 1, 3}, kNoFeature}}));
}

struct SpaceDamage {
  const char* file;
  const char* text;
  const char* message;
};

TEST(SpaceMeshFiles, MalformedAreRefusedWithFileAndLine) {
  const std::string nodes = "4 3 0 1\n1 0 0 0 0\n2 1 0 0 0\n3 0 1 0 0\n4 0 0 1 0\n";
  const std::string side = nodes + "# dynmesh box-face-vertices 5\n";
  const SpaceDamage damages[] = {
      {"m.node", "4 3 0 1\n1 0 0 0\n", "m.node:2: a vertex row has 5 values"},
      {"m.node", "4 4 0 1\n1 0 0 0 0\n", "m.node:1: dimension 4 is neither 2 nor 3"},
      {"m.node", side.c_str(), "box-face-vertices names no vertex: 5"},
      {"m.ele", "", "no tetrahedron header"},
      {"m.ele", "1 10 0\n", "m.ele:1: 10 nodes a tetrahedron; only 4"},
      {"m.ele", "1 3 0\n1 1 2 3\n", "m.ele:1: 3 nodes a tetrahedron"},
      {"m.ele", "1 4 0\n1 1 2 3 5\n", "m.ele:2: vertex 5 does not exist"},
      {"m.ele", "1 4 0\n1 1 2 3\n", "m.ele:2: a tetrahedron row has 5 values"},
      {"m.ele", "2 4 0\n1 1 2 3 4\n", "m.ele:2: the file ends after 1 of 2"},
      {"m.ele", "1 4 0\n1 1 2 3 4\n# dynmesh region 1 5\n", "tetrahedra have no attribute"},
      {"m.edge", "1 1\n1 1 9 0\n", "m.edge:2: vertex 9 does not exist"},
      {"m.face", "", "no face header"},
      {"m.face", "1 1\n1 1 2 9 0\n", "m.face:2: vertex 9 does not exist"},
      {"m.face", "1 1\n1 1 2 3\n", "m.face:2: a face row has 5 values"},
      {"m.face", "1 1\n1 1 2 3 x\n", "m.face:2: "},
      {"m.face", "1 1\n1 1 2 3 0\n2\n", "m.face:3: more values"},
      {"m.face", "2 1\n1 1 2 3 0\n", "m.face:2: the file ends after 1 of 2"},
  };
  for (const SpaceDamage& damage : damages) {
    const TempFolder folder;
    folder.Write("m.node", nodes);
    folder.Write("m.ele", "1 4 0\n1 1 2 3 4\n");
    folder.Write("m.edge", "1 1\n1 1 2 7\n");
    folder.Write("m.face", "1 1\n1 1 2 3 7\n");
    ASSERT_TRUE(ReadMeshFiles(folder.Path("m")).ok());
    folder.Write(damage.file, damage.text);
    const absl::Status status = ReadMeshFiles(folder.Path("m")).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << damage.text;
    EXPECT_NE(std::string(status.message()).find(damage.message), std::string::npos) << status;
  }
}

}  // namespace
}  // namespace dynmesh::io
