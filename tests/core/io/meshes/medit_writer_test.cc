// .mesh, read back by a small reader, written from the format's specification only.
#include "core/io/meshes/medit_writer.h"

#include <bit>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "core/io/common/text_reader.h"
#include "gtest/gtest.h"
#include "tests/core/io/meshes/any_mesh.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;
using testing::SampleMesh;
using testing::SampleMeshWithRegions;

struct MeditContent {
  std::map<int, std::string> names;  // of references, from the comments
  std::map<int, std::string> triangle_names;
  struct Vertex {
    double x, y;
    int reference;
  };
  std::vector<Vertex> vertices;
  std::vector<std::vector<int>> edges;  // corners, then the reference
  std::vector<std::vector<int>> triangles;
};

// Reads words, knowing the tables of references from "# reference N: NAME" and
// "# triangle reference N: NAME".
class MeditReader {
 public:
  explicit MeditReader(const std::string& text) {
    std::size_t begin = 0;
    while (begin < text.size()) {
      const std::size_t end = text.find('\n', begin);
      const std::string line = text.substr(begin, end - begin);
      begin = end + 1;
      if (line.starts_with("# reference ")) {
        ReadName(line.substr(12), content_.names);
      } else if (line.starts_with("# triangle reference ")) {
        ReadName(line.substr(21), content_.triangle_names);
      } else if (!line.starts_with("#")) {
        body_ += line + "\n";
      }
    }
  }

  MeditContent Read() {
    TextReader reader("m.mesh", body_);
    while (reader.Next()) {
      for (const std::string_view token : reader.tokens()) words_.emplace_back(token);
    }
    EXPECT_EQ(Word(), "MeshVersionFormatted");
    EXPECT_EQ(Int(), 2);
    EXPECT_EQ(Word(), "Dimension");
    EXPECT_EQ(Int(), 2);
    for (std::string word = Word(); word != "End"; word = Word()) {
      const int count = Int();
      for (int i = 0; i < count; ++i) {
        if (word == "Vertices") {
          const double x = Real(), y = Real();
          content_.vertices.push_back({x, y, Int()});
        } else if (word == "Edges") {
          content_.edges.push_back(Row(2));
        } else if (word == "Triangles") {
          content_.triangles.push_back(Row(3));
        } else {
          ADD_FAILURE() << "unknown section " << word;
          return content_;
        }
      }
    }
    EXPECT_EQ(next_, words_.size());
    return content_;
  }

 private:
  static void ReadName(const std::string& text, std::map<int, std::string>& names) {
    std::size_t digits = 0;
    const int reference = std::stoi(text, &digits);
    names[reference] = text.substr(digits + 2);
  }
  std::string Word() { return next_ < words_.size() ? words_[next_++] : "End"; }
  int Int() {
    std::int64_t value = 0;
    const std::string word = Word();
    EXPECT_TRUE(ParseInt64(word, &value)) << word;
    EXPECT_LE(value, std::numeric_limits<std::int32_t>::max());
    return static_cast<int>(value);
  }
  double Real() {
    double value = 0;
    EXPECT_TRUE(ParseDouble(Word(), &value));
    return value;
  }
  std::vector<int> Row(int corners) {
    std::vector<int> row;
    for (int k = 0; k < corners; ++k) {
      row.push_back(Int());
      EXPECT_TRUE(row.back() >= 1 && row.back() <= static_cast<int>(content_.vertices.size()));
    }
    row.push_back(Int());
    return row;
  }

