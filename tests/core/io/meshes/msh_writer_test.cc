// .msh, read back by a small reader, written from the format's specification only.
#include "core/io/meshes/msh_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/io/common/text_reader.h"
#include "core/io/elements/element_mesh.h"
#include "gtest/gtest.h"
#include "tests/core/io/meshes/any_mesh.h"
#include "tests/core/io/meshes/good_space_mesh.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;
using testing::SampleMesh;
using testing::SampleMeshWithRegions;

using Entity = std::pair<int, int>;  // dimension, tag

struct MshContent {
  std::map<Entity, std::string> physical_names;
  std::map<Entity, std::vector<int>> physical_of;  // of entities
  std::map<int, std::vector<int>> curve_points;
  std::map<int, std::vector<int>> surface_curves;
  std::map<int, std::vector<int>> volume_surfaces;
  std::map<std::uint64_t, std::array<double, 3>> nodes;
  std::map<std::uint64_t, Entity> entity_of_node;
  struct Element {
    Entity entity;
    int type = 0;
    std::vector<std::uint64_t> nodes;
  };
  std::map<std::uint64_t, Element> elements;
};

// Of one section, token by token; istreams do not read denormals, so ParseDouble does.
class Section {
 public:
  Section(const std::string& text, const std::string& name) {
    const std::size_t begin = text.find("$" + name + "\n");
    const std::size_t end = text.find("$End" + name + "\n");
    if (begin == std::string::npos || end == std::string::npos || end < begin) {
      ADD_FAILURE() << "no section " << name;
      return;
    }
    in_.str(text.substr(begin + name.size() + 2, end - begin - name.size() - 2));
  }
  long Int() {
    long value = 0;
    EXPECT_TRUE(in_ >> value);
    // Gmsh cannot read numbers beyond an int.
    EXPECT_LE(std::abs(value), std::numeric_limits<std::int32_t>::max());
    return value;
  }
  double Real() {
    std::string token;
    double value = 0;
    EXPECT_TRUE(in_ >> token);
    EXPECT_TRUE(ParseDouble(token, &value)) << token;
    return value;
  }
  std::string QuotedText() {
    std::string text;
    std::getline(in_ >> std::ws, text);
    EXPECT_TRUE(text.size() >= 2 && text.front() == '"' && text.back() == '"') << text;
    return text.substr(1, text.size() - 2);
  }
  void ExpectEnd() {
    std::string rest;
    EXPECT_FALSE(in_ >> rest) << rest;
  }

 private:
  std::istringstream in_;
};

void ReadEntities(const std::string& text, MshContent& content) {
  Section s(text, "Entities");
  long counts[4];
  for (long& count : counts) count = s.Int();
  for (int dimension = 0; dimension < 4; ++dimension) {
    for (long i = 0; i < counts[dimension]; ++i) {
      const int tag = static_cast<int>(s.Int());
      EXPECT_GT(tag, 0);
      double range[6];
      for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) range[k] = s.Real();
      if (dimension > 0) {
        EXPECT_LE(range[0], range[3]);
        EXPECT_LE(range[1], range[4]);
      }
      auto& physical = content.physical_of[{dimension, tag}];
      for (long n = s.Int(); n > 0; --n) physical.push_back(static_cast<int>(s.Int()));
      if (dimension == 0) continue;
      for (long n = s.Int(); n > 0; --n) {
        const int below = static_cast<int>(s.Int());
        EXPECT_TRUE(content.physical_of.contains({dimension - 1, std::abs(below)}));
        if (dimension == 1) content.curve_points[tag].push_back(below);
        if (dimension == 2) content.surface_curves[tag].push_back(below);
        if (dimension == 3) content.volume_surfaces[tag].push_back(below);
      }
    }
  }
  s.ExpectEnd();
}

