#include "core/io/meshes/mesh_files.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "core/io/common/extension.h"
#include "core/io/common/file_writer.h"
#include "core/io/common/text_reader.h"
#include "core/io/common/triangle_sections.h"

namespace dynmesh::io {

using text::Concat;
using text::Split;
using text::View;
namespace {

constexpr std::string_view kHashNote = "hash ";
// The notes for vertices of the box, by containing dimension.
constexpr std::string_view kBoxNotes[] = {"", "box-side-vertices ", "box-face-vertices "};
constexpr std::string_view kRegionNote = "region ";
constexpr std::string_view kNameNote = "name ";
constexpr std::string_view kMarkersNote = "markers input";
constexpr std::size_t kNumbersPerNote = 16;

std::string Stem(const std::string& path) {
  const std::filesystem::path p(path);
  const std::string extension = ExtensionOf(path);
  if (extension != ".node" && extension != ".ele" && extension != ".edge" && extension != ".face") {
    return path;
  }
  return (p.parent_path() / p.stem()).string();
}

// The box is written as -1, which is its id in two's complement.
void WriteMarker(FeatureId owner, FileWriter& out) {
  if (owner == kBoxFeature) {
    out << -1;
  } else {
    out << owner;
  }
}

// The vertices that refinement put on the sides or faces of the box.
void WriteBoxNotes(const IndexedMesh& mesh, int containing_dimension, FileWriter& out) {
  std::vector<std::size_t> listed;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const IndexedMesh::Vertex& v = mesh.vertices[i];
    if (v.owner == kBoxFeature && v.containing_dimension == containing_dimension) {
      listed.push_back(i + 1);
    }
  }
  for (std::size_t i = 0; i < listed.size(); i += kNumbersPerNote) {
    const std::string_view note = kBoxNotes[containing_dimension];
    out << "# dynmesh " << note.substr(0, note.size() - 1);
    for (std::size_t k = i; k < std::min(i + kNumbersPerNote, listed.size()); ++k) {
      out << ' ' << listed[k];
    }
    out << '\n';
  }
}

// The marker of row i, from the labels if they have it in place of ids.
void WriteRowMarker(const IndexedMesh& mesh, const std::vector<std::int64_t>& labels, std::size_t i,
                    FeatureId owner, FileWriter& out) {
  if (mesh.labels.replace_ids) {
    out << labels[i];
  } else {
    WriteMarker(owner, out);
  }
}

// A name as the rest of a comment's line.
std::string OneLine(std::string name) {
  for (char& c : name) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return name;
}

FeatureId VertexMarker(const IndexedMesh::Vertex& v, bool steiner_ids) {
  const bool is_marked = steiner_ids || v.containing_dimension == 0 || v.owner == kBoxFeature;
  return is_marked ? v.owner : kNoFeature;
}

void WriteNodes(const IndexedMesh& mesh, FileWriter& out) {
  const std::size_t attributes = mesh.labels.attributes;
  out << mesh.vertices.size() << ' ' << mesh.dimension << ' ' << attributes << " 1\n";
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const IndexedMesh::Vertex& v = mesh.vertices[i];
    out << i + 1 << ' ' << v.x << ' ' << v.y << ' ';
    if (mesh.dimension == 3) out << v.z << ' ';
    for (std::size_t k = 0; k < attributes; ++k) {
      out << mesh.labels.vertex_values[i * attributes + k] << ' ';
    }
    WriteRowMarker(mesh, mesh.labels.vertex_markers, i, VertexMarker(v, mesh.labels.steiner_ids),
                   out);
    out << '\n';
  }
  if (mesh.labels.replace_ids) {
    out << "# dynmesh " << kMarkersNote << '\n';
  } else {
    for (int d = 1; d < mesh.dimension; ++d) WriteBoxNotes(mesh, d, out);
  }
  if (mesh.labels.features != nullptr) {
    for (const auto& [id, name] : mesh.labels.features->names) {
      out << "# dynmesh name " << id << ' ' << OneLine(name) << '\n';
    }
  }
  if (!mesh.labels.replace_ids) out << "# dynmesh hash " << ToMesh(mesh).hash.ToHex() << '\n';
}