  MeditContent content_;
  std::string body_;
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

std::string MeditName(FeatureId owner) {
  if (owner == kNoFeature) return "";
  return owner == kBoxFeature ? "box" : "feature " + std::to_string(owner);
}

void ExpectHolds(const MeditContent& content, const IndexedMesh& mesh) {
  const auto name = [&](int reference) {
    return reference == 0 ? std::string() : content.names.at(reference);
  };
  ASSERT_EQ(content.vertices.size(), mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto& found = content.vertices[i];
    const auto& v = mesh.vertices[i];
    EXPECT_EQ(std::bit_cast<std::uint64_t>(found.x), std::bit_cast<std::uint64_t>(v.x));
    EXPECT_EQ(std::bit_cast<std::uint64_t>(found.y), std::bit_cast<std::uint64_t>(v.y));
    EXPECT_EQ(name(found.reference), MeditName(v.owner));
  }
  std::size_t row = 0;
  for (const auto& e : mesh.edges) {
    if (e.owner == kNoFeature) continue;
    ASSERT_LT(row, content.edges.size());
    const std::vector<int>& found = content.edges[row++];
    EXPECT_EQ(found[0], static_cast<int>(e.a) + 1);
    EXPECT_EQ(found[1], static_cast<int>(e.b) + 1);
    EXPECT_EQ(name(found[2]), MeditName(e.owner));
  }
  EXPECT_EQ(row, content.edges.size());
  ASSERT_EQ(content.triangles.size(), mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const std::vector<int> expected = {static_cast<int>(t[0]) + 1, static_cast<int>(t[1]) + 1,
                                       static_cast<int>(t[2]) + 1, content.triangles[i][3]};
    EXPECT_EQ(content.triangles[i], expected);
    if (mesh.regions.count() == 0) {
      EXPECT_EQ(content.triangles[i][3], 1);
    } else {
      EXPECT_EQ(content.triangle_names.at(content.triangles[i][3]),
                mesh.regions.Name(mesh.regions.Of(i)));
    }
  }
}

TEST(Medit, OfTheSampleIsThisFile) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(SampleMesh()).value();
  ASSERT_TRUE(WriteMedit(mesh, folder.Path("m.mesh")).ok());
  const std::string text = folder.Read("m.mesh");
  ExpectHolds(MeditReader(text).Read(), mesh);
  EXPECT_TRUE(
      text.starts_with("MeshVersionFormatted 2\n\nDimension 2\n\n"
                       "# reference 1: feature 10\n"
                       "# reference 2: feature 20\n"
                       "# reference 3: feature 30\n"
                       "# reference 4: box\n"
                       "\nVertices\n9\n"
                       "2 3.1 1\n"
                       "10 3.1 2\n"
                       "0 0 4\n"
                       "0 6 4\n"
                       "4 0 4\n"
                       "12 0 4\n"
                       "12 6 4\n"
                       "6 3.1 3\n"
                       "8 0.3333333333333333 0\n"
                       "\nEdges\n7\n"
                       "1 8 3\n"
                       "2 8 3\n"
                       "3 4 4\n"))
      << text;
  EXPECT_TRUE(text.ends_with("\nEnd\n"));
}

TEST(Medit, SaysWhichRegionATriangleIsIn) {
  const TempFolder folder;
  const IndexedMesh mesh = IndexMesh(SampleMeshWithRegions()).value();
  ASSERT_TRUE(WriteMedit(mesh, folder.Path("m.mesh")).ok());
  const MeditContent content = MeditReader(folder.Read("m.mesh")).Read();
  ExpectHolds(content, mesh);
  EXPECT_EQ(content.triangle_names,
            (std::map<int, std::string>{{1, "domain"},
                                        {2, "polygon 12"},
                                        {3, "polygons 12 40"},
                                        {4, "polygon 40"},
                                        {5, "polygons 40 18446744073709551614"}}));
}

TEST(Medit, KeepsEveryBitAndEveryOwnerOfAnyMesh) {
  const std::uint64_t seed = test::NewSeed();
  const TempFolder folder;
  const IndexedMesh mesh = testing::AnyMesh(seed, 2000);
  ASSERT_TRUE(WriteMedit(mesh, folder.Path("m.mesh")).ok());
  ExpectHolds(MeditReader(folder.Read("m.mesh")).Read(), mesh);
}

TEST(Medit, FeaturesOneToNKeepTheirNumbers) {
  IndexedMesh mesh;
  for (FeatureId id = 1; id <= 40; ++id) {
    mesh.vertices.push_back({static_cast<double>(id), 0, 0, id});
  }
  mesh.vertices.push_back({0, 9, 0, kBoxFeature});
  const TempFolder folder;
  ASSERT_TRUE(WriteMedit(mesh, folder.Path("m.mesh")).ok());
  const MeditContent content = MeditReader(folder.Read("m.mesh")).Read();
  for (int i = 0; i < 41; ++i) {
    EXPECT_EQ(content.vertices[static_cast<std::size_t>(i)].reference, i + 1);
  }
}

TEST(Medit, OfNothingIsStillAFile) {
  const TempFolder folder;
  ASSERT_TRUE(WriteMedit(IndexedMesh(), folder.Path("m.mesh")).ok());
  EXPECT_TRUE(MeditReader(folder.Read("m.mesh")).Read().vertices.empty());
  EXPECT_EQ(WriteMedit(IndexedMesh(), "/no/such/folder/m.mesh").code(),
            absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace dynmesh::io
