// .su2, .inp, .2dm and .14, read back by small readers, written from the formats' descriptions
// only.
#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "core/io/solvers/abaqus_writer.h"
#include "core/io/solvers/adcirc_writer.h"
#include "core/io/solvers/named_facets.h"
#include "core/io/solvers/sms_writer.h"
#include "core/io/solvers/su2_writer.h"
#include "gtest/gtest.h"
#include "tests/core/io/meshes/good_space_mesh.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io::solver_writers_test {
namespace {

using test::TempFolder;
using Row = std::vector<std::uint32_t>;

IndexedMesh Indexed(const Mesh& mesh) {
  auto indexed = IndexMesh(mesh);
  EXPECT_TRUE(indexed.ok());
  return *std::move(indexed);
}
std::vector<Row> SimplicesOfAny(const IndexedMesh& mesh) {
  std::vector<Row> rows;
  ForEachSimplex(mesh, [&](const auto& c) { rows.emplace_back(c.begin(), c.end()); });
  return rows;
}
std::vector<IndexedMesh> Meshes() {
  const std::uint64_t seed = test::NewSeed();
  return {Indexed(testing::SampleMesh()), Indexed(testing::SampleMeshWithRegions()),
          Indexed(testing::MakeGoodSpaceMesh(seed, 40).mesh)};
}
Row RowOf(const IndexedMesh& mesh, const NamedFacet& facet) {
  const auto c = CornersOf(mesh, facet);
  return {c.begin(), c.begin() + mesh.dimension};
}
std::vector<std::string> NamesOf(const NamedParts& parts) {
  std::vector<std::string> names;
  for (const auto& set : parts.facets) names.push_back(set.name);
  return names;
}

TEST(Su2Writer, ReadsBack) {
  for (const IndexedMesh& mesh : Meshes()) {
    const TempFolder folder;
    ASSERT_TRUE(WriteSu2(mesh, folder.Path("m.su2")).ok());
    std::istringstream in(folder.Read("m.su2"));
    std::string word;
    std::size_t count = 0;
    int dimension = 0, kind = 0;
    in >> word >> dimension;
    EXPECT_EQ(word, "NDIME=");
    ASSERT_EQ(dimension, mesh.dimension);
    in >> word >> count;
    EXPECT_EQ(word, "NELEM=");
    std::vector<Row> simplices;
    for (std::size_t i = 0, number = 0; i < count; ++i) {
      in >> kind;
      EXPECT_EQ(kind, dimension == 2 ? 5 : 10);
      Row& row = simplices.emplace_back(static_cast<std::size_t>(dimension) + 1);
      for (auto& c : row) in >> c;
      in >> number;
      EXPECT_EQ(number, i);
    }
    EXPECT_EQ(simplices, SimplicesOfAny(mesh));
    in >> word >> count;
    EXPECT_EQ(word, "NPOIN=");
    ASSERT_EQ(count, mesh.vertices.size());
    for (std::size_t i = 0, number = 0; i < count; ++i) {
      const auto position = mesh.vertices[i].position();
      for (int k = 0; k < dimension; ++k) {
        in >> word;
        EXPECT_EQ(std::stod(word), position[static_cast<std::size_t>(k)]);
      }
      in >> number;
      EXPECT_EQ(number, i);
    }
    std::size_t markers = 0;
    in >> word >> markers;
    EXPECT_EQ(word, "NMARK=");
    std::map<std::string, std::vector<Row>> read;
    for (std::size_t k = 0; k < markers; ++k) {
      std::string name;
      in >> word >> name;
      EXPECT_EQ(word, "MARKER_TAG=");
      in >> word >> count;
      EXPECT_EQ(word, "MARKER_ELEMS=");
      for (std::size_t i = 0; i < count; ++i) {
        in >> kind;
        EXPECT_EQ(kind, dimension == 2 ? 3 : 5);
        Row& row = read[name].emplace_back(static_cast<std::size_t>(dimension));
        for (auto& c : row) in >> c;
      }
    }
    EXPECT_TRUE(static_cast<bool>(in));
    EXPECT_FALSE(in >> word) << word;
    std::map<std::string, std::vector<Row>> wanted;
    const auto parts = NamePartsOf(mesh);
    for (const FacetSet& set : parts->facets) {
      for (const NamedFacet& facet : set.facets) {
        if (facet.is_border) wanted[WordOf(set.name, 200)].push_back(RowOf(mesh, facet));
      }
    }
    EXPECT_EQ(read, wanted);
  }
}

// Sides of an element as Abaqus numbers them, as places of its corners.
const std::map<int, std::vector<std::vector<std::size_t>>> kAbaqusSides = {
    {2, {{0, 1}, {1, 2}, {2, 0}}}, {3, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}}};