void ReadNodes(const std::string& text, MshContent& content) {
  Section s(text, "Nodes");
  const long blocks = s.Int(), count = s.Int(), least = s.Int(), greatest = s.Int();
  for (long b = 0; b < blocks; ++b) {
    const Entity entity = {static_cast<int>(s.Int()), 0};
    const Entity block = {entity.first, static_cast<int>(s.Int())};
    EXPECT_TRUE(content.physical_of.contains(block));
    EXPECT_EQ(s.Int(), 0);  // not parametric
    std::vector<std::uint64_t> tags(static_cast<std::size_t>(s.Int()));
    for (auto& tag : tags) {
      const long read = s.Int();
      EXPECT_TRUE(read >= least && read <= greatest);
      tag = static_cast<std::uint64_t>(read);
    }
    for (const auto tag : tags) {
      const double x = s.Real(), y = s.Real(), z = s.Real();
      EXPECT_TRUE(content.nodes.emplace(tag, std::array{x, y, z}).second);
      content.entity_of_node[tag] = block;
    }
  }
  EXPECT_EQ(content.nodes.size(), static_cast<std::size_t>(count));
  s.ExpectEnd();
}

void ReadElements(const std::string& text, MshContent& content) {
  const std::map<int, std::pair<int, int>> kinds = {
      {15, {0, 1}}, {1, {1, 2}}, {2, {2, 3}}, {4, {3, 4}}};
  Section s(text, "Elements");
  const long blocks = s.Int(), count = s.Int(), least = s.Int(), greatest = s.Int();
  for (long b = 0; b < blocks; ++b) {
    MshContent::Element element;
    element.entity.first = static_cast<int>(s.Int());
    element.entity.second = static_cast<int>(s.Int());
    element.type = static_cast<int>(s.Int());
    EXPECT_TRUE(content.physical_of.contains(element.entity));
    ASSERT_TRUE(kinds.contains(element.type));
    const auto [dimension, corners] = kinds.at(element.type);
    EXPECT_EQ(dimension, element.entity.first);
    for (long n = s.Int(); n > 0; --n) {
      const long tag = s.Int();
      EXPECT_TRUE(tag >= least && tag <= greatest);
      element.nodes.clear();
      for (int k = 0; k < corners; ++k) {
        element.nodes.push_back(static_cast<std::uint64_t>(s.Int()));
        EXPECT_TRUE(content.nodes.contains(element.nodes.back()));
      }
      EXPECT_TRUE(content.elements.emplace(static_cast<std::uint64_t>(tag), element).second);
    }
  }
  EXPECT_EQ(content.elements.size(), static_cast<std::size_t>(count));
  s.ExpectEnd();
}

MshContent ReadMsh(const std::string& text) {
  MshContent content;
  EXPECT_TRUE(text.starts_with("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"));
  Section names(text, "PhysicalNames");
  for (long n = names.Int(); n > 0; --n) {
    const int dimension = static_cast<int>(names.Int());
    const int tag = static_cast<int>(names.Int());
    EXPECT_TRUE(content.physical_names.emplace(Entity{dimension, tag}, names.QuotedText()).second);
  }
  names.ExpectEnd();
  ReadEntities(text, content);
  ReadNodes(text, content);
  ReadElements(text, content);
  return content;
}

// "" for an entity without a group.
std::string NameOf(const MshContent& content, Entity entity) {
  const auto& groups = content.physical_of.at(entity);
  if (groups.empty()) return "";
  EXPECT_EQ(groups.size(), 1U);
  return content.physical_names.at({entity.first, groups[0]});
}

std::string NameOf(FeatureId owner) {
  return owner == kBoxFeature ? "box" : "feature " + std::to_string(owner);
}

// The names of a plane mesh's owners: one that has a curve has its name there, and another one as a
// point.
std::function<std::string(FeatureId, int)> NamesIn(const IndexedMesh& mesh) {
  std::set<FeatureId> with_curve = {kBoxFeature};
  for (const auto& e : mesh.edges) with_curve.insert(e.owner);
  for (const auto& v : mesh.vertices) {
    if (v.containing_dimension == 1) with_curve.insert(v.owner);
  }
  return [with_curve](FeatureId owner, int dimension) {
    return NameOf(owner) + (dimension == 0 && with_curve.contains(owner) ? " points" : "");
  };
}

