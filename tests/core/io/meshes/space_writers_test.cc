// .vtu and .mesh of 3D meshes, read back by code written from the formats only.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/io/common/text_reader.h"
#include "core/io/meshes/medit_writer.h"
#include "core/io/meshes/vtu_writer.h"
#include "gtest/gtest.h"
#include "tests/core/io/common/vtu_values.h"
#include "tests/core/io/meshes/good_space_mesh.h"
#include "tests/core/mesh_data/made_up_mesh.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;
using testing::kPlate;
using testing::MakeGoodSpaceMesh;
using testing::MakeRandom;
using testing::VtuValues;

IndexedMesh LabelledMesh() {
  testing::Random random = MakeRandom();
  Mesh mesh = MakeGoodSpaceMesh(random(), 40).mesh;
  testing::Label(random, mesh);
  return IndexMesh(mesh).value();
}

TEST(SpaceVtu, HoldsTetrahedraAndSubfacets) {
  const TempFolder folder;
  const IndexedMesh mesh = LabelledMesh();
  ASSERT_TRUE(WriteVtu(mesh, 2, folder.Path("m.vtu")).ok());
  const std::string xml = folder.Read("m.vtu");
  const std::size_t n = mesh.tetrahedra.size(), cells = n + mesh.subfacet_count();
  EXPECT_NE(xml.find("NumberOfCells=\"" + std::to_string(cells) + "\""), std::string::npos);
  std::vector<double> points;
  for (const auto& v : mesh.vertices) points.insert(points.end(), {v.x, v.y, v.z});
  EXPECT_EQ(VtuValues<double>(xml, "Points"), points);
  std::vector<std::int64_t> corners, ends, owners(n, 0);
  std::vector<std::uint8_t> types(n, 10);
  for (const auto& t : mesh.tetrahedra) {
    corners.insert(corners.end(), t.begin(), t.end());
    ends.push_back(static_cast<std::int64_t>(corners.size()));
  }
  for (const auto& f : mesh.faces) {
    if (f.owner == kBoxFeature) continue;
    corners.insert(corners.end(), f.corners.begin(), f.corners.end());
    ends.push_back(static_cast<std::int64_t>(corners.size()));
    owners.push_back(static_cast<std::int64_t>(f.owner));
    types.push_back(5);
  }
  ASSERT_GT(types.size(), n);
  EXPECT_EQ(VtuValues<std::int64_t>(xml, "connectivity"), corners);
  EXPECT_EQ(VtuValues<std::int64_t>(xml, "offsets"), ends);
  EXPECT_EQ(VtuValues<std::uint8_t>(xml, "types"), types);
  const std::string cell_data = xml.substr(xml.find("<CellData"));
  EXPECT_EQ(VtuValues<std::int64_t>(cell_data, "owner"), owners);
  const auto quality = VtuValues<double>(cell_data, "quality");
  const auto angles = VtuValues<double>(cell_data, "min_angle");
  const auto regions = VtuValues<std::uint32_t>(cell_data, "region");
  ASSERT_TRUE(quality.size() == cells && angles.size() == cells && regions.size() == cells);
  for (std::size_t i = 0; i < cells; ++i) {
    EXPECT_EQ(regions[i], i < n ? mesh.regions.Of(i) : 0);
    if (i >= n) {
      EXPECT_TRUE(std::isnan(quality[i]) && std::isnan(angles[i]));
      continue;
    }
    const TetrahedronQuality q = MeasureTetrahedron(mesh, i);
    EXPECT_EQ(quality[i], q.radius_edge);
    EXPECT_EQ(angles[i], q.min_angle_deg);
  }
}

TEST(SpaceVtu, TellsWhichTetrahedraAreBelowADihedralAngle) {
  const TempFolder folder;
  const IndexedMesh mesh = LabelledMesh();
  const std::size_t n = mesh.tetrahedra.size(), cells = n + mesh.subfacet_count();
  constexpr double kRho = 3;
  const std::vector<SimplexVerdict> verdicts = JudgeSimplices(mesh, kRho, 20);
  ASSERT_GT(std::count(verdicts.begin(), verdicts.end(), SimplexVerdict::kBelowDihedral), 0);
  for (const double bound : {0.0, 20.0}) {
    ASSERT_TRUE(WriteVtu(mesh, kRho, folder.Path("m.vtu"), bound).ok());
    const std::string xml = folder.Read("m.vtu");
    const auto angles = VtuValues<double>(xml, "min_dihedral");
    const auto exempt = VtuValues<std::uint8_t>(xml, "exempt");
    ASSERT_TRUE(angles.size() == cells && exempt.size() == cells);
    for (std::size_t i = 0; i < cells; ++i) {
      if (i >= n) {
        EXPECT_TRUE(std::isnan(angles[i]) && exempt[i] == 0);
        continue;
      }
      const TetrahedronQuality q = MeasureTetrahedron(mesh, i);
      EXPECT_EQ(angles[i], q.min_angle_deg);
      const bool is_below = q.min_angle_deg < bound && q.radius_edge <= kRho;
      EXPECT_EQ(exempt[i], is_below ? 3 : 0) << q.min_angle_deg << ", " << q.radius_edge;
    }
  }
}