TEST(AbaqusWriter, ReadsBack) {
  for (IndexedMesh mesh : Meshes()) {
    for (const int order : {1, 2}) {
      if (order == 2) AddMidpoints(mesh);
      const TempFolder folder;
      ASSERT_TRUE(WriteAbaqus(mesh, folder.Path("m.inp")).ok());
      std::vector<std::vector<std::string>> nodes;
      std::map<std::size_t, Row> elements;
      std::map<std::string, std::set<std::size_t>> element_sets, node_sets;
      std::map<std::string, std::vector<std::pair<std::size_t, int>>> surfaces;
      std::map<std::string, std::string> header;
      for (absl::string_view line : absl::StrSplit(folder.Read("m.inp"), '\n')) {
        if (line.empty() || absl::StartsWith(line, "**")) continue;
        std::vector<std::string> words = absl::StrSplit(line, ',');
        for (std::string& word : words) word = std::string(absl::StripAsciiWhitespace(word));
        if (line[0] == '*') {
          header = {{"", words[0]}};
          for (std::size_t i = 1; i < words.size(); ++i) {
            const std::vector<std::string> pair = absl::StrSplit(words[i], '=');
            header[pair.at(0)] = pair.at(1);
          }
        } else if (header[""] == "*NODE") {
          EXPECT_EQ(std::stoul(words[0]), nodes.size() + 1);
          nodes.push_back({words.begin() + 1, words.end()});
        } else if (header[""] == "*ELEMENT") {
          EXPECT_EQ(header["TYPE"], mesh.dimension == 2 ? (order == 1 ? "CPS3" : "CPS6")
                                                        : (order == 1 ? "C3D4" : "C3D10"));
          const std::size_t number = std::stoul(words[0]) - 1;
          element_sets[header["ELSET"]].insert(number);
          for (std::size_t i = 1; i < words.size(); ++i) {
            elements[number].push_back(static_cast<std::uint32_t>(std::stoul(words[i]) - 1));
          }
        } else if (header[""] == "*NSET") {
          EXPECT_LE(words.size(), 17u);
          for (const std::string& word : words) {
            if (!word.empty()) node_sets[header["NSET"]].insert(std::stoul(word) - 1);
          }
        } else if (header[""] == "*SURFACE") {
          ASSERT_EQ(words.size(), 2u);
          ASSERT_EQ(words[1][0], 'S');
          surfaces[header["NAME"]].emplace_back(std::stoul(words[0]) - 1,
                                                std::stoi(words[1].substr(1)));
        }
      }
      ASSERT_EQ(nodes.size(), mesh.vertices.size());
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          EXPECT_EQ(std::stod(nodes[i][k]), mesh.vertices[i].position()[k]);
        }
      }
      const auto simplices = SimplicesOfAny(mesh);
      ASSERT_EQ(elements.size(), simplices.size());
      // Midpoints: of the edges as the format lists them.
      const std::vector<std::pair<std::size_t, std::size_t>> between =
          mesh.dimension == 2
              ? std::vector<std::pair<std::size_t, std::size_t>>{{0, 1}, {1, 2}, {2, 0}}
              : std::vector<std::pair<std::size_t, std::size_t>>{{0, 1}, {1, 2}, {2, 0},
                                                                 {0, 3}, {1, 3}, {2, 3}};
      for (std::size_t i = 0; i < simplices.size(); ++i) {
        const Row& row = elements[i];
        const std::size_t corners = simplices[i].size();
        ASSERT_EQ(row.size(), corners + (order == 2 ? between.size() : 0));
        EXPECT_EQ(Row(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(corners)),
                  simplices[i]);
        for (std::size_t k = 0; k < row.size() - corners; ++k) {
          const auto a = mesh.vertices[row[between[k].first]].position();
          const auto b = mesh.vertices[row[between[k].second]].position();
          const auto m = mesh.vertices[row[corners + k]].position();
          for (std::size_t d = 0; d < 3; ++d) EXPECT_NEAR(m[d], (a[d] + b[d]) / 2, 1e-9);
        }
      }
      const auto parts = NamePartsOf(mesh);
      EXPECT_EQ(element_sets.size(), parts->regions.size());
      EXPECT_EQ(surfaces.size(), parts->facets.size());
      const std::vector<std::string> words = WordsOf(NamesOf(*parts), 72);
      for (std::size_t s = 0; s < words.size(); ++s) {
        const FacetSet& set = parts->facets[s];
        const auto& surface = surfaces["S_" + words[s]];
        ASSERT_EQ(surface.size(), set.facets.size());
        std::set<std::size_t> of_set;
        for (std::size_t k = 0; k < surface.size(); ++k) {
          const auto& [element, side] = surface[k];
          std::set<std::uint32_t> corners;
          for (const std::size_t c :
               kAbaqusSides.at(mesh.dimension).at(static_cast<std::size_t>(side) - 1)) {
            corners.insert(elements[element][c]);
          }
          const Row row = RowOf(mesh, set.facets[k]);
          EXPECT_EQ(corners, std::set<std::uint32_t>(row.begin(), row.end()));
          of_set.insert(corners.begin(), corners.end());
        }
        const auto& set_nodes = node_sets[words[s]];
        EXPECT_TRUE(std::ranges::includes(set_nodes, of_set));
        if (order == 1) {
          EXPECT_EQ(set_nodes, of_set);
        } else {
          EXPECT_GT(set_nodes.size(), of_set.size());
        }
      }
    }
  }
}