void WriteSimplices(const IndexedMesh& mesh, FileWriter& out) {
  const std::vector<double>& values = mesh.labels.simplex_values;
  const bool has_values = mesh.labels.replace_ids && !values.empty();
  const bool has_regions = !mesh.labels.replace_ids && mesh.regions.count() != 0;
  out << mesh.simplex_count() << ' ' << mesh.dimension + 1 << ' '
      << (has_regions || has_values ? 1 : 0) << '\n';
  std::size_t i = 0;
  ForEachSimplex(mesh, [&](const auto& corners) {
    out << i + 1;
    for (const std::uint32_t v : corners) out << ' ' << std::uint64_t{v} + 1;
    if (has_regions) out << ' ' << mesh.regions.Of(i);
    if (has_values) out << ' ' << values[i];
    out << '\n';
    ++i;
  });
  if (!has_regions) return;
  for (std::size_t k = 0; k < mesh.regions.count(); ++k) {
    out << "# dynmesh region " << k + 1 << ' ' << FormatPolygons(mesh.regions.polygons[k]) << '\n';
  }
}

void WriteFaces(const IndexedMesh& mesh, FileWriter& out) {
  out << mesh.faces.size() << " 1\n";
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    out << i + 1;
    for (const std::uint32_t v : mesh.faces[i].corners) out << ' ' << std::uint64_t{v} + 1;
    out << ' ';
    WriteRowMarker(mesh, mesh.labels.face_markers, i, mesh.faces[i].owner, out);
    out << '\n';
  }
}

void WriteEdges(const IndexedMesh& mesh, FileWriter& out) {
  out << mesh.edges.size() << " 1\n";
  for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
    const IndexedMesh::Edge& e = mesh.edges[i];
    out << i + 1 << ' ' << e.a + 1 << ' ' << e.b + 1 << ' ';
    WriteRowMarker(mesh, mesh.labels.edge_markers, i, e.owner, out);
    out << '\n';
  }
}

// Assigns `owner` to a corner of its constraint, of dimension `containing`, unless the vertex lies
// on input of lower dimension. A marker that is the constraint's is no point's.
void OwnCorner(IndexedMesh::Vertex& v, int containing, FeatureId owner) {
  if (v.containing_dimension == 0 && v.owner == owner && owner != kBoxFeature) {
    v.containing_dimension = containing;
    return;
  }
  if (v.containing_dimension < containing) return;
  // The least id, whatever the order of rows; a valid mesh has no choice.
  v.owner = v.containing_dimension == containing ? std::min(v.owner, owner) : owner;
  v.containing_dimension = containing;
}

// Infers owner and containing dimension from the markers. Markers of input points and of the box
// suffice. Of the others, ends of a subsegment lie on its segment, corners of a
// subfacet on its polygon.
void InferOwners(const NodeSection& nodes, IndexedMesh& mesh) {
  for (std::size_t i = 0; i < nodes.positions.size(); ++i) {
    const FeatureId marker = nodes.markers[i];
    const auto& [x, y, z] = nodes.positions[i];
    mesh.vertices.push_back({x, y, marker == kNoFeature ? mesh.dimension : 0, marker, z});
  }
  for (const IndexedMesh::Edge& e : mesh.edges) {
    if (e.owner == kNoFeature) continue;
    for (const std::uint32_t end : {e.a, e.b}) OwnCorner(mesh.vertices[end], 1, e.owner);
  }
  for (const IndexedMesh::Face& f : mesh.faces) {
    if (f.owner == kNoFeature) continue;
    for (const std::uint32_t v : f.corners) OwnCorner(mesh.vertices[v], 2, f.owner);
  }
}

// Of a file with the markers of the input: no row has an owner.
void ForgetMarkers(const NodeSection& nodes, IndexedMesh& mesh) {
  for (const auto& [x, y, z] : nodes.positions) {
    mesh.vertices.push_back({x, y, mesh.dimension, kNoFeature, z});
  }
  for (IndexedMesh::Edge& e : mesh.edges) e.owner = kNoFeature;
  for (IndexedMesh::Face& f : mesh.faces) f.owner = kNoFeature;
}

