// Readers of .msh, .mesh, .vtu and the files of Triangle and TetGen.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/escaping.h"
#include "core/io/elements/element_mesh.h"
#include "core/io/formats/mesh_input.h"
#include "core/io/meshes/medit_writer.h"
#include "core/io/meshes/mesh_files.h"
#include "core/io/meshes/msh_writer.h"
#include "core/io/meshes/vtu_writer.h"
#include "gtest/gtest.h"
#include "tests/core/io/meshes/good_space_mesh.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;

// Two triangles on a square; the lower side is line 7, the upper triangle has 2.
constexpr char kMsh2[] =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"Inlet of gas\"\n2 2 \"Body\"\n"
    "$EndPhysicalNames\n$Nodes\n4\n10 0 0 0\n20 1 0 0\n30 1 1 0\n40 0 1 0\n$EndNodes\n"
    "$Elements\n3\n1 1 2 7 1 10 20\n2 2 2 1 1 10 20 30\n3 2 2 2 2 10 30 40\n$EndElements\n";
constexpr char kMsh4[] =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"Inlet of gas\"\n2 2 \"Body\"\n"
    "$EndPhysicalNames\n$Entities\n0 1 2 0\n5 0 0 0 1 0 0 1 -7 0\n1 0 0 0 1 1 0 1 1 1 5\n"
    "2 0 0 0 1 1 0 2 2 9 0\n$EndEntities\n$Unknown\n1 2 3\n$EndUnknown\n$Nodes\n2 4 10 40\n"
    "1 5 1 2\n10\n20\n0 0 0 0\n1 0 0 1\n2 1 0 2\n30\n40\n1 1 0\n0 1 0\n$EndNodes\n"
    "$Elements\n3 3 1 3\n1 5 1 1\n1 10 20\n2 1 2 1\n2 10 20 30\n2 2 2 1\n3 10 30 40\n"
    "$EndElements\n";
constexpr char kMedit[] =
    "MeshVersionFormatted 2 Dimension\n2\nVertices 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
    "Edges 1 1 2 7\nCorners 1\n4\nTriangles\n2\n1 2 3 1\n1 3 4 2\nEnd\nwhatever\n";
constexpr char kVtu[] =
    "<?xml version=\"1.0\"?>\n<!-- < > -->\n<VTKFile type='UnstructuredGrid' version=\"0.1\">\n"
    "<UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"3\">\n<Points>"
    "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">\n"
    "0 0 0 1 0 0\n1 1 0 0 1 0</DataArray></Points>\n<Cells>"
    "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 0 1 2 0 2 3</DataArray>"
    "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">2 5 8</DataArray>"
    "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">3 5 5</DataArray></Cells>\n"
    "<CellData><DataArray type=\"Int64\" Name=\"marker\" format=\"ascii\">7 1 2</DataArray>"
    "</CellData></Piece></UnstructuredGrid></VTKFile>\n";

absl::StatusOr<ElementMesh> Parse(const std::string& kind, const std::string& text) {
  if (kind == "vtu") return ParseVtu("a.vtu", text);
  return kind == "msh" ? ParseMsh(TextReader("a.msh", text))
                       : ParseMedit(TextReader("a.mesh", text));
}