// Everything that the mesh has is in the file, and nothing else.
void ExpectHolds(const MshContent& content, const IndexedMesh& mesh) {
  ASSERT_EQ(content.nodes.size(), mesh.vertices.size());
  // A free vertex is part of the region of some triangle around it.
  std::map<std::uint64_t, std::set<std::string>> regions_at;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const auto v : mesh.triangles[i]) {
      regions_at[v + 1ULL].insert(mesh.regions.Name(mesh.regions.Of(i)));
    }
  }
  const auto name_of = NamesIn(mesh);
  std::multiset<std::pair<std::uint64_t, std::string>> points, found_points;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto& v = mesh.vertices[i];
    const auto& node = content.nodes.at(i + 1);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(node[0]), std::bit_cast<std::uint64_t>(v.x));
    EXPECT_EQ(std::bit_cast<std::uint64_t>(node[1]), std::bit_cast<std::uint64_t>(v.y));
    EXPECT_EQ(node[2], 0);
    const Entity entity = content.entity_of_node.at(i + 1);
    const bool free = v.containing_dimension == 2 || v.owner == kNoFeature;
    if (free && regions_at.contains(i + 1)) {
      EXPECT_TRUE(regions_at.at(i + 1).contains(NameOf(content, entity)));
    } else {
      EXPECT_EQ(NameOf(content, entity), free ? "domain" : name_of(v.owner, entity.first));
    }
    const bool point = !free && v.containing_dimension == 0 && v.owner != kBoxFeature;
    EXPECT_EQ(entity.first, free ? 2 : point ? 0 : 1);
    if (point) points.emplace(i + 1, name_of(v.owner, 0));
  }
  using Edge = std::pair<std::set<std::uint64_t>, std::string>;
  std::multiset<Edge> edges, found_edges;
  for (const auto& e : mesh.edges) {
    if (e.owner != kNoFeature) edges.insert({{e.a + 1ULL, e.b + 1ULL}, name_of(e.owner, 1)});
  }
  using Triangle = std::pair<std::vector<std::uint64_t>, std::string>;
  std::multiset<Triangle> triangles, found_triangles;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    triangles.insert(
        {{t[0] + 1ULL, t[1] + 1ULL, t[2] + 1ULL}, mesh.regions.Name(mesh.regions.Of(i))});
  }
  for (const auto& [tag, element] : content.elements) {
    const std::string name = NameOf(content, element.entity);
    if (element.type == 15) found_points.emplace(element.nodes[0], name);
    if (element.type == 1) found_edges.insert({{element.nodes.begin(), element.nodes.end()}, name});
    if (element.type == 2) found_triangles.insert({element.nodes, name});
  }
  EXPECT_EQ(points, found_points);
  EXPECT_EQ(edges, found_edges);
  EXPECT_EQ(triangles, found_triangles);
}

TEST(Msh, HoldsTheMeshExactly) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(SampleMesh()).value();
  ASSERT_TRUE(WriteMsh(mesh, folder.Path("m.msh")).ok());
  const MshContent content = ReadMsh(folder.Read("m.msh"));
  ExpectHolds(content, mesh);
  // Segment 30 is reference 3 and runs from point 10 (reference 1) to 20 (reference 2).
  EXPECT_EQ(content.physical_names.at({1, 3}), "feature 30");
  EXPECT_EQ(content.curve_points.at(3), (std::vector<int>{1, -2}));
  EXPECT_EQ(content.physical_names.at({1, 4}), "box");
  EXPECT_FALSE(content.curve_points.contains(4));
}

TEST(Msh, HasASurfaceForEachRegion) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(SampleMeshWithRegions()).value();
  ASSERT_TRUE(WriteMsh(mesh, folder.Path("m.msh")).ok());
  const MshContent content = ReadMsh(folder.Read("m.msh"));
  ExpectHolds(content, mesh);
  EXPECT_EQ(content.physical_names.at({2, 1}), "domain");
  EXPECT_EQ(content.physical_names.at({2, 2}), "polygon 12");
  EXPECT_EQ(content.physical_names.at({2, 3}), "polygons 12 40");
  EXPECT_EQ(content.physical_names.at({2, 4}), "polygon 40");
  EXPECT_EQ(content.physical_names.at({2, 5}), "polygons 40 18446744073709551614");
  EXPECT_EQ(content.entity_of_node.at(9), Entity(2, 3));  // the free vertex
  // Segment 30 is reference 3, the box 4. Each triangle is in one group.
  EXPECT_EQ(content.surface_curves.at(1), (std::vector<int>{3, 4}));
  EXPECT_EQ(content.surface_curves.at(2), (std::vector<int>{3}));
  EXPECT_EQ(content.surface_curves.at(3), (std::vector<int>{3, 4}));
  EXPECT_EQ(content.surface_curves.at(4), (std::vector<int>{4}));
  EXPECT_EQ(content.surface_curves.at(5), (std::vector<int>{3}));
}