// "12 40 ...": the vertices of the box with this containing dimension.
absl::Status ReadBoxNote(const TextReader& reader, std::string_view name, std::string_view text,
                         int containing_dimension, IndexedMesh& mesh) {
  for (const std::string_view number : Split(text, ' ')) {
    std::uint64_t vertex = 0;
    if (!ParseUint64(number, &vertex) || vertex < 1 || vertex > mesh.vertices.size()) {
      return reader.Error(Concat(name, "names no vertex: ", number));
    }
    mesh.vertices[vertex - 1].containing_dimension = containing_dimension;
  }
  return absl::OkStatus();
}

// "ID TEXT": the name of a feature.
absl::Status ReadNameNote(const TextReader& reader, std::string_view text, MeshFiles& files) {
  const std::size_t blank = text.find(' ');
  std::uint64_t id = 0;
  if (blank == std::string_view::npos || !ParseUint64(text.substr(0, blank), &id) || id == 0) {
    return reader.Error(
        Concat("name: expected a feature's id and its name, found ", text::Quoted(text)));
  }
  files.names[id] = text.substr(blank + 1);
  return absl::OkStatus();
}

absl::Status ReadNotes(const TextReader& reader, MeshFiles& files) {
  for (const std::string_view note : reader.notes()) {
    if (note.starts_with(kNameNote)) {
      if (auto s = ReadNameNote(reader, note.substr(kNameNote.size()), files); !s.ok()) return s;
    }
    if (note.starts_with(kHashNote)) {
      absl::StatusOr<MeshHash> hash = MeshHash::FromHex(note.substr(kHashNote.size()));
      if (!hash.ok()) return reader.Error(View(hash.status().message()));
      files.recorded_hash = *hash;
    }
    for (int d = 1; d < files.mesh.dimension; ++d) {
      if (!note.starts_with(kBoxNotes[d])) continue;
      const std::string_view rest = note.substr(kBoxNotes[d].size());
      if (auto s = ReadBoxNote(reader, kBoxNotes[d], rest, d, files.mesh); !s.ok()) return s;
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
        Concat("region ", regions.count() + 1, " expected, found ", text::Quoted(parts[0])));
  }
  std::vector<FeatureId>& polygons = regions.polygons.emplace_back();
  for (std::size_t i = 1; i < parts.size(); ++i) {
    std::uint64_t id = 0;
    if (!ParseUint64(parts[i], &id) || id == kNoFeature || id == kBoxFeature) {
      return reader.Error(Concat("region ", number, " names no polygon: ", text::Quoted(parts[i])));
    }
    if (!polygons.empty() && id <= polygons.back()) {
      return reader.Error(Concat("the polygons of region ", number, " are not in ascending order"));
    }
    polygons.push_back(id);
  }
  if (polygons.empty()) return reader.Error(Concat("region ", number, " has no polygon"));
  return absl::OkStatus();
}

template <int D>
absl::Status ReadRegions(const TextReader& reader, const SimplexSection<D>& rows,
                         RegionNumbers& regions) {
  for (const std::string_view note : reader.notes()) {
    if (!note.starts_with(kRegionNote)) continue;
    if (auto s = ReadRegionNote(reader, note.substr(kRegionNote.size()), regions); !s.ok()) {
      return s;
    }
  }
  if (regions.count() == 0) return absl::OkStatus();
  if (rows.attributes.empty() && !rows.corners.empty()) {
    return reader.Error(Concat("regions are named, but ", D == 2 ? "triangles" : "tetrahedra",
                               " have no attribute to say which"));
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
  const absl::StatusOr<PairSection> edges = ReadTupleSection<2>(reader, "edge", nodes);
  if (!edges.ok()) return edges.status();
  files.mesh.edges.reserve(edges->ends.size());
  for (std::size_t i = 0; i < edges->ends.size(); ++i) {
    const auto [a, b] = std::minmax(edges->ends[i][0], edges->ends[i][1]);
    files.mesh.edges.push_back({a, b, edges->markers[i]});
  }
  return ExpectEnd(reader);
}

absl::Status ParseFaces(TextReader& reader, const NodeSection& nodes, MeshFiles& files) {
  const absl::StatusOr<TupleSection<3>> faces = ReadTupleSection<3>(reader, "face", nodes);
  if (!faces.ok()) return faces.status();
  files.mesh.faces.reserve(faces->ends.size());
  for (std::size_t i = 0; i < faces->ends.size(); ++i) {
    std::array<std::uint32_t, 3> corners = faces->ends[i];
    std::sort(corners.begin(), corners.end());
    files.mesh.faces.push_back({corners, faces->markers[i]});
  }
  return ExpectEnd(reader);
}

template <int D>
absl::Status ParseSimplices(TextReader& reader, const NodeSection& nodes, MeshFiles& files) {
  absl::StatusOr<SimplexSection<D>> rows = ReadSimplexSection<D>(reader, nodes);
  if (!rows.ok()) return rows.status();
  if (auto status = ExpectEnd(reader); !status.ok()) return status;
  if (auto s = ReadRegions(reader, *rows, files.mesh.regions); !s.ok()) return s;
  SimplicesOf<D>(files.mesh) = std::move(rows->corners);
  return absl::OkStatus();
}

// Opens the file beside the others; none if absent.
absl::StatusOr<std::optional<TextReader>> OpenIfThere(const std::string& path) {
  absl::StatusOr<TextReader> file = TextReader::Open(path);
  if (file.ok()) return std::optional<TextReader>(*std::move(file));
  if (absl::IsNotFound(file.status())) return std::optional<TextReader>();
  return file.status();
}

}  // namespace

