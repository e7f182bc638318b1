// Neighbours, Voronoi diagrams, constraints, numbering from 0 and elements of order 2.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_files.h"
#include "core/io/meshes/msh_writer.h"
#include "core/io/meshes/vtu_writer.h"
#include "core/io/plane/planar_input.h"
#include "core/io/space/space_input.h"
#include "gtest/gtest.h"
#include "tests/core/io/common/vtu_values.h"
#include "tests/core/io/meshes/good_space_mesh.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/support/number_rows.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::NumberRows;
using test::TempFolder;

std::vector<IndexedMesh> Meshes() {
  return {IndexMesh(testing::SampleMesh()).value(),
          IndexMesh(testing::MakeGoodSpaceMesh(5, 30).mesh).value()};
}

std::vector<std::set<std::uint32_t>> CornersOf(const IndexedMesh& mesh) {
  std::vector<std::set<std::uint32_t>> corners;
  ForEachSimplex(mesh, [&](const auto& s) { corners.emplace_back(s.begin(), s.end()); });
  return corners;
}

TEST(Neighbours, AreAcrossTheSidesOppositeToCorners) {
  for (const IndexedMesh& mesh : Meshes()) {
    const TempFolder folder;
    MeshFileOptions options;
    options.neighbours = true;
    options.from_zero = mesh.dimension == 3;
    ASSERT_TRUE(WriteMeshFiles(mesh, folder.Path("m.node"), options).ok());
    const auto rows = NumberRows(folder.Read("m.neigh"));
    const auto simplices = NumberRows(folder.Read("m.ele"));
    const auto base = static_cast<double>(options.base());
    const std::size_t width = static_cast<std::size_t>(mesh.dimension) + 1;
    ASSERT_EQ(rows[0], (std::vector<double>{static_cast<double>(mesh.simplex_count()),
                                            static_cast<double>(width)}));
    const auto corners = CornersOf(mesh);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      EXPECT_EQ(rows[1 + i][0], static_cast<double>(i) + base);
      for (std::size_t k = 0; k < width; ++k) {
        const auto corner = static_cast<std::uint32_t>(simplices[1 + i][1 + k] - base);
        std::set<std::uint32_t> side = corners[i];
        side.erase(corner);
        double wanted = -1;
        for (std::size_t j = 0; j < corners.size(); ++j) {
          if (j != i && std::ranges::includes(corners[j], side)) {
            wanted = static_cast<double>(j) + base;
          }
        }
        EXPECT_EQ(rows[1 + i][1 + k], wanted) << i << " " << k;
      }
    }
  }
}

TEST(Voronoi, NodesAreEquidistantAndEdgesJoinThoseOfNeighbours) {
  for (const IndexedMesh& mesh : Meshes()) {
    const TempFolder folder;
    MeshFileOptions options;
    options.voronoi = options.neighbours = true;
    ASSERT_TRUE(WriteMeshFiles(mesh, folder.Path("m"), options).ok());
    const auto nodes = NumberRows(folder.Read("m.v.node"));
    const auto edges = NumberRows(folder.Read("m.v.edge"));
    const auto d = static_cast<std::size_t>(mesh.dimension);
    const auto corners = CornersOf(mesh);
    ASSERT_EQ(nodes.size(), corners.size() + 1);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      std::vector<double> radii;
      for (const std::uint32_t v : corners[i]) {
        double square = 0;
        for (std::size_t k = 0; k < d; ++k) {
          square += std::pow(mesh.vertices[v].position()[k] - nodes[1 + i][1 + k], 2);
        }
        radii.push_back(std::sqrt(square));
      }
      for (const double radius : radii) EXPECT_NEAR(radius / radii[0], 1, 1e-6);
    }
    std::map<std::pair<double, double>, int> joined;
    std::size_t rays = 0;
    for (std::size_t i = 1; i < edges.size(); ++i) {
      if (edges[i][2] < 0) {
        EXPECT_EQ(edges[i].size(), 3 + d);
        ++rays;
      } else {
        ++joined[std::minmax(edges[i][1], edges[i][2])];
      }
    }
    std::size_t border = 0;
    const auto neighbours = NumberRows(folder.Read("m.neigh"));
    for (std::size_t i = 1; i < neighbours.size(); ++i) {
      for (std::size_t k = 1; k < neighbours[i].size(); ++k) {
        if (neighbours[i][k] < 0) {
          ++border;
        } else {
          EXPECT_EQ(joined[std::minmax(neighbours[i][0], neighbours[i][k])], 1);
        }
      }
    }
    EXPECT_EQ(rays, border);
  }
}

TEST(Constraints, ReadBackAsInput) {
  const TempFolder folder;
  const IndexedMesh plane = Meshes()[0], space = Meshes()[1];
  MeshFileOptions options;
  options.holes = {{{0.25, 0.5, 0.125}, {}, 3}};
  ASSERT_TRUE(WriteMeshFiles(plane, folder.Path("p.poly"), options).ok());
  const auto input = ReadPolyFile(folder.Path("p.poly"));
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->point_count, plane.vertices.size());
  EXPECT_EQ(input->segment_count, plane.subsegment_count());
  ASSERT_EQ(input->holes.size(), 1U);
  EXPECT_EQ(input->holes[0].position, (std::array<double, 3>{0.25, 0.5, 0}));
  for (const std::string name : {"s.smesh", "s.poly"}) {
    options.from_zero = name == "s.poly";
    const TempFolder other;
    ASSERT_TRUE(WriteMeshFiles(space, other.Path(name), options).ok());
    EXPECT_EQ(other.FileCount(), 2U);  // TetGen would read an .edge as segments
    const auto surface =
        name == "s.poly" ? ReadSpacePolyFile(other.Path(name)) : ReadSmeshFile(other.Path(name));
    ASSERT_TRUE(surface.ok()) << surface.status();
    EXPECT_EQ(surface->point_count, space.vertices.size());
    EXPECT_EQ(surface->features.size(), space.vertices.size() + space.faces.size());
    EXPECT_EQ(surface->holes.size(), 1U);
  }
}