// Programs read 20 characters of a number, and take what follows for nothing.
TEST(AbaqusWriter, NumbersFitIntoTheirFields) {
  IndexedMesh mesh = Indexed(testing::SampleMesh());
  const double some[] = {6.123233995736766e-17,
                         -1.2246467991473532e-16,
                         -1.7976931348623157e308,
                         -5e-324,
                         -2.2250738585072014e-308,
                         1.0 / 3,
                         -0.00012345678901234567,
                         123456789012345680.0,
                         -98765.432109876543,
                         0.1 + 0.2,
                         -1e22,
                         4};
  std::size_t next = 0;
  for (auto& v : mesh.vertices) {
    v.x = some[next++ % std::size(some)];
    v.y = -some[next++ % std::size(some)];
  }
  const TempFolder folder;
  ASSERT_TRUE(WriteAbaqus(mesh, folder.Path("m.inp")).ok());
  std::size_t row = 0;
  bool in_nodes = false;
  for (absl::string_view line : absl::StrSplit(folder.Read("m.inp"), '\n')) {
    if (absl::StartsWith(line, "*")) in_nodes = line == "*NODE";
    if (!in_nodes || absl::StartsWith(line, "*")) continue;
    const std::vector<std::string> words = absl::StrSplit(line, ", ");
    ASSERT_EQ(words.size(), 4u) << line;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LE(words[k + 1].size(), 20u) << line;
      const double wanted = mesh.vertices[row].position()[k];
      EXPECT_NEAR(std::strtod(words[k + 1].c_str(), nullptr) / (wanted == 0 ? 1 : wanted),
                  wanted == 0 ? 0 : 1, 1e-12)
          << line;
    }
    ++row;
  }
  EXPECT_EQ(row, mesh.vertices.size());
}

// What a .2dm and a .14 say of vertices and triangles.
void CheckRows(const IndexedMesh& mesh, const std::vector<std::vector<double>>& nodes,
               const std::vector<Row>& triangles) {
  EXPECT_EQ(triangles, SimplicesOfAny(mesh));
  ASSERT_EQ(nodes.size(), mesh.vertices.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    EXPECT_EQ(nodes[i][0], mesh.vertices[i].x);
    EXPECT_EQ(nodes[i][1], mesh.vertices[i].y);
    EXPECT_EQ(nodes[i][2], mesh.labels.attributes == 0
                               ? 0
                               : mesh.labels.vertex_values[i * mesh.labels.attributes]);
  }
}

