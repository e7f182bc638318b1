// The table of formats, its documents, and what is said of files that it does not have.
#include "core/io/formats/formats.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <functional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/formats/geometry.h"
#include "core/io/formats/mesh_input.h"
#include "core/io/formats/mesh_output.h"
#include "gtest/gtest.h"
#include "tests/support/source_path.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io::formats_test {
namespace {

using Extensions = std::set<std::string>;

std::string ReadDocument(const std::string& name) {
  std::ifstream in(test::SourcePath(name));
  EXPECT_TRUE(in) << name;
  return {std::istreambuf_iterator<char>(in), {}};
}

// As links name it: "Files of meshes" is files-of-meshes.
std::string AnchorOf(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    if (c == ' ') anchor += '-';
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_') {
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return anchor;
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

// The lines below the heading that `place`, FILE#ANCHOR, names; none if there is no such heading.
std::vector<std::string> SectionOf(const std::string& place) {
  const std::size_t hash = place.find('#');
  std::vector<std::string> section;
  std::size_t depth = 0;
  for (const std::string& line : LinesOf(ReadDocument(place.substr(0, hash)))) {
    const std::size_t level = line.find_first_not_of('#');
    const bool is_heading = level != 0 && level != std::string::npos && line[level] == ' ';
    if (is_heading && depth != 0 && level <= depth) break;
    if (depth != 0) section.push_back(line);
    if (is_heading && depth == 0 && AnchorOf(line.substr(level + 1)) == place.substr(hash + 1)) {
      depth = level;
    }
  }
  return section;
}

std::vector<std::string> CellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line.substr(1));
  for (std::string cell; std::getline(in, cell, '|');) cells.push_back(cell);
  return cells;
}

// Those of versions, as 2.2, are none.
constexpr char kAnExtension[] = "\\.(14|[0-9]?[a-z][a-z0-9]*)";

// The extensions in backticks: `.poly`, `--size h.asc`.
void AddExtensions(const std::string& cell, Extensions& to) {
  static const std::regex kCode("`([^`]*)`"), kExtension(kAnExtension);
  for (std::sregex_iterator code(cell.begin(), cell.end(), kCode), end; code != end; ++code) {
    const std::string text = (*code)[1];
    for (std::sregex_iterator e(text.begin(), text.end(), kExtension), last; e != last; ++e) {
      to.insert(e->str());
    }
  }
}

// Those in one column of the section's tables: the first one, or that with this title.
Extensions Documented(const std::vector<std::string>& section, const std::string& title = "") {
  Extensions found;
  std::size_t column = std::string::npos;
  bool in_table = false;
  for (const std::string& line : section) {
    if (line.empty() || line[0] != '|') {
      in_table = false;
      continue;
    }
    const std::vector<std::string> cells = CellsOf(line);
    if (!in_table) {
      in_table = true;
      column = title.empty() ? 0 : std::string::npos;
      for (std::size_t i = 0; i < cells.size() && !title.empty(); ++i) {
        if (cells[i].find(title) != std::string::npos) column = i;
      }
    } else if (column < cells.size()) {
      AddExtensions(cells[column], found);
    }
  }
  return found;
}

Extensions RowsThat(const std::function<bool(const Format&)>& has) {
  Extensions rows;
  for (const Format& f : Formats()) {
    if (has(f)) rows.emplace(f.extension);
  }
  return rows;
}

constexpr char kInput[] = "docs/input.md#formats";
constexpr char kMeshes[] = "docs/commands.md#files-of-meshes";

TEST(Formats, EachRowThatIsInputIsInTheDocumentAndTheOtherWayRound) {
  EXPECT_EQ(Documented(SectionOf(kInput)), RowsThat([](const Format& f) {
              return f.read_geometry != nullptr || f.read_sizes != nullptr;
            }));
}

TEST(Formats, EachRowThatImportWritesIsInTheDocumentAndTheOtherWayRound) {
  EXPECT_EQ(Documented(SectionOf(kInput), "`import` writes"),
            RowsThat([](const Format& f) { return f.write_features != nullptr; }));
}

TEST(Formats, EachRowOfMeshesIsInTheDocumentAndTheOtherWayRound) {
  EXPECT_EQ(Documented(SectionOf(kMeshes)), RowsThat([](const Format& f) {
              return f.write_mesh != nullptr || f.write_leaves != nullptr ||
                     f.read_leaves != nullptr;
            }));
}

TEST(Formats, EachRowNamesAPlaceThatHasIt) {
  for (const Format& f : Formats()) {
    const Extensions there = Documented(SectionOf(std::string(f.document)));
    EXPECT_TRUE(there.contains(std::string(f.extension))) << f.extension << ": " << f.document;
  }
}