// The rule of medit_writer.h by search and by volumes: outward of the first tetrahedron of the
// least region.
bool IsAsDocumented(const IndexedMesh& mesh, const std::array<std::uint32_t, 3>& corners) {
  const std::set<std::uint32_t> side(corners.begin(), corners.end());
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    const auto& t = mesh.tetrahedra[i];
    if (std::count_if(t.begin(), t.end(), [&](auto v) { return side.contains(v); }) != 3) continue;
    if (!best || mesh.regions.Of(i) < mesh.regions.Of(*best)) best = i;
  }
  if (!best) return false;
  const auto& t = mesh.tetrahedra[*best];
  const auto apex = *std::find_if(t.begin(), t.end(), [&](auto v) { return !side.contains(v); });
  std::array<std::array<double, 3>, 3> to;  // from the apex to the corners
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t k = 0; k < 3; ++k) {
      to[j][k] = mesh.vertices[corners[j]].position()[k] - mesh.vertices[apex].position()[k];
    }
  }
  const auto& [a, b, c] = to;
  const double volume = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                        a[2] * (b[0] * c[1] - b[1] * c[0]);
  return volume > 0 && corners[0] == *side.begin();
}

TEST(SpaceMedit, HoldsTheMesh) {
  const TempFolder folder;
  const IndexedMesh mesh = LabelledMesh();
  ASSERT_TRUE(WriteMedit(mesh, folder.Path("m.mesh")).ok());
  const std::string text = folder.Read("m.mesh");
  TextReader reader("m.mesh", text);
  std::map<std::string, std::vector<std::vector<std::string>>> sections;
  std::string section, count;
  while (reader.Next()) {
    std::vector<std::string> row(reader.tokens().begin(), reader.tokens().end());
    if (std::isalpha(static_cast<unsigned char>(row[0][0]))) {
      section = row[0];
      if (row.size() == 2) {
        EXPECT_EQ(row[1], section == "Dimension" ? "3" : "2");
      }
    } else {
      sections[section].push_back(row);
    }
  }
  // "# reference N: NAME" maps a reference to its feature.
  const auto name_of = [&](const char* kind, const std::string& reference) {
    const std::string start = std::string("# ") + kind + " " + reference + ": ";
    const std::size_t at = text.find(start);
    if (at == std::string::npos) return std::string("none");
    const std::size_t begin = at + start.size();
    return text.substr(begin, text.find('\n', begin) - begin);
  };
  const auto owner_name = [](FeatureId owner) {
    return owner == kNoFeature    ? "none"
           : owner == kBoxFeature ? "box"
                                  : "feature " + std::to_string(owner);
  };
  const auto expect_rows = [&](const char* name, std::size_t n) {
    const auto& rows = sections[name];
    EXPECT_EQ(rows.size(), n + 1) << name;
    EXPECT_EQ(rows[0], std::vector<std::string>{std::to_string(n)});
    return std::vector<std::vector<std::string>>(rows.begin() + 1, rows.end());
  };
  const auto vertices = expect_rows("Vertices", mesh.vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      double c = 0;
      EXPECT_TRUE(ParseDouble(vertices[i][k], &c));
      EXPECT_EQ(c, mesh.vertices[i].position()[k]);
    }
    EXPECT_EQ(name_of("reference", vertices[i][3]), owner_name(mesh.vertices[i].owner));
  }
  const auto tetrahedra = expect_rows("Tetrahedra", mesh.tetrahedra.size());
  for (std::size_t i = 0; i < tetrahedra.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(tetrahedra[i][k], std::to_string(mesh.tetrahedra[i][k] + 1));
    }
    EXPECT_EQ(name_of("tetrahedron reference", tetrahedra[i][4]),
              mesh.regions.Name(mesh.regions.Of(i)));
  }
  const auto faces = expect_rows("Triangles", mesh.faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    std::array<std::uint32_t, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = static_cast<std::uint32_t>(std::stoul(faces[i][k])) - 1;
    }
    EXPECT_TRUE(IsAsDocumented(mesh, corners)) << "row " << i;
    std::sort(corners.begin(), corners.end());
    EXPECT_EQ(corners, mesh.faces[i].corners);
    EXPECT_EQ(name_of("reference", faces[i][3]), owner_name(mesh.faces[i].owner));
  }
  expect_rows("Edges", mesh.subsegment_count());
}

}  // namespace
}  // namespace dynmesh::io
