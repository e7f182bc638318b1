#include "core/io/mesh_files.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/data/text.h"
#include "core/io/file_writer.h"
#include "core/io/text_reader.h"
#include "core/io/triangle_sections.h"

namespace dynmesh::io {

using data::Concat;
using data::Split;
using data::View;
namespace {

constexpr std::string_view kHashNote = "hash ";
constexpr std::string_view kSidesNote = "box-side-vertices ";
constexpr std::string_view kRegionNote = "region ";
constexpr std::size_t kNumbersPerNote = 16;

std::string Stem(const std::string& path) {
  const std::filesystem::path p(path);
  const std::string extension = p.extension().string();
  if (extension != ".node" && extension != ".ele" && extension != ".edge") return path;
  return (p.parent_path() / p.stem()).string();
}

// The box prints as -1, which is its id in two's complement.
void WriteMarker(FeatureId owner, FileWriter& out) {
  if (owner == kBoxFeature) {
    out << -1;
  } else {
    out << owner;
  }
}

FeatureId VertexMarker(const IndexedMesh::Vertex& v) {
  return v.containing_dimension == 0 || v.owner == kBoxFeature ? v.owner : kNoFeature;
}

bool OnBoxSide(const IndexedMesh::Vertex& v) {
  return v.owner == kBoxFeature && v.containing_dimension != 0;
}

void WriteNodes(const IndexedMesh& mesh, FileWriter& out) {
  out << mesh.vertices.size() << " 2 0 1\n";
  std::vector<std::size_t> sides;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const IndexedMesh::Vertex& v = mesh.vertices[i];
    out << i + 1 << ' ' << v.x << ' ' << v.y << ' ';
    WriteMarker(VertexMarker(v), out);
    out << '\n';
    if (OnBoxSide(v)) sides.push_back(i + 1);
  }
  for (std::size_t i = 0; i < sides.size(); i += kNumbersPerNote) {
    out << "# dynmesh box-side-vertices";
    for (std::size_t k = i; k < std::min(i + kNumbersPerNote, sides.size()); ++k) {
      out << ' ' << sides[k];
    }
    out << '\n';
  }
  out << "# dynmesh hash " << ToMesh(mesh).hash.ToHex() << '\n';
}

void WriteTriangles(const IndexedMesh& mesh, FileWriter& out) {
  const bool has_regions = mesh.regions.count() != 0;
  out << mesh.triangles.size() << " 3 " << (has_regions ? 1 : 0) << '\n';
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const IndexedMesh::Triangle& t = mesh.triangles[i];
    out << i + 1 << ' ' << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1;
    if (has_regions) out << ' ' << mesh.regions.Of(i);
    out << '\n';
  }
  for (std::size_t k = 0; k < mesh.regions.count(); ++k) {
    out << "# dynmesh region " << k + 1 << ' ' << FormatPolygons(mesh.regions.polygons[k]) << '\n';
  }
}

void WriteEdges(const IndexedMesh& mesh, FileWriter& out) {
  out << mesh.edges.size() << " 1\n";
  for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
    const IndexedMesh::Edge& e = mesh.edges[i];
    out << i + 1 << ' ' << e.a + 1 << ' ' << e.b + 1 << ' ';
    WriteMarker(e.owner, out);
    out << '\n';
  }
}

// Owner and containing dimension from the markers: input points and the box say so;
// of the rest, those at a subsegment's end lie on that segment.
void InferOwners(const NodeSection& nodes, IndexedMesh& mesh) {
  for (std::size_t i = 0; i < nodes.positions.size(); ++i) {
    const FeatureId marker = nodes.markers[i];
    mesh.vertices.push_back(
        {nodes.positions[i][0], nodes.positions[i][1], marker == kNoFeature ? 2 : 0, marker});
  }
  for (const IndexedMesh::Edge& e : mesh.edges) {
    if (e.owner == kNoFeature) continue;
    for (const std::uint32_t end : {e.a, e.b}) {
      IndexedMesh::Vertex& v = mesh.vertices[end];
      if (v.containing_dimension == 0) continue;
      // The least id, whatever the order of edges; a valid mesh leaves no choice.
      v.owner = v.containing_dimension == 1 ? std::min(v.owner, e.owner) : e.owner;
      v.containing_dimension = 1;
    }
  }
}

absl::Status ReadNotes(const TextReader& reader, MeshFiles& files) {
  for (const std::string_view note : reader.notes()) {
    if (note.starts_with(kHashNote)) {
      absl::StatusOr<MeshHash> hash = MeshHash::FromHex(note.substr(kHashNote.size()));
      if (!hash.ok()) return reader.Error(View(hash.status().message()));
      files.recorded_hash = *hash;
    } else if (note.starts_with(kSidesNote)) {
      for (const std::string_view number : Split(note.substr(kSidesNote.size()), ' ')) {
        std::uint64_t vertex = 0;
        if (!ParseUint64(number, &vertex) || vertex < 1 || vertex > files.mesh.vertices.size()) {
          return reader.Error(Concat("box-side-vertices names no vertex: ", number));
        }
        files.mesh.vertices[vertex - 1].containing_dimension = 1;
      }
    }
  }
  return absl::OkStatus();
}