// Of comments that name extensions for readers of the API.
TEST(Formats, TheApisNameEachRow) {
  // In the file, or in the list behind the word that it begins with, to the end of its paragraph.
  const auto named = [](const char* file, const std::string& list = "") {
    Extensions found;
    std::string text = ReadDocument(file);
    if (!list.empty()) {
      const std::size_t begin = text.find(list);
      EXPECT_NE(begin, std::string::npos) << file;
      text = text.substr(std::min(begin, text.size()));
      text = text.substr(0, text.find("\n\n"));
    }
    const std::regex extension(kAnExtension);
    for (std::sregex_iterator e(text.begin(), text.end(), extension), end; e != end; ++e) {
      found.insert(e->str());
    }
    return found;
  };
  const Extensions header = named("core/include/dynmesh/files.h");
  const Extensions python = named("client/python/dynmesh/_files.py");
  const Extensions written = named("client/python/dynmesh/_write.py", "Formats: ");
  for (const Format& f : Formats()) {
    const std::string extension(f.extension);
    EXPECT_TRUE(header.contains(extension)) << "files.h: " << extension;
    EXPECT_TRUE(python.contains(extension) || !f.read_geometry) << "_files.py: " << extension;
    if (!f.IsMainFile()) continue;
    EXPECT_TRUE(written.contains(extension) || !(f.write_mesh || f.write_leaves))
        << "_write.py: " << extension;
  }
}

TEST(Formats, RowsAreWhole) {
  Extensions seen;
  for (const Format& f : Formats()) {
    SCOPED_TRACE(f.extension);
    EXPECT_TRUE(std::regex_match(std::string(f.extension), std::regex(kAnExtension)));
    EXPECT_TRUE(seen.emplace(f.extension).second);
    EXPECT_FALSE(f.what.empty());
    EXPECT_TRUE(f.in_2d || f.in_3d);
    EXPECT_FALSE(IsOtherFormat("a" + std::string(f.extension)));
    EXPECT_EQ(FindFormat("folder.x/A" + std::string(f.extension)), &f);
    // Each does something, and elements are read as a mesh and as geometry.
    EXPECT_TRUE(f.read_geometry || f.read_mesh || f.read_leaves || f.read_sizes || f.write_mesh ||
                f.write_leaves);
    EXPECT_TRUE(!f.read_elements || (f.read_mesh && f.read_geometry));
    // A reader of meshes finds the other files by the base name.
    const std::string path = "a" + std::string(f.extension);
    const bool is_part = StemOfMeshFiles(path) != path;
    EXPECT_EQ(is_part, f.Is(kBesideNode) || f.extension == ".node");
  }
  EXPECT_EQ(FindFormat("PART.STL")->extension, ".stl");
  EXPECT_EQ(FindFormat("part"), nullptr);
}

TEST(Formats, AnUnknownExtensionGetsTheListOfThoseThatFit) {
  const auto has = [](const absl::Status& status, const Extensions& rows) {
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    for (const std::string& row : rows) {
      EXPECT_NE(status.message().find(row), std::string::npos) << row << ": " << status;
    }
  };
  has(ReadGeometry("a.nothing").status(),
      RowsThat([](const Format& f) { return f.read_geometry != nullptr; }));
  has(ReadAnyMesh("a.off").status(),
      RowsThat([](const Format& f) { return f.read_mesh && f.IsMainFile(); }));
  const std::vector<Feature> none;
  has(ReadSizes("a.off", {none, MeshOptions(), 1}).status(),
      RowsThat([](const Format& f) { return f.read_sizes != nullptr; }));
  has(ReadLeaves("a.off").status(),
      RowsThat([](const Format& f) { return f.read_leaves != nullptr; }));
  has(CheckMeshOutput("a.off"),
      RowsThat([](const Format& f) { return (f.write_mesh && f.IsMainFile()) || f.write_leaves; }));
  for (const int d : {2, 3}) {
    has(CheckFeatureOutput(d, "a.stl"),
        RowsThat([&](const Format& f) { return f.write_features && f.IsOf(d); }));
  }
}

TEST(Formats, WhatIsNoGeometryIsNoScript) {
  const test::TempFolder folder;
  GeometryOptions options;
  options.any_script = true;
  for (const char* name : {"a.svg", "a.csv", "a.ele", "a.neigh", "a.dxf", "a.png"}) {
    const absl::Status status =
        ReadGeometry(folder.Write(name, "mesh box=0,0,1,1\n"), options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented) << status;
  }
  EXPECT_EQ(ReadGeometry(folder.Write("a.npy", ""), options).status().code(),
            absl::StatusCode::kInvalidArgument);
  const std::string script = "mesh box=0,0,4,4\nadd point 1 1 1\n";
  EXPECT_EQ(ReadGeometry(folder.Write("a.edits", script), options)->features.size(), 1U);
  EXPECT_FALSE(ReadGeometry(folder.Path("a.edits")).ok());
}

TEST(Formats, MeshesAreWrittenAsWhatTheirDimensionAndKindAllow) {
  MeshOptions options;
  for (const Format& f : Formats()) {
    SCOPED_TRACE(f.extension);
    const std::string path = "a" + std::string(f.extension);
    for (const int d : {2, 3}) {
      options.dimension = d;
      options.kind = MeshKind::kDelaunay;
      EXPECT_EQ(CheckMeshOutputOf(options, path).ok(), f.write_mesh != nullptr && f.IsOf(d));
      options.kind = MeshKind::kQuadtree;
      EXPECT_EQ(CheckMeshOutputOf(options, path).ok(), f.write_leaves != nullptr);
    }
  }
}

}  // namespace
}  // namespace dynmesh::io::formats_test