IndexedMesh WithDepths(IndexedMesh mesh) {
  mesh.labels.attributes = 2;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    mesh.labels.vertex_values.push_back(0.5 * static_cast<double>(i) - 1);
    mesh.labels.vertex_values.push_back(99);
  }
  return mesh;
}

TEST(SmsWriter, ReadsBack) {
  const IndexedMesh plain = Indexed(testing::SampleMeshWithRegions());
  for (const IndexedMesh& mesh : {plain, WithDepths(plain)}) {
    const TempFolder folder;
    ASSERT_TRUE(WriteSms(mesh, folder.Path("m.2dm")).ok());
    std::istringstream in(folder.Read("m.2dm"));
    std::vector<std::vector<double>> nodes;
    std::vector<Row> triangles;
    std::map<std::size_t, std::set<std::set<std::uint32_t>>> strings;
    std::vector<std::size_t> regions;
    Row open_string;
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line, "MESH2D");
    while (std::getline(in, line)) {
      std::istringstream words(line);
      std::string card;
      words >> card;
      std::size_t number = 0;
      if (card == "E3T") {
        Row row(3);
        std::size_t region = 0;
        words >> number >> row[0] >> row[1] >> row[2] >> region;
        for (auto& c : row) --c;
        triangles.push_back(row);
        EXPECT_EQ(number, triangles.size());
        regions.push_back(region);
      } else if (card == "ND") {
        std::string x, y, z;
        words >> number >> x >> y >> z;
        nodes.push_back({std::stod(x), std::stod(y), std::stod(z)});
        EXPECT_EQ(number, nodes.size());
      } else if (card == "NS") {
        long node = 0;
        while (words >> node) {
          open_string.push_back(static_cast<std::uint32_t>(std::abs(node) - 1));
          if (node < 0) break;
        }
        if (node > 0) continue;
        words >> number;
        for (std::size_t i = 0; i + 1 < open_string.size(); ++i) {
          EXPECT_TRUE(strings[number].insert({open_string[i], open_string[i + 1]}).second);
        }
        open_string.clear();
      } else {
        EXPECT_EQ(card, "#") << line;
      }
    }
    CheckRows(mesh, nodes, triangles);
    const auto parts = NamePartsOf(mesh);
    EXPECT_EQ(strings.size(), parts->facets.size());
    for (std::size_t s = 0; s < parts->facets.size(); ++s) {
      std::set<std::set<std::uint32_t>> wanted;
      for (const auto& [a, b] : EdgesOf(mesh, parts->facets[s])) wanted.insert({a, b});
      EXPECT_EQ(strings[s + 1], wanted);
    }
    for (std::size_t k = 0; k < parts->regions.size(); ++k) {
      for (const std::uint32_t i : parts->regions[k].simplices) EXPECT_EQ(regions[i], k + 1);
    }
  }
}

struct Adcirc {
  std::vector<std::vector<double>> nodes;
  std::vector<Row> triangles;
  std::vector<Row> open;
  std::vector<std::pair<int, Row>> land;
};
Adcirc ReadAdcirc(const std::string& text) {
  Adcirc read;
  std::istringstream in(text);
  std::string line;
  const auto next = [&] {
    EXPECT_TRUE(static_cast<bool>(std::getline(in, line)));
    return std::istringstream(line);
  };
  next();
  std::size_t triangles = 0, nodes = 0, number = 0;
  next() >> triangles >> nodes;
  for (std::size_t i = 0; i < nodes; ++i) {
    std::string x, y, z;
    next() >> number >> x >> y >> z;
    EXPECT_EQ(number, i + 1);
    read.nodes.push_back({std::stod(x), std::stod(y), std::stod(z)});
  }
  for (std::size_t i = 0; i < triangles; ++i) {
    Row row(3);
    int corners = 0;
    next() >> number >> corners >> row[0] >> row[1] >> row[2];
    EXPECT_EQ(number, i + 1);
    EXPECT_EQ(corners, 3);
    for (auto& c : row) --c;
    read.triangles.push_back(row);
  }
  for (const bool is_land : {false, true}) {
    std::size_t boundaries = 0, all = 0, sum = 0;
    next() >> boundaries;
    next() >> all;
    for (std::size_t k = 0; k < boundaries; ++k) {
      std::size_t count = 0;
      int type = -1;
      auto words = next();
      words >> count;
      if (is_land) words >> type;
      Row row;
      for (std::size_t i = 0; i < count; ++i) {
        std::uint32_t v = 0;
        next() >> v;
        row.push_back(v - 1);
      }
      sum += count;
      if (is_land) {
        read.land.emplace_back(type, row);
      } else {
        read.open.push_back(row);
      }
    }
    EXPECT_EQ(sum, all);
  }
  EXPECT_FALSE(std::getline(in, line)) << line;
  return read;
}