absl::Status WriteMeshFiles(const IndexedMesh& mesh, const std::string& path) {
  const std::string stem = Stem(path);
  FileWriter nodes(stem + ".node");
  FileWriter simplices(stem + ".ele");
  FileWriter edges(stem + ".edge");
  std::optional<FileWriter> faces;
  std::vector<FileWriter*> files = {&nodes, &simplices, &edges};
  WriteNodes(mesh, nodes);
  WriteSimplices(mesh, simplices);
  WriteEdges(mesh, edges);
  if (mesh.dimension == 3) {
    WriteFaces(mesh, faces.emplace(stem + ".face"));
    files.push_back(&*faces);
  }
  for (FileWriter* file : files) {
    if (auto status = file->Finish(); !status.ok()) return status;
  }
  for (FileWriter* file : files) {
    if (auto status = file->Close(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<MeshFiles> ParseMeshFiles(TextReader nodes, TextReader simplices,
                                         std::optional<TextReader> edges,
                                         std::optional<TextReader> faces) {
  const absl::StatusOr<NodeSection> section = ReadNodeSection(nodes, kStatedDimension);
  if (!section.ok()) return section.status();
  if (auto status = ExpectEnd(nodes); !status.ok()) return status;

  MeshFiles files;
  files.mesh.dimension = section->dimension;
  const bool in_space = section->dimension == 3;
  files.has_input_markers = std::ranges::count(nodes.notes(), kMarkersNote) != 0;
  files.has_edges = edges.has_value();
  files.has_faces = in_space && faces.has_value();
  if (edges) {
    if (auto status = ParseEdges(*edges, *section, files); !status.ok()) return status;
  }
  if (files.has_faces) {
    if (auto status = ParseFaces(*faces, *section, files); !status.ok()) return status;
  }
  if (files.has_input_markers) {
    ForgetMarkers(*section, files.mesh);
  } else {
    InferOwners(*section, files.mesh);
  }
  if (auto status = ReadNotes(nodes, files); !status.ok()) return status;
  const absl::Status status = in_space ? ParseSimplices<3>(simplices, *section, files)
                                       : ParseSimplices<2>(simplices, *section, files);
  if (!status.ok()) return status;
  return files;
}

absl::StatusOr<MeshFiles> ReadMeshFiles(const std::string& path) {
  const std::string stem = Stem(path);
  absl::StatusOr<TextReader> nodes = TextReader::Open(stem + ".node");
  if (!nodes.ok()) return nodes.status();
  absl::StatusOr<std::optional<TextReader>> edges = OpenIfThere(stem + ".edge");
  if (!edges.ok()) return edges.status();
  absl::StatusOr<std::optional<TextReader>> faces = OpenIfThere(stem + ".face");
  if (!faces.ok()) return faces.status();
  absl::StatusOr<TextReader> simplices = TextReader::Open(stem + ".ele");
  if (!simplices.ok()) return simplices.status();
  return ParseMeshFiles(*std::move(nodes), *std::move(simplices), *std::move(edges),
                        *std::move(faces));
}

}  // namespace dynmesh::io