TEST(MeshFiles, NumberedFromZeroAreReadAsTheSame) {
  for (const IndexedMesh& mesh : Meshes()) {
    const TempFolder folder;
    MeshFileOptions options;
    options.from_zero = true;
    options.rho = 1.25;
    options.min_dihedral = 5;
    options.is_part = true;
    ASSERT_TRUE(WriteMeshFiles(mesh, folder.Path("m.node"), options).ok());
    EXPECT_EQ(NumberRows(folder.Read("m.node"))[1][0], 0);
    const auto files = ReadMeshFiles(folder.Path("m.node"));
    ASSERT_TRUE(files.ok()) << files.status();
    EXPECT_EQ(files->mesh.vertices, mesh.vertices);
    EXPECT_EQ(files->mesh.edges, mesh.edges);
    EXPECT_EQ(files->recorded_hash, ToMesh(files->mesh).hash);
    EXPECT_EQ(files->rho, 1.25);
    EXPECT_EQ(files->min_dihedral, 5);
    EXPECT_TRUE(files->is_part);
    ASSERT_TRUE(WriteMeshFiles(mesh, folder.Path("n.node")).ok());
    EXPECT_FALSE(ReadMeshFiles(folder.Path("n.node"))->is_part);
    EXPECT_EQ(ReadMeshFiles(folder.Path("n.node"))->rho, std::nullopt);
  }
}

// Nodes of an element: corners, then what each format says of middles of edges.
void ExpectMiddles(const IndexedMesh& mesh, const std::vector<std::uint32_t>& nodes,
                   const std::vector<std::pair<std::size_t, std::size_t>>& edges) {
  const std::size_t corners = nodes.size() - edges.size();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto a = mesh.vertices[nodes[edges[i].first]].position();
    const auto b = mesh.vertices[nodes[edges[i].second]].position();
    const auto middle = mesh.vertices[nodes[corners + i]].position();
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(middle[k], a[k] / 2 + b[k] / 2);
  }
}

TEST(OrderTwo, HasMiddlesOfEdgesInTheOrderOfEachFormat) {
  for (IndexedMesh& mesh : std::vector(Meshes())) {
    const std::size_t corners = mesh.vertices.size();
    AddMidpoints(mesh);
    ASSERT_EQ(mesh.vertices.size(), corners + mesh.edges.size());
    const TempFolder folder;
    ASSERT_TRUE(WriteMeshFiles(mesh, folder.Path("m.node")).ok());
    ASSERT_TRUE(WriteMsh(mesh, folder.Path("m.msh")).ok());
    ASSERT_TRUE(WriteVtu(mesh, 2, folder.Path("m.vtu")).ok());
    const bool in_space = mesh.dimension == 3;
    const std::size_t width = in_space ? 10 : 6;
    using Edges = std::vector<std::pair<std::size_t, std::size_t>>;
    const Edges triangle = {{1, 2}, {2, 0}, {0, 1}};
    const Edges tetgen = {{2, 3}, {0, 3}, {0, 1}, {1, 2}, {1, 3}, {0, 2}};
    const auto rows = NumberRows(folder.Read("m.ele"));
    for (std::size_t i = 1; i < rows.size(); ++i) {
      ASSERT_EQ(rows[i].size(), 1 + width);
      std::vector<std::uint32_t> nodes;
      for (std::size_t k = 1; k <= width; ++k) {
        nodes.push_back(static_cast<std::uint32_t>(rows[i][k]) - 1);
      }
      ExpectMiddles(mesh, nodes, in_space ? tetgen : triangle);
    }
    const std::string xml = folder.Read("m.vtu");
    const auto connectivity = testing::VtuValues<std::int64_t>(xml, "connectivity");
    const Edges vtk = in_space ? Edges{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}
                               : Edges{{0, 1}, {1, 2}, {2, 0}};
    for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
      ExpectMiddles(mesh,
                    {connectivity.begin() + static_cast<std::ptrdiff_t>(width * i),
                     connectivity.begin() + static_cast<std::ptrdiff_t>(width * (i + 1))},
                    vtk);
    }
    EXPECT_EQ(testing::VtuValues<std::uint8_t>(xml, "types")[0], in_space ? 24 : 22);
    const std::string msh = folder.Read("m.msh");
    const Edges gmsh = in_space ? Edges{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {2, 3}, {1, 3}} : vtk;
    std::istringstream elements(msh.substr(msh.find("$Elements\n") + 10));
    std::size_t blocks = 0, found = 0, skipped = 0;
    elements >> blocks >> skipped >> skipped >> skipped;
    for (std::size_t b = 0; b < blocks; ++b) {
      std::size_t dimension = 0, tag = 0, type = 0, count = 0;
      elements >> dimension >> tag >> type >> count;
      const std::size_t nodes_of = type == 15 ? 1 : type == 8 ? 3 : type == 9 ? 6 : 10;
      for (std::size_t i = 0; i < count; ++i) {
        std::vector<std::uint32_t> nodes(nodes_of);
        elements >> tag;
        for (std::uint32_t& v : nodes) elements >> v, --v;
        if (nodes_of != width) continue;
        ++found;
        ExpectMiddles(mesh, nodes, gmsh);
      }
    }
    EXPECT_GE(found, mesh.simplex_count());
  }
}

}  // namespace
}  // namespace dynmesh::io