std::set<DirectedEdge> EdgesAlong(const Row& row, bool is_closed) {
  std::set<DirectedEdge> edges;
  for (std::size_t i = 0; i + 1 < row.size(); ++i) edges.emplace(row[i], row[i + 1]);
  if (is_closed) edges.emplace(row.back(), row.front());
  return edges;
}

TEST(AdcircWriter, ALonelyBorderIsMainland) {
  const IndexedMesh mesh = WithDepths(Indexed(testing::SampleMesh()));
  const TempFolder folder;
  ASSERT_TRUE(WriteAdcirc(mesh, folder.Path("fort.14")).ok());
  const Adcirc read = ReadAdcirc(folder.Read("fort.14"));
  CheckRows(mesh, read.nodes, read.triangles);
  EXPECT_TRUE(read.open.empty());
  ASSERT_EQ(read.land.size(), 1u);
  EXPECT_EQ(read.land[0].first, 0);
  EXPECT_EQ(read.land[0].second.size(), 6u);
  EXPECT_EQ(read.land[0].second.front(), read.land[0].second.back());
}

// Triangles around vertex 9 and below segment 30 are taken out: an island. The box's right side,
// between vertices 2 and 3, is open.
TEST(AdcircWriter, OpenSidesAndIslands) {
  IndexedMesh mesh = Indexed(testing::SampleMesh());
  const auto at = [&](double x, double y) {
    for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
      if (mesh.vertices[i].x == x && mesh.vertices[i].y == y) return i;
    }
    ADD_FAILURE();
    return std::uint32_t{0};
  };
  const std::uint32_t v2 = at(12, 0), v3 = at(12, 6), v8 = at(6, 3.1), v7 = at(10, 3.1),
                      v9 = at(8, 1.0 / 3);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    return std::ranges::count(t, v7) + std::ranges::count(t, v8) + std::ranges::count(t, v9) == 3;
  });
  auto labels = std::make_shared<FeatureLabels>();
  labels->names[77] = "Open sea";
  for (auto& e : mesh.edges) {
    if (std::set{e.a, e.b} == std::set{v2, v3}) e.owner = 77;
  }
  LabelRows(labels, false, mesh);
  const TempFolder folder;
  ASSERT_TRUE(WriteAdcirc(mesh, folder.Path("m.grd")).ok());
  const Adcirc read = ReadAdcirc(folder.Read("m.grd"));
  CheckRows(mesh, read.nodes, read.triangles);
  ASSERT_EQ(read.open.size(), 1u);
  EXPECT_EQ(read.open[0], (Row{v2, v3}));  // counter-clockwise around the sea
  ASSERT_EQ(read.land.size(), 2u);
  for (const auto& [type, row] : read.land) {
    if (type == 0) {
      EXPECT_EQ(row.front(), v3);
      EXPECT_EQ(row.back(), v2);
      EXPECT_EQ(row.size(), 5u);
    } else {
      EXPECT_EQ(type, 1);
      // Clockwise around the island.
      EXPECT_EQ(EdgesAlong(row, true), (std::set<DirectedEdge>{{v8, v7}, {v7, v9}, {v9, v8}}));
    }
  }
}

// The box's sides, by the place of their middles.
IndexedMesh BoxWithNames(const std::map<std::pair<double, double>, std::string>& names) {
  IndexedMesh mesh = Indexed(testing::SampleMesh());
  auto labels = std::make_shared<FeatureLabels>();
  FeatureId next = 70;
  for (auto& e : mesh.edges) {
    const auto& a = mesh.vertices[e.a];
    const auto& b = mesh.vertices[e.b];
    const auto name = names.find({(a.x + b.x) / 2, (a.y + b.y) / 2});
    if (name == names.end()) continue;
    e.owner = next++;
    labels->names[e.owner] = name->second;
  }
  EXPECT_EQ(labels->names.size(), names.size());
  LabelRows(labels, false, mesh);
  return mesh;
}

