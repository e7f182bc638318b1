// Chooses the reader by extension; and the meshes of Triangle and TetGen.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/text.h"
#include "core/io/common/node_input.h"
#include "core/io/common/triangle_sections.h"
#include "core/io/elements/element_mesh.h"
#include "core/io/meshes/mesh_files.h"

namespace dynmesh::io {
namespace {

using text::Concat;

absl::StatusOr<std::optional<TextReader>> OpenIfThere(const OpenFile& open,
                                                      const std::string& path) {
  absl::StatusOr<TextReader> file = open(path);
  if (file.ok()) return std::optional<TextReader>(*std::move(file));
  if (absl::IsNotFound(file.status())) return std::optional<TextReader>();
  return file.status();
}

// A whole number is its own marker. The marker of another number is its bits, and so is that of a
// number from 2^53 on: below, bits are those of numbers that are 0 here, so no two share a marker.
std::int64_t MarkerOf(double attribute, std::map<std::int64_t, double>& fractions) {
  if (std::abs(attribute) < 0x1p53 && attribute == std::trunc(attribute)) {
    return static_cast<std::int64_t>(attribute);
  }
  if (!std::isnormal(attribute)) return 0;  // NaN is none
  const auto marker = std::bit_cast<std::int64_t>(attribute);
  fractions[marker] = attribute;
  return marker;
}

// Of a row of `reader`'s file.
template <std::size_t K>
absl::Status CheckCorners(const TextReader& reader, const NodeSection& nodes,
                          const std::array<std::uint32_t, K>& corners, int line) {
  for (std::size_t k = 0; k < K; ++k) {
    for (std::size_t j = 0; j < k; ++j) {
      if (corners[j] != corners[k]) continue;
      return TextReader::ErrorAt(
          reader.name(), line, Concat("an element has vertex ", nodes.base + corners[k], " twice"));
    }
  }
  return absl::OkStatus();
}

template <int D>
absl::Status AddSimplices(TextReader& reader, const NodeSection& nodes,
                          std::vector<Element<D + 1>>& elements, ElementMesh& mesh) {
  const absl::StatusOr<SimplexSection<D>> rows = ReadSimplexSection<D>(reader, nodes);
  if (!rows.ok()) return rows.status();
  for (std::size_t i = 0; i < rows->corners.size(); ++i) {
    if (auto s = CheckCorners(reader, nodes, rows->corners[i], rows->lines[i]); !s.ok()) return s;
    const std::int64_t marker =
        rows->attributes.empty() ? 0 : MarkerOf(rows->attributes[i], mesh.fractions);
    elements.push_back({rows->corners[i], marker, rows->lines[i]});
  }
  (D == 2 ? mesh.triangle_file : mesh.tetrahedron_file) = reader.name();
  return ExpectEnd(reader);
}

// Rows with a marker other than 0; all rows of a .poly.
template <std::size_t K>
absl::Status AddRows(TextReader& reader, const char* what, const NodeSection& nodes, bool all,
                     std::vector<Element<K>>& elements) {
  const absl::StatusOr<TupleSection<K>> rows = ReadTupleSection<K>(reader, what, nodes);
  if (!rows.ok()) return rows.status();
  for (std::size_t i = 0; i < rows->ends.size(); ++i) {
    if (auto s = CheckCorners(reader, nodes, rows->ends[i], rows->lines[i]); !s.ok()) return s;
    if (rows->markers[i] == 0 && !all) continue;
    elements.push_back(
        {rows->ends[i], static_cast<std::int64_t>(rows->markers[i]), rows->lines[i]});
  }
  return absl::OkStatus();
}

// Vertices of the .poly are those with which the .node begins, or there are none.
absl::Status CheckOwnVertices(const TextReader& poly, const NodeSection& own,
                              const NodeSection& nodes, const ElementMesh& mesh) {
  for (std::size_t i = 0; i < own.positions.size(); ++i) {
    const bool is_there = own.base == nodes.base && i < nodes.positions.size();
    if (is_there && own.positions[i] == nodes.positions[i]) continue;
    return TextReader::ErrorAt(poly.name(), own.lines[i],
                               Concat("vertex ", own.base + i, " is not that of ", mesh.file,
                                      ": it is no .poly of this mesh"));
  }
  return absl::OkStatus();
}

// The segments of a .poly. Its holes and regions are known from the triangles.
absl::Status AddPoly(TextReader& poly, const NodeSection& nodes, ElementMesh& mesh) {
  const absl::StatusOr<NodeSection> own = ReadNodeSection(poly, 2);
  if (!own.ok()) return own.status();
  if (auto s = CheckOwnVertices(poly, *own, nodes, mesh); !s.ok()) return s;
  if (auto s = AddRows<2>(poly, "segment", nodes, true, mesh.segments); !s.ok()) return s;
  mesh.segment_file = poly.name();
  FileFeatures ignored;
  return ReadSeedSections(poly, 2, ignored);
}

// "count", then "number limit" for each simplex.
absl::Status ReadLimits(TextReader& reader, std::size_t simplices, ElementMesh& mesh) {
  if (!reader.Next()) return reader.Error("the file has no header");
  const absl::StatusOr<std::uint64_t> count = reader.Uint64(0, "the number of limits");
  if (!count.ok()) return count.status();
  if (*count != simplices) {
    return reader.Error(Concat("limits of ", *count, " elements, the .ele has ", simplices));
  }
  for (std::size_t i = 0; i < simplices; ++i) {
    if (!reader.Next()) return reader.Error(Concat("the file ends after ", i, " limits"));
    const absl::StatusOr<double> limit = reader.Double(1, "a limit");
    if (!limit.ok()) return limit.status();
    mesh.limits.push_back(*limit);
    mesh.limit_lines.push_back(reader.line());
  }
  mesh.limit_file = reader.name();
  return ExpectEnd(reader);
}

// Markers of vertices, but those that a vertex has from the first of its segments (then faces) with
// a marker: these need no group of points of their own.
void AddMarkersOfVertices(const NodeSection& nodes, ElementMesh& mesh) {
  std::vector<std::int64_t> inherited(nodes.markers.size(), 0);
  const auto inherit = [&](const auto& elements) {
    for (const auto& element : elements) {
      for (const std::uint32_t v : element.corners) {
        if (inherited[v] == 0) inherited[v] = element.marker;
      }
    }
  };
  inherit(mesh.segments);
  if (mesh.dimension == 3) inherit(mesh.triangles);
  for (std::uint32_t v = 0; v < inherited.size(); ++v) {
    const auto marker = static_cast<std::int64_t>(nodes.markers[v]);
    if (marker != 0 && marker != inherited[v]) mesh.points.push_back({{v}, marker, nodes.lines[v]});
  }
}

}  // namespace

absl::StatusOr<ElementMesh> ReadTriangleFiles(const std::string& path, const OpenFile& open) {
  const std::string stem = StemOfMeshFiles(path);
  absl::StatusOr<TextReader> nodes = open(stem + ".node");
  if (!nodes.ok()) return nodes.status();
  absl::StatusOr<NodeSection> section = ReadNodeSection(*nodes, kStatedDimension);
  if (!section.ok()) return section.status();
  if (auto s = ExpectEnd(*nodes); !s.ok()) return s;
  absl::StatusOr<TextReader> simplices = open(stem + ".ele");
  if (!simplices.ok()) return simplices.status();
  ElementMesh mesh;
  mesh.file = stem + ".node";
  mesh.dimension = section->dimension;
  mesh.positions = section->positions;
  mesh.lines = section->lines;
  mesh.attributes = section->attributes;
  mesh.values = section->values;
  const bool in_space = mesh.dimension == 3;
  if (auto s = in_space ? AddSimplices<3>(*simplices, *section, mesh.tetrahedra, mesh)
                        : AddSimplices<2>(*simplices, *section, mesh.triangles, mesh);
      !s.ok()) {
    return s;
  }
  // A .poly has the segments; TetGen's are in .edge, its faces in .face.
  absl::StatusOr<std::optional<TextReader>> poly =
      OpenIfThere(open, in_space ? "" : stem + ".poly");
  if (!poly.ok()) return poly.status();
  if (*poly) {
    if (auto s = AddPoly(**poly, *section, mesh); !s.ok()) return s;
  } else {
    absl::StatusOr<std::optional<TextReader>> edges = OpenIfThere(open, stem + ".edge");
    if (!edges.ok()) return edges.status();
    if (*edges) {
      if (auto s = AddRows<2>(**edges, "edge", *section, false, mesh.segments); !s.ok()) return s;
      if (auto s = ExpectEnd(**edges); !s.ok()) return s;
      mesh.segment_file = (*edges)->name();
    }
  }
  if (in_space) {
    absl::StatusOr<std::optional<TextReader>> faces = OpenIfThere(open, stem + ".face");
    if (!faces.ok()) return faces.status();
    if (*faces) {
      if (auto s = AddRows<3>(**faces, "face", *section, false, mesh.triangles); !s.ok()) return s;
      if (auto s = ExpectEnd(**faces); !s.ok()) return s;
      mesh.triangle_file = (*faces)->name();
    }
  }
  absl::StatusOr<std::optional<TextReader>> limits =
      OpenIfThere(open, stem + (in_space ? ".vol" : ".area"));
  if (!limits.ok()) return limits.status();
  if (*limits) {
    const std::size_t count = in_space ? mesh.tetrahedra.size() : mesh.triangles.size();
    if (auto s = ReadLimits(**limits, count, mesh); !s.ok()) return s;
  }
  AddMarkersOfVertices(*section, mesh);
  return mesh;
}

absl::StatusOr<ElementMesh> ReadMshFile(const std::string& path) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  return reader.ok() ? ParseMsh(*std::move(reader)) : reader.status();
}

absl::StatusOr<ElementMesh> ReadMeditFile(const std::string& path) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  return reader.ok() ? ParseMedit(*std::move(reader)) : reader.status();
}

absl::StatusOr<ElementMesh> ReadVtuFile(const std::string& path) {
  const absl::StatusOr<std::string> text = ReadWholeFile(path);
  return text.ok() ? ParseVtu(path, *text) : text.status();
}

}  // namespace dynmesh::io
