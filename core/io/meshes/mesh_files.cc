#include "core/io/meshes/mesh_files.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "core/io/common/text_reader.h"
#include "core/io/common/triangle_sections.h"
#include "core/io/meshes/mesh_notes.h"

namespace dynmesh::io {

using text::Concat;
using text::Split;
using text::View;
namespace {

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
                         int containing_dimension, std::uint64_t base, IndexedMesh& mesh) {
  for (const std::string_view number : Split(text, ' ')) {
    std::uint64_t vertex = 0;
    if (!ParseUint64(number, &vertex) || vertex - base >= mesh.vertices.size()) {
      return reader.Error(Concat(name, "names no vertex: ", number));
    }
    mesh.vertices[vertex - base].containing_dimension = containing_dimension;
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

// "rho 1.5" and the like: a number above 0.
absl::Status ReadBoundNote(const TextReader& reader, std::string_view note, std::string_view name,
                           std::optional<double>& bound) {
  if (!note.starts_with(name)) return absl::OkStatus();
  double value = 0;
  if (!ParseDouble(note.substr(name.size()), &value) || !(value > 0)) {
    return reader.Error(Concat(name, "is no number above 0: ", text::Quoted(note)));
  }
  bound = value;
  return absl::OkStatus();
}

absl::Status ReadNotes(const TextReader& reader, std::uint64_t base, MeshFiles& files) {
  for (const std::string_view note : reader.notes()) {
    if (note.starts_with(kNameNote)) {
      if (auto s = ReadNameNote(reader, note.substr(kNameNote.size()), files); !s.ok()) return s;
    }
    if (auto s = ReadBoundNote(reader, note, kRhoNote, files.rho); !s.ok()) return s;
    if (auto s = ReadBoundNote(reader, note, kDihedralNote, files.min_dihedral); !s.ok()) return s;
    files.is_part |= note == kPartNote;
    files.is_triangulation |= note == kTriangulationNote;
    if (note.starts_with(kHashNote)) {
      absl::StatusOr<MeshHash> hash = MeshHash::FromHex(note.substr(kHashNote.size()));
      if (!hash.ok()) return reader.Error(View(hash.status().message()));
      files.recorded_hash = *hash;
    }
    for (int d = 1; d < files.mesh.dimension; ++d) {
      if (!note.starts_with(kBoxNotes[d])) continue;
      const std::string_view rest = note.substr(kBoxNotes[d].size());
      if (auto s = ReadBoxNote(reader, kBoxNotes[d], rest, d, base, files.mesh); !s.ok()) return s;
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
  if (auto status = ReadNotes(nodes, section->base, files); !status.ok()) return status;
  const absl::Status status = in_space ? ParseSimplices<3>(simplices, *section, files)
                                       : ParseSimplices<2>(simplices, *section, files);
  if (!status.ok()) return status;
  return files;
}

absl::StatusOr<MeshFiles> ReadMeshFiles(const std::string& path) {
  const std::string stem = StemOfMeshFiles(path);
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