TEST(AdcircWriter, EachNameIsABoundaryOfItsOwn) {
  const IndexedMesh mesh =
      BoxWithNames({{{12, 3}, "open east"}, {{6, 6}, "Ocean north"}, {{8, 0}, "open south"}});
  const TempFolder folder;
  ASSERT_TRUE(WriteAdcirc(mesh, folder.Path("m.14")).ok());
  const Adcirc read = ReadAdcirc(folder.Read("m.14"));
  ASSERT_EQ(read.open.size(), 3u);
  for (const Row& row : read.open) EXPECT_EQ(row.size(), 2u);
  ASSERT_EQ(read.land.size(), 1u);  // the west, and half of the south
  EXPECT_EQ(read.land[0].first, 0);
  EXPECT_EQ(read.land[0].second.size(), 3u);
  std::set<DirectedEdge> all = EdgesAlong(read.land[0].second, false);
  for (const Row& row : read.open) all.merge(EdgesAlong(row, false));
  EXPECT_EQ(all.size(), 5u);
}

TEST(AdcircWriter, AnOpenBorderAllAroundHasEachVertexOnce) {
  IndexedMesh mesh = Indexed(testing::SampleMesh());
  auto labels = std::make_shared<FeatureLabels>();
  labels->names[77] = "open";
  for (auto& e : mesh.edges) {
    if (e.owner == kBoxFeature) e.owner = 77;
  }
  LabelRows(labels, false, mesh);
  const TempFolder folder;
  ASSERT_TRUE(WriteAdcirc(mesh, folder.Path("m.14")).ok());
  const Adcirc read = ReadAdcirc(folder.Read("m.14"));
  EXPECT_TRUE(read.land.empty());
  ASSERT_EQ(read.open.size(), 1u);
  EXPECT_EQ(std::set(read.open[0].begin(), read.open[0].end()).size(), 5u);
  EXPECT_EQ(read.open[0].size(), 5u);
}

TEST(AdcircWriter, AnOpenBoundaryInsideTheMeshIsRefused) {
  IndexedMesh mesh = Indexed(testing::SampleMesh());
  auto labels = std::make_shared<FeatureLabels>();
  labels->names[30] = "open sea";
  LabelRows(labels, false, mesh);
  const TempFolder folder;
  const absl::Status status = WriteAdcirc(mesh, folder.Path("m.14"));
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_TRUE(absl::StrContains(status.message(), "feature 30, open sea")) << status.message();
  EXPECT_EQ(folder.FileCount(), 0u);
}

TEST(AdcircWriter, ABorderThatTouchesItselfIsRefused) {
  IndexedMesh mesh = Indexed(testing::SampleMesh());
  std::erase_if(mesh.triangles, [&](const auto& t) {
    // All but two that share vertex 8 alone.
    const auto is = [&](std::initializer_list<std::pair<double, double>> corners) {
      std::set<std::pair<double, double>> of;
      for (const auto v : t) of.emplace(mesh.vertices[v].x, mesh.vertices[v].y);
      return of == std::set<std::pair<double, double>>(corners);
    };
    return !is({{8, 1.0 / 3}, {10, 3.1}, {6, 3.1}}) && !is({{6, 3.1}, {0, 6}, {2, 3.1}});
  });
  ASSERT_EQ(mesh.triangles.size(), 2u);
  const TempFolder folder;
  const absl::Status status = WriteAdcirc(mesh, folder.Path("m.14"));
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_TRUE(absl::StrContains(status.message(), "(6, 3.1)")) << status.message();
  EXPECT_EQ(folder.FileCount(), 0u);
}

TEST(SolverWriters, AFolderThatIsMissingIsNamed) {
  const IndexedMesh mesh = Indexed(testing::SampleMesh());
  for (const auto write : {WriteSu2, WriteAbaqus, WriteSms, WriteAdcirc}) {
    const absl::Status status = write(mesh, "/nonexistent/m");
    EXPECT_TRUE(absl::IsUnavailable(status));
    EXPECT_TRUE(absl::StrContains(status.message(), "/nonexistent/m")) << status.message();
  }
}

}  // namespace
}  // namespace dynmesh::io::solver_writers_test