TEST(Msh, NamesAreNotLongerThanReadersTake) {
  IndexedMesh mesh;
  mesh.vertices = {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {2, 1}};
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}, {1, 4, 3}};
  // "polygons " and ids of 18 and five times 19 digits; one digit more; as many as there may be.
  const FeatureId digits19 = 1'000'000'000'000'000'000;
  std::vector<FeatureId> longest = {digits19 / 10};
  for (FeatureId i = 1; i <= 5; ++i) longest.push_back(digits19 + i);
  std::vector<FeatureId> longer = longest, most(1024);
  longer[0] = digits19;
  for (std::size_t i = 0; i < most.size(); ++i) most[i] = kBoxFeature - 2000 + i;
  mesh.regions.polygons = {longest, longer, most};
  mesh.regions.numbers = {1, 2, 3};
  const TempFolder folder;
  ASSERT_TRUE(WriteMsh(mesh, folder.Path("m.msh")).ok());
  const std::string text = folder.Read("m.msh");
  const MshContent content = ReadMsh(text);
  EXPECT_EQ(content.elements.size(), 3U);
  EXPECT_EQ(content.physical_names.at({2, 2}), mesh.regions.Name(1));
  EXPECT_EQ(content.physical_names.at({2, 2}).size(), 127U);
  EXPECT_EQ(content.physical_names.at({2, 3}), "region 2");
  EXPECT_EQ(content.physical_names.at({2, 4}), "region 3");
  EXPECT_NE(text.find("$EndPhysicalNames\n$Comments\nregion 2: " + mesh.regions.Name(2) +
                      "\nregion 3: " + mesh.regions.Name(3) + "\n$EndComments\n"),
            std::string::npos);
}

TEST(Msh, OfATriangleIsThisFile) {
  IndexedMesh mesh;
  mesh.vertices = {{0, 0, 0, 5}, {1, 0, 0, ~FeatureId{1}}, {0.1, 1e-310, 1, 7}, {-0.0, 3, 2, 0}};
  mesh.triangles = {{0, 1, 3}};
  mesh.edges = {{0, 1, kNoFeature}, {0, 2, 7}, {1, 2, 7}};
  const TempFolder folder;
  ASSERT_TRUE(WriteMsh(mesh, folder.Path("m.msh")).ok());
  EXPECT_EQ(folder.Read("m.msh"),
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
            "$PhysicalNames\n4\n"
            "0 1 \"feature 5\"\n"
            "0 3 \"feature 18446744073709551614\"\n"
            "1 2 \"feature 7\"\n"
            "2 1 \"domain\"\n"
            "$EndPhysicalNames\n"
            "$Entities\n2 1 1 0\n"
            "1 0 0 0 1 1\n"
            "3 1 0 0 1 3\n"
            "2 0 0 0 1 1e-310 0 1 2 2 1 -3\n"
            "1 0 0 0 1 3 0 1 1 0\n"
            "$EndEntities\n"
            "$Nodes\n4 4 1 4\n"
            "0 1 0 1\n1\n0 0 0\n"
            "0 3 0 1\n2\n1 0 0\n"
            "1 2 0 1\n3\n0.1 1e-310 0\n"
            "2 1 0 1\n4\n-0 3 0\n"
            "$EndNodes\n"
            "$Elements\n4 5 1 5\n"
            "0 1 15 1\n1 1\n"
            "0 3 15 1\n2 2\n"
            "1 2 1 2\n3 1 3\n4 2 3\n"
            "2 1 2 1\n5 1 2 4\n"
            "$EndElements\n");
}