// "K P1 P2 ...": the polygons of region K.
absl::Status ReadRegionNote(const TextReader& reader, std::string_view text,
                            RegionNumbers& regions) {
  const std::vector<std::string_view> parts = Split(text, ' ');
  std::uint64_t number = 0;
  if (!ParseUint64(parts[0], &number) || number != regions.count() + 1) {
    return reader.Error(
        Concat("region ", regions.count() + 1, " expected, found ", data::Quoted(parts[0])));
  }
  std::vector<FeatureId>& polygons = regions.polygons.emplace_back();
  for (std::size_t i = 1; i < parts.size(); ++i) {
    std::uint64_t id = 0;
    if (!ParseUint64(parts[i], &id) || id == kNoFeature || id == kBoxFeature) {
      return reader.Error(Concat("region ", number, " names no polygon: ", data::Quoted(parts[i])));
    }
    if (!polygons.empty() && id <= polygons.back()) {
      return reader.Error(Concat("the polygons of region ", number, " are not in ascending order"));
    }
    polygons.push_back(id);
  }
  if (polygons.empty()) return reader.Error(Concat("region ", number, " has no polygon"));
  return absl::OkStatus();
}

absl::Status ReadRegions(const TextReader& reader, const TriangleSection& rows,
                         RegionNumbers& regions) {
  for (const std::string_view note : reader.notes()) {
    if (!note.starts_with(kRegionNote)) continue;
    if (auto s = ReadRegionNote(reader, note.substr(kRegionNote.size()), regions); !s.ok()) {
      return s;
    }
  }
  if (regions.count() == 0) return absl::OkStatus();
  if (rows.attributes.empty() && !rows.corners.empty()) {
    return reader.Error("regions are named, but triangles have no attribute to say which");
  }
  for (std::size_t i = 0; i < rows.attributes.size(); ++i) {
    const double number = rows.attributes[i];
    if (!(number >= 0 && number <= static_cast<double>(regions.count())) ||
        number != std::floor(number)) {
      return TextReader::ErrorAt(
          reader.name(), rows.lines[i],
          Concat("the attribute is no region: they run from 0 to ", regions.count()));
    }
    regions.numbers.push_back(static_cast<std::uint32_t>(number));
  }
  return absl::OkStatus();
}

absl::Status ParseEdges(TextReader& reader, const NodeSection& nodes, MeshFiles& files) {
  const absl::StatusOr<PairSection> edges = ReadPairSection(reader, "edge", nodes);
  if (!edges.ok()) return edges.status();
  files.mesh.edges.reserve(edges->ends.size());
  for (std::size_t i = 0; i < edges->ends.size(); ++i) {
    const auto [a, b] = std::minmax(edges->ends[i][0], edges->ends[i][1]);
    files.mesh.edges.push_back({a, b, edges->markers[i]});
  }
  return ExpectEnd(reader);
}

}  // namespace

absl::Status WriteMeshFiles(const IndexedMesh& mesh, const std::string& path) {
  const std::string stem = Stem(path);
  FileWriter nodes(stem + ".node");
  FileWriter triangles(stem + ".ele");
  FileWriter edges(stem + ".edge");
  WriteNodes(mesh, nodes);
  WriteTriangles(mesh, triangles);
  WriteEdges(mesh, edges);
  for (FileWriter* file : {&nodes, &triangles, &edges}) {
    if (auto status = file->Finish(); !status.ok()) return status;
  }
  for (FileWriter* file : {&nodes, &triangles, &edges}) {
    if (auto status = file->Close(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<MeshFiles> ParseMeshFiles(TextReader nodes, TextReader triangles,
                                         std::optional<TextReader> edges) {
  const absl::StatusOr<NodeSection> section = ReadNodeSection(nodes, 2);
  if (!section.ok()) return section.status();
  if (auto status = ExpectEnd(nodes); !status.ok()) return status;

  MeshFiles files;
  files.has_edges = edges.has_value();
  if (edges) {
    if (auto status = ParseEdges(*edges, *section, files); !status.ok()) return status;
  }
  InferOwners(*section, files.mesh);
  if (auto status = ReadNotes(nodes, files); !status.ok()) return status;

  absl::StatusOr<TriangleSection> rows = ReadTriangleSection(triangles, *section);
  if (!rows.ok()) return rows.status();
  if (auto status = ExpectEnd(triangles); !status.ok()) return status;
  if (auto s = ReadRegions(triangles, *rows, files.mesh.regions); !s.ok()) return s;
  files.mesh.triangles = std::move(rows->corners);
  return files;
}

absl::StatusOr<MeshFiles> ReadMeshFiles(const std::string& path) {
  const std::string stem = Stem(path);
  absl::StatusOr<TextReader> nodes = TextReader::Open(stem + ".node");
  if (!nodes.ok()) return nodes.status();
  absl::StatusOr<TextReader> edge_file = TextReader::Open(stem + ".edge");
  std::optional<TextReader> edges;
  if (edge_file.ok()) {
    edges = *std::move(edge_file);
  } else if (!absl::IsNotFound(edge_file.status())) {
    return edge_file.status();
  }
  absl::StatusOr<TextReader> triangles = TextReader::Open(stem + ".ele");
  if (!triangles.ok()) return triangles.status();
  return ParseMeshFiles(*std::move(nodes), *std::move(triangles), std::move(edges));
}

}  // namespace dynmesh::io
