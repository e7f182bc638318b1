// Lists of formats for people: help and errors.
#include <algorithm>

#include "core/base/text.h"
#include "core/io/formats/formats.h"

namespace dynmesh::io {
namespace {

using text::Concat;

bool IsSurfaceOrPlane(const Format& f) {
  return f.read_geometry != nullptr && f.read_elements == nullptr && !f.Is(kScript);
}

}  // namespace

std::string JoinWords(const std::vector<std::string>& words, std::string_view last) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i != 0 && i + 1 == words.size()) {
      list.append(" ").append(last).append(" ");
    } else if (i != 0) {
      list.append(", ");
    }
    list.append(words[i]);
  }
  return list;
}

std::string GeometryFormats() {
  std::string plane;
  for (const Format& f : Formats()) {
    if (IsSurfaceOrPlane(f) && f.in_2d) plane.append(plane.empty() ? "" : ", ").append(f.extension);
  }
  return Concat(plane, " or an edit script; in 3D ",
                ListOfFormats([](const Format& f) { return IsSurfaceOrPlane(f) && f.in_3d; }),
                "; of 2D and 3D meshes ",
                ListOfFormats([](const Format& f) { return f.read_elements != nullptr; }));
}

std::string MeshOutputFormats() {
  return Concat(
      ListOfFormats([](const Format& f) { return f.write_mesh != nullptr && f.IsMainFile(); }),
      ", of a quadtree ", ListOfFormats([](const Format& f) { return f.write_leaves != nullptr; }));
}

std::string FeatureOutputFormats() {
  const auto list = [](auto has) {
    return ListOfFormats([&](const Format& f) { return f.write_features != nullptr && has(f); });
  };
  return Concat(list([](const Format& f) { return f.in_2d && !f.Is(kScript); }), ", or ",
                list([](const Format& f) { return f.Is(kScript); }),
                " (an edit script); of 3D input also ",
                list([](const Format& f) { return !f.in_2d; }));
}

std::string FormatTable() {
  std::string table = "extension  of        read as            written from       what it is\n";
  const auto column = [&](std::string cell, std::size_t width) {
    cell.resize(std::max(width, cell.size() + 1), ' ');
    table += cell;
  };
  for (const Format& f : Formats()) {
    std::vector<std::string> read, written;
    if (f.read_geometry != nullptr) read.emplace_back("geometry");
    if (f.read_mesh != nullptr) read.emplace_back("mesh");
    if (f.read_leaves != nullptr) read.emplace_back("leaves");
    if (f.read_sizes != nullptr) read.emplace_back("sizes");
    if (f.write_features != nullptr) written.emplace_back("geometry");
    if (f.write_mesh != nullptr) written.emplace_back("mesh");
    if (f.write_leaves != nullptr) written.emplace_back("leaves");
    column(std::string(f.extension), 11);
    column(f.in_2d && f.in_3d ? "2D, 3D" : f.in_2d ? "2D" : "3D", 10);
    column(JoinWords(read, "and"), 19);
    column(JoinWords(written, "and"), 19);
    table.append(f.what).append("\n");
  }
  return table;
}

}  // namespace dynmesh::io