TEST(ElementFiles, OfAllKindsSayTheSame) {
  const std::pair<std::string, std::string> files[] = {
      {"msh", kMsh2}, {"msh", kMsh4}, {"mesh", kMedit}, {"vtu", kVtu}};
  for (const auto& [kind, text] : files) {
    const auto mesh = Parse(kind, text);
    ASSERT_TRUE(mesh.ok()) << kind << mesh.status();
    EXPECT_EQ(mesh->dimension, 2);
    EXPECT_EQ(mesh->positions,
              (std::vector<std::array<double, 3>>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
    ASSERT_EQ(mesh->segments.size(), 1U);
    EXPECT_EQ(mesh->segments[0].corners, (std::array<std::uint32_t, 2>{0, 1}));
    EXPECT_EQ(mesh->segments[0].marker, 7);
    ASSERT_EQ(mesh->triangles.size(), 2U);
    EXPECT_EQ(mesh->triangles[1].corners, (std::array<std::uint32_t, 3>{0, 2, 3}));
    EXPECT_EQ(mesh->triangles[1].marker, 2);
    if (kind == "msh") {
      EXPECT_EQ(mesh->names.at({1, 7}), "Inlet of gas");
    }
  }
}

// The bytes of numbers; `swapped`: those of a machine with the other order.
class Bytes {
 public:
  explicit Bytes(bool swapped) : swapped_(swapped) {}
  Bytes& operator<<(std::string_view text) { return text_ += text, *this; }
  template <class T>
  Bytes& Add(std::initializer_list<T> numbers) {
    for (const T number : numbers) {
      char bytes[sizeof(T)];
      std::memcpy(bytes, &number, sizeof(T));
      if (swapped_) std::reverse(bytes, bytes + sizeof(T));
      text_.append(bytes, sizeof(T));
    }
    return *this;
  }
  Bytes& Ints(std::initializer_list<std::int32_t> numbers) { return Add(numbers); }
  Bytes& Sizes(std::initializer_list<std::uint64_t> numbers) { return Add(numbers); }
  Bytes& Reals(std::initializer_list<double> numbers) { return Add(numbers); }
  const std::string& text() const { return text_; }

 private:
  const bool swapped_;
  std::string text_;
};

constexpr char kMshNames[] =
    "\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"Inlet of gas\"\n2 2 \"Body\"\n"
    "$EndPhysicalNames\n";

// kMsh2 and kMsh4 as bytes.
std::string BinaryMsh2(bool swapped) {
  Bytes out(swapped);
  (out << "$MeshFormat\n2.2 1 8\n").Ints({1}) << kMshNames << "$Nodes\n4\n";
  out.Ints({10}).Reals({0, 0, 0}).Ints({20}).Reals({1, 0, 0});
  out.Ints({30}).Reals({1, 1, 0}).Ints({40}).Reals({0, 1, 0}) << "\n$EndNodes\n$Elements\n3\n";
  out.Ints({1, 1, 2, 1, 7, 1, 10, 20});
  out.Ints({2, 2, 2, 2, 1, 1, 10, 20, 30, 3, 2, 2, 10, 30, 40}) << "\n$EndElements\n";
  return out.text();
}
std::string BinaryMsh4(bool swapped) {
  Bytes out(swapped);
  (out << "$MeshFormat\n4.1 1 8\n").Ints({1}) << kMshNames << "$Entities\n";
  out.Sizes({0, 1, 2, 0}).Ints({5}).Reals({0, 0, 0, 1, 0, 0}).Sizes({1}).Ints({-7}).Sizes({0});
  out.Ints({1}).Reals({0, 0, 0, 1, 1, 0}).Sizes({1}).Ints({1}).Sizes({1}).Ints({5});
  out.Ints({2}).Reals({0, 0, 0, 1, 1, 0}).Sizes({2}).Ints({2, 9}).Sizes({0});
  out << "\n$EndEntities\n$Unknown\n";
  out.Sizes({0x2323232323, 12}) << "\n$EndUnknown\n$Nodes\n";
  out.Sizes({2, 4, 10, 40}).Ints({1, 5, 1}).Sizes({2, 10, 20});
  out.Reals({0, 0, 0, 0, 1, 0, 0, 1}).Ints({2, 1, 0}).Sizes({2, 30, 40});
  out.Reals({1, 1, 0, 0, 1, 0}) << "\n$EndNodes\n$Elements\n";
  out.Sizes({3, 3, 1, 3}).Ints({1, 5, 1}).Sizes({1, 1, 10, 20});
  out.Ints({2, 1, 2}).Sizes({1, 2, 10, 20, 30}).Ints({2, 2, 2}).Sizes({1, 3, 10, 30, 40});
  out << "\n$EndElements\n";
  return out.text();
}

TEST(ElementFiles, OfBytesSayWhatTextDoes) {
  const ElementMesh text = Parse("msh", kMsh2).value();
  for (const bool swapped : {false, true}) {
    for (const std::string& file : {BinaryMsh2(swapped), BinaryMsh4(swapped)}) {
      const auto mesh = Parse("msh", file);
      ASSERT_TRUE(mesh.ok()) << mesh.status();
      EXPECT_EQ(mesh->positions, text.positions);
      EXPECT_EQ(mesh->names, text.names);
      ASSERT_EQ(mesh->segments.size(), 1U);
      EXPECT_EQ(mesh->segments[0].corners, text.segments[0].corners);
      EXPECT_EQ(mesh->segments[0].marker, 7);
      ASSERT_EQ(mesh->triangles.size(), 2U);
      EXPECT_EQ(mesh->triangles[1].corners, text.triangles[1].corners);
      EXPECT_EQ(mesh->triangles[1].marker, 2);
    }
  }
}

// At each length an error, not a crash: "a.msh:LINE: ".
TEST(ElementFiles, OfBytesThatEndEarlyAreRefused) {
  for (const std::string& file : {BinaryMsh2(false), BinaryMsh4(true)}) {
    for (std::size_t size = 0; size + 1 < file.size(); ++size) {
      const auto mesh = Parse("msh", file.substr(0, size));
      ASSERT_FALSE(mesh.ok()) << size;
      EXPECT_TRUE(std::string(mesh.status().message()).starts_with("a.msh:"));
    }
  }
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ElementFiles, SayWhereAndWhatIsWrong) {
  const struct {
    std::string kind, text;
    int line;
    std::string message;
  } bad[] = {
      {"msh", "", 1, "no $Elements"},
      {"msh", "$Nodes\n", 1, "must begin with $MeshFormat"},
      {"msh", Replaced(kMsh2, "2.2", "3.0"), 2, "version 3"},
      {"msh", Replaced(kMsh2, "2.2 0", "2.2 1"), 2, "must have the number 1"},
      {"msh", Replaced(kMsh2, "2.2 0 8", "2.2 1 4"), 2, "numbers of 4 bytes cannot be read"},
      {"msh", Replaced(kMsh2, "2.2 0", "2.2 2"), 2, "0 (ASCII) or 1 (binary)"},
      {"msh", Replaced(kMsh2, "\"Body\"", "Body"), 7, "in quotes"},
      {"msh", Replaced(kMsh2, "\n20 1", "\n10 1"), 12, "vertex 10 stands twice"},
      {"msh", Replaced(kMsh2, "1 1 2 7 1 10 20", "1 3 2 7 1 10 20"), 18, "type 3 cannot be read"},
      {"msh", Replaced(kMsh2, "7 1 10 20", "7 1 10 50"), 18, "vertex 50 does not exist"},
      {"msh", Replaced(kMsh2, "7 1 10 20", "7 1 10 10"), 18, "vertex 10 twice"},
      {"msh", Replaced(kMsh2, "$Nodes\n4", "$Nodes\n5"), 15, "a vertex's number"},
      {"msh", Replaced(kMsh2, "$Nodes\n4", "$Nodes\n4000000"), 10, "too short for 4000000"},
      {"msh", Replaced(kMsh2, "$EndNodes\n", ""), 15, "expected $EndNodes"},
      {"msh", Replaced(kMsh2, "30 1 1 0", "30 1 nan 0"), 13, "not a finite number"},
      {"msh", Replaced(kMsh4, "1 10 20", "1 10"), 35, "vertex 2 does not exist"},
      {"msh", std::string(kMsh4) + "$Tail\n1 2\n", 40, "section $Tail has no $EndTail"},
      {"msh", Replaced(kMsh4, "$EndUnknown\n", ""), 15, "section $Unknown has no $EndUnknown"},
      {"mesh", "", 1, "MeshVersionFormatted"},
      {"mesh", Replaced(kMedit, "Dimension\n2", "Dimension\n4"), 2, "2 or 3"},
      {"mesh", Replaced(kMedit, "Edges", "Quadrilaterals"), 8, "section 'Quadrilaterals'"},
      {"mesh", Replaced(kMedit, "1 1 2 7", "1 1 5 7"), 8, "vertex 5 does not exist"},
      {"mesh", Replaced(kMedit, " Dimension\n2", ""), 2, "Dimension must stand before"},
      {"vtu", "", 1, "no unstructured grid: there is no array in Points"},
      {"vtu", Replaced(kVtu, "\"offsets\"", "\"ends\""), 1, "no array 'offsets' in Cells"},
      {"vtu", Replaced(kVtu, "'UnstructuredGrid'", "'PolyData'"), 3, "'PolyData'"},
      {"vtu", Replaced(kVtu, "version=\"0.1\"", "compressor=\"vtkLZ4\""), 3, "'vtkLZ4'"},
      {"vtu", Replaced(kVtu, "NumberOfCells=\"3\"", "NumberOfCells=\"x\""), 4, "NumberOfPoints"},
      {"vtu", Replaced(kVtu, "1 1 0 0 1 0", "1 1 0 0 1"), 5, "not 3 for 4 points"},
      {"vtu", Replaced(kVtu, "2 5 8", "2 5 9"), 8, "cell 2 has not the number"},
      {"vtu", Replaced(kVtu, "3 5 5", "3 5 9"), 8, "cell 2 is of type 9"},
      {"vtu", Replaced(kVtu, "0 1 0 1 2 0 2 3", "0 1 0 1 2 0 2 4"), 8, "vertex 4 does not exist"},
      {"vtu", Replaced(kVtu, "0 1 0 1 2", "0 1 0 1.5 2"), 8, "no value of type Int32"},
      {"vtu", Replaced(kVtu, "format=\"ascii\">2 5 8", "format=\"binary\">????"), 8, "no base64"},
      {"vtu", Replaced(kVtu, "</VTKFile>", "<VTKFile"), 9, "without an end"},
  };
  for (const auto& [kind, text, line, message] : bad) {
    const auto mesh = Parse(kind, text);
    ASSERT_FALSE(mesh.ok()) << kind << message;
    EXPECT_EQ(mesh.status().code(), absl::StatusCode::kInvalidArgument);
    const std::string said(mesh.status().message());
    EXPECT_NE(said.find(message), std::string::npos) << said;
    EXPECT_TRUE(said.starts_with("a." + kind + ":" + std::to_string(line) + ": ")) << said;
  }
}

// Of Triangle and TetGen, from memory.
using Parts = std::map<std::string, std::string>;
absl::StatusOr<ElementMesh> ReadParts(const Parts& parts) {
  return ReadTriangleFiles("a.ele", [&](const std::string& path) -> absl::StatusOr<TextReader> {
    const auto part = parts.find(path);
    if (part == parts.end()) return absl::NotFoundError(path + ": no such file");
    return TextReader(path, part->second);
  });
}

const Parts kPlane = {{"a.node", "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n"},
                      {"a.ele", "2 3 0\n1 1 2 3\n2 1 3 4\n"}};
const Parts kSpace = {{"a.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n"},
                      {"a.ele", "1 4 0\n0 0 1 2 3\n"}};

TEST(ElementFiles, OfTriangleSayWhereAndWhatIsWrong) {
  const struct {
    Parts others;
    std::string file, text, message;
  } bad[] = {
      {kPlane, "a.ele", "1 3 0\n1 1 2 2\n", ":2: an element has vertex 2 twice"},
      {kPlane, "a.ele", "1 3 0\n1 1 2 3\n2 1 3 4\n", ":3: more values after the last row"},
      {kPlane, "a.edge", "1 1\n1 1 2 5\n2 2 3 5\n", ":3: more values after the last row"},
      {kPlane, "a.edge", "1 1\n1 1 1 5\n", ":2: an element has vertex 1 twice"},
      {kPlane, "a.area", "1\n1 .5\n", ":1: limits of 1 elements, the .ele has 2"},
      {kPlane, "a.area", "2\n1 .5\n", ":2: the file ends after 1 limits"},
      {kPlane, "a.area", "2\n1 .5\n2 1\n3 1\n", ":4: more values after the last row"},
      {kPlane, "a.poly", "0 2\n1 0\n1 1 5\n0\n", ":3: "},
      {kPlane, "a.poly", "0 2\n1 0\n1 1 2\n1\n1 x .5\n", ":5: "},
      {kPlane, "a.poly", "0 2\n1 0\n1 1 2\n0\n0\n7\n", ":6: more values after the last row"},
      {kPlane, "a.poly", "2 2\n1 0 0\n2 0 1\n1 0\n1 1 2\n0\n",
       ":3: vertex 2 is not that of a.node"},
      {kPlane, "a.poly", "1 2\n0 0 0\n1 0\n0 0 0\n0\n", ":2: vertex 0 is not that of a.node"},
      {kSpace, "a.face", "1 1\n0 0 1 2 5\n1 1 2 3 5\n", ":3: more values after the last row"},
      {kSpace, "a.edge", "1 1\n0 0 1 5\n1 1 2 5\n", ":3: more values after the last row"},
      {kSpace, "a.vol", "1\n0 x\n", ":2: "},
  };
  for (const auto& [others, file, text, message] : bad) {
    Parts parts = others;
    parts[file] = text;
    const auto mesh = ReadParts(parts);
    ASSERT_FALSE(mesh.ok()) << file << message;
    EXPECT_EQ(mesh.status().code(), absl::StatusCode::kInvalidArgument);
    const std::string said(mesh.status().message());
    EXPECT_TRUE(said.starts_with(file + message)) << said;
  }
}

TEST(ElementFiles, APolyBesideAMeshMayHaveItsFirstVertices) {
  for (const std::string own : {"0 2\n", "2 2\n1 0 0\n2 1 0\n"}) {
    Parts parts = kPlane;
    parts["a.poly"] = own + "2 1\n1 1 2 5\n2 1 3 0\n1\n1 .5 .2\n";
    const auto mesh = ReadParts(parts);
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    ASSERT_EQ(mesh->segments.size(), 2U);
    EXPECT_EQ(mesh->segments[0].marker, 5);
    EXPECT_EQ(mesh->segment_file, "a.poly");
  }
}

TEST(ElementFiles, NamesOfAMshAreKeptToTheLetter) {
  for (const std::string name : {"two  blanks", "wall # 2", "#", " edge ", "tab\there"}) {
    for (const char* text : {kMsh2, kMsh4}) {
      const auto mesh = Parse("msh", Replaced(text, "Inlet of gas", name));
      ASSERT_TRUE(mesh.ok()) << name << ": " << mesh.status();
      EXPECT_EQ(mesh->names.at({1, 7}), name);
      EXPECT_EQ(mesh->names.at({2, 2}), "Body");
    }
  }
}

TEST(ElementFiles, ValuesOfXmlMayHaveBrackets) {
  const std::string attribute = "Note=\"a > b\" Other='\"/>' Name=\"connectivity\"";
  const auto mesh = Parse("vtu", Replaced(kVtu, "Name=\"connectivity\"", attribute));
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->triangles.size(), 2U);
}

// The size that an array announces is not believed: nothing is allocated for it.
TEST(ElementFiles, ABlockOfAVtuIsNoLargerThanZlibCanUnpack) {
  const auto base64 = [](const std::vector<std::uint32_t>& counts, const std::string& more) {
    const auto* const bytes = reinterpret_cast<const char*>(counts.data());
    return absl::Base64Escape(std::string(bytes, 4 * counts.size())) + absl::Base64Escape(more);
  };
  const std::string packed = std::string("\x78\x9c\x03\x00\x00\x00\x00\x01", 8);  // of nothing
  std::string text = Replaced(kVtu, "version=\"0.1\"", "compressor=\"vtkZLibDataCompressor\"");
  text = Replaced(text, "NumberOfCells=\"3\"", "NumberOfCells=\"2147483647\"");
  for (const std::uint32_t size : {9288U, 1U << 31, ~0U}) {
    const auto mesh =
        Parse("vtu", Replaced(text, "format=\"ascii\">0 1 0 1 2 0 2 3",
                              "format=\"binary\">" + base64({1, size, size, 8}, packed)));
    ASSERT_FALSE(mesh.ok());
    EXPECT_NE(std::string(mesh.status().message()).find("more bytes than zlib"), std::string::npos)
        << mesh.status();
  }
}

// With the most cells that a file may announce no bound overflows: the array is read, and what
// lacks is said.
TEST(ElementFiles, AVtuThatAnnouncesTheMostCellsIsReadToItsEnd) {
  std::string text = Replaced(kVtu, "NumberOfCells=\"3\"", "NumberOfCells=\"2147483647\"");
  text = Replaced(
      text, "type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 0 1 2 0 2 3",
      "type=\"Int64\" Name=\"connectivity\" format=\"binary\">" + [] {
        std::string raw("\x40\0\0\0", 4);
        for (const char v : {0, 1, 0, 1, 2, 0, 2, 3}) raw += v + std::string(7, '\0');
        return absl::Base64Escape(raw);
      }());
  const auto mesh = Parse("vtu", text);
  ASSERT_FALSE(mesh.ok());
  EXPECT_NE(std::string(mesh.status().message()).find("have not 2147483647 values"),
            std::string::npos)
      << mesh.status();
}

// What our writers write is read as it was, in all formats.
TEST(ElementFiles, OfOursReadBack) {
  for (const int dimension : {2, 3}) {
    const Mesh whole =
        dimension == 2 ? testing::SampleMesh() : testing::MakeGoodSpaceMesh(3, 30).mesh;
    const IndexedMesh mesh = IndexMesh(whole).value();
    const TempFolder folder;
    ASSERT_TRUE(WriteMsh(mesh, folder.Path("m.msh")).ok());
    ASSERT_TRUE(WriteMedit(mesh, folder.Path("m.mesh")).ok());
    ASSERT_TRUE(WriteVtu(mesh, 2, folder.Path("m.vtu")).ok());
    ASSERT_TRUE(WriteMeshFiles(mesh, folder.Path("m.node")).ok());
    for (const char* name : {"m.msh", "m.mesh", "m.vtu", "m.node"}) {
      const auto read = ReadElements(folder.Path(name));
      ASSERT_TRUE(read.ok()) << read.status();
      ASSERT_EQ(read->dimension, dimension);
      EXPECT_EQ(ToMesh(ToIndexed(*read)).simplices.size(), whole.simplices.size());
      // By coordinates: a .msh has its vertices in another order.
      const auto simplices_of = [](const IndexedMesh& m) {
        std::vector<std::vector<std::array<double, 3>>> rows;
        ForEachSimplex(m, [&](const auto& corners) {
          auto& row = rows.emplace_back();
          for (const std::uint32_t v : corners) row.push_back(m.vertices[v].position());
          std::ranges::sort(row);
        });
        std::ranges::sort(rows);
        return rows;
      };
      EXPECT_EQ(simplices_of(ToIndexed(*read)), simplices_of(mesh)) << name;
    }
  }
}

}  // namespace
}  // namespace dynmesh::io