TEST(Msh, KeepsEveryBitAndEveryOwnerOfAnyMesh) {
  const std::uint64_t seed = test::NewSeed();
  const TempFolder folder;
  const IndexedMesh mesh = testing::AnyMesh(seed, 2000);
  ASSERT_TRUE(WriteMsh(mesh, folder.Path("m.msh")).ok());
  ExpectHolds(ReadMsh(folder.Read("m.msh")), mesh);
}

TEST(Msh, OfAMeshOfSpaceHasPolygonsAsSurfaces) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(testing::MakeGoodSpaceMesh(5, 40).mesh).value();
  ASSERT_TRUE(WriteMsh(mesh, folder.Path("m.msh")).ok());
  const MshContent content = ReadMsh(folder.Read("m.msh"));
  ASSERT_EQ(content.nodes.size(), mesh.vertices.size());
  // What has faces has its name there, and another one for its edges.
  std::set<FeatureId> with_faces;
  for (const auto& f : mesh.faces) with_faces.insert(f.owner);
  const auto name_of = [&](FeatureId owner, int dimension) {
    return NameOf(owner) + (dimension == 1 && with_faces.contains(owner) ? " edges" : "");
  };
  std::set<std::string> names;
  for (const auto& [group, name] : content.physical_names) {
    EXPECT_TRUE(names.insert(name).second) << name;
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto& v = mesh.vertices[i];
    EXPECT_EQ(content.nodes.at(i + 1), v.position());
    const Entity entity = content.entity_of_node.at(i + 1);
    EXPECT_EQ(entity.first, v.owner == kBoxFeature ? 2 : v.containing_dimension);
    EXPECT_EQ(NameOf(content, entity),
              v.owner == kNoFeature ? "domain" : name_of(v.owner, entity.first));
  }
  using Row = std::pair<std::vector<std::uint64_t>, std::string>;
  std::map<int, std::multiset<Row>> rows, found;
  const auto add = [&](int type, const auto& corners, const std::string& name) {
    std::vector<std::uint64_t> nodes;
    for (const auto v : corners) nodes.push_back(v + 1ULL);
    rows[type].insert({nodes, name});
  };
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto& v = mesh.vertices[i];
    const bool point = v.containing_dimension == 0 && v.owner != kBoxFeature;
    if (point) add(15, std::array{i}, NameOf(v.owner));
  }
  for (const auto& e : mesh.edges) {
    if (e.owner != kNoFeature) add(1, std::array{e.a, e.b}, name_of(e.owner, 1));
  }
  for (const auto& f : mesh.faces) add(2, f.corners, NameOf(f.owner));
  for (const auto& t : mesh.tetrahedra) add(4, t, "domain");
  for (const auto& [tag, element] : content.elements) {
    found[element.type].insert({element.nodes, NameOf(content, element.entity)});
  }
  EXPECT_EQ(rows, found);
  // The box's surface borders the volume, the plate, which has it on both sides, does not; its
  // own curves border the plate.
  ASSERT_EQ(content.volume_surfaces.at(1).size(), 1U);
  EXPECT_EQ(NameOf(content, {2, content.volume_surfaces.at(1)[0]}), "box");
  std::set<std::string> curves;
  for (const auto& [tag, below] : content.surface_curves) {
    for (const int curve : below) curves.insert(NameOf(content, {1, curve}));
  }
  EXPECT_EQ(curves, (std::set{name_of(testing::kPlate, 1), NameOf(testing::kRim)}));
}

// Read again, both versions have the same elements, groups and names.
TEST(Msh, Version22HoldsWhat41Does) {
  const TempFolder folder;
  for (const Mesh& sample : {SampleMesh(), SampleMeshWithRegions()}) {
    for (const bool is_quadratic : {false, true}) {
      IndexedMesh mesh = IndexMesh(sample).value();
      if (is_quadratic) AddMidpoints(mesh);
      ASSERT_TRUE(WriteMsh(mesh, folder.Path("new.msh")).ok());
      ASSERT_TRUE(WriteMsh(mesh, folder.Path("old.msh"), MshVersion::k22).ok());
      EXPECT_EQ(folder.Read("old.msh").substr(0, 24), "$MeshFormat\n2.2 0 8\n$End");
      const auto is = ReadMshFile(folder.Path("new.msh")),
                 was = ReadMshFile(folder.Path("old.msh"));
      ASSERT_TRUE(is.ok() && was.ok()) << is.status() << was.status();
      EXPECT_EQ(is->names, was->names);
      EXPECT_FALSE(was->names.empty());
      // Nodes are in another order: elements by the places of their corners.
      const auto content = [](const ElementMesh& read) {
        std::multiset<std::pair<std::vector<std::array<double, 3>>, std::int64_t>> all;
        const auto add = [&](const auto& elements) {
          for (const auto& element : elements) {
            std::vector<std::array<double, 3>> corners;
            for (const auto v : element.corners) corners.push_back(read.positions[v]);
            all.emplace(corners, element.marker);
          }
        };
        add(read.points), add(read.segments), add(read.triangles), add(read.tetrahedra);
        return all;
      };
      EXPECT_EQ(content(*is), content(*was));
      EXPECT_GT(content(*was).size(), 5U);
    }
  }
}

// Read again, a binary file is the text to the bit, row by row.
TEST(Msh, BytesHoldWhatTextDoes) {
  const TempFolder folder;
  IndexedMesh quadratic = IndexMesh(SampleMeshWithRegions()).value();
  AddMidpoints(quadratic);
  const IndexedMesh meshes[] = {
      IndexMesh(SampleMesh()).value(), quadratic, testing::AnyMesh(test::NewSeed(), 500),
      IndexMesh(testing::MakeGoodSpaceMesh(5, 40).mesh).value(), IndexedMesh()};
  for (const IndexedMesh& mesh : meshes) {
    for (const MshVersion version : {MshVersion::k41, MshVersion::k22}) {
      ASSERT_TRUE(WriteMsh(mesh, folder.Path("text.msh"), version).ok());
      ASSERT_TRUE(WriteMsh(mesh, folder.Path("bytes.msh"), version, true).ok());
      EXPECT_EQ(folder.Read("bytes.msh").substr(16, 3), "1 8");
      const auto text = ReadMshFile(folder.Path("text.msh")),
                 bytes = ReadMshFile(folder.Path("bytes.msh"));
      ASSERT_EQ(text.ok(), bytes.ok()) << text.status() << bytes.status();
      if (!text.ok()) {  // AnyMesh may have an element with a vertex twice
        const auto what = [](const absl::Status& status) {
          const std::string said(status.message());
          return said.substr(said.find(": "));
        };
        EXPECT_EQ(what(text.status()), what(bytes.status()));
        continue;
      }
      EXPECT_EQ(text->names, bytes->names);
      EXPECT_EQ(text->dimension, bytes->dimension);
      ASSERT_EQ(text->positions.size(), bytes->positions.size());
      for (std::size_t v = 0; v < text->positions.size(); ++v) {
        for (std::size_t k = 0; k < 3; ++k) {
          EXPECT_EQ(std::bit_cast<std::uint64_t>(text->positions[v][k]),
                    std::bit_cast<std::uint64_t>(bytes->positions[v][k]));
        }
      }
      const auto compare = [](const auto& a, const auto& b) {
        ASSERT_EQ(a.size(), b.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
          EXPECT_EQ(a[i].corners, b[i].corners);
          EXPECT_EQ(a[i].marker, b[i].marker);
        }
      };
      compare(text->points, bytes->points), compare(text->segments, bytes->segments);
      compare(text->triangles, bytes->triangles), compare(text->tetrahedra, bytes->tetrahedra);
    }
  }
}

TEST(Msh, OfNothingIsStillAFile) {
  const TempFolder folder;
  ASSERT_TRUE(WriteMsh(IndexedMesh(), folder.Path("m.msh")).ok());
  const MshContent content = ReadMsh(folder.Read("m.msh"));
  EXPECT_TRUE(content.nodes.empty() && content.elements.empty() && content.physical_of.empty());
}

TEST(Msh, NamesTheFileThatCannotBeWritten) {
  const absl::Status status = WriteMsh(IndexedMesh(), "/no/such/folder/m.msh");
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_NE(std::string(status.message()).find("/no/such/folder/m.msh"), std::string::npos);
}

}  // namespace
}  // namespace dynmesh::io
