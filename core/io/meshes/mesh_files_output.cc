#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/io/common/extension.h"
#include "core/io/common/file_writer.h"
#include "core/io/common/parallel.h"
#include "core/io/common/text_block.h"
#include "core/io/meshes/mesh_companions.h"
#include "core/io/meshes/mesh_files.h"
#include "core/io/meshes/mesh_notes.h"
#include "core/io/meshes/region_labels.h"

namespace dynmesh::io {
namespace {

constexpr std::size_t kNumbersPerNote = 16;

// The vertices that refinement put on the sides or faces of the box.
void WriteBoxNotes(const IndexedMesh& mesh, int containing_dimension, std::uint64_t base,
                   FileWriter& out) {
  std::vector<std::size_t> listed;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const IndexedMesh::Vertex& v = mesh.vertices[i];
    if (v.owner == kBoxFeature && v.containing_dimension == containing_dimension) {
      listed.push_back(i + base);
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

void WriteNodes(const IndexedMesh& mesh, const MeshFileOptions& options, FileWriter& out) {
  const std::size_t attributes = mesh.labels.attributes;
  out << mesh.vertices.size() << ' ' << mesh.dimension << ' ' << attributes << " 1\n";
  WriteRows(mesh.vertices.size(), options.threads, out, [&](std::size_t i, TextBlock& text) {
    const IndexedMesh::Vertex& v = mesh.vertices[i];
    text << i + options.base() << ' ' << v.x << ' ' << v.y << ' ';
    if (mesh.dimension == 3) text << v.z << ' ';
    for (std::size_t k = 0; k < attributes; ++k) {
      text << mesh.labels.vertex_values[i * attributes + k] << ' ';
    }
    WriteRowMarker(mesh, mesh.labels.vertex_markers, i, VertexMarker(v, mesh.labels.steiner_ids),
                   text);
    text << '\n';
  });
  if (mesh.labels.replace_ids) {
    out << "# dynmesh " << kMarkersNote << '\n';
  } else {
    for (int d = 1; d < mesh.dimension; ++d) WriteBoxNotes(mesh, d, options.base(), out);
  }
  if (mesh.labels.features != nullptr) {
    for (const auto& [id, name] : mesh.labels.features->names) {
      out << "# dynmesh name " << id << ' ' << OneLine(name) << '\n';
    }
  }
  if (options.is_triangulation) out << "# dynmesh " << kTriangulationNote << '\n';
  if (options.rho > 0 && !options.is_triangulation)
    out << "# dynmesh " << kRhoNote << options.rho << '\n';
  if (options.min_dihedral > 0) {
    out << "# dynmesh " << kDihedralNote << options.min_dihedral << '\n';
  }
  if (options.is_part) out << "# dynmesh " << kPartNote << '\n';
  if (!mesh.labels.replace_ids && mesh.order() == 1) {
    const MeshHash hash = options.hash ? *options.hash : ToMesh(mesh).hash;
    out << "# dynmesh " << kHashNote << hash.ToHex() << '\n';
  }
}

// Triangle: opposite to corners 0, 1, 2. TetGen's order of edges.
constexpr std::pair<std::size_t, std::size_t> kEdgesOf3[] = {{1, 2}, {2, 0}, {0, 1}};
constexpr std::pair<std::size_t, std::size_t> kEdgesOf4[] = {{2, 3}, {0, 3}, {0, 1},
                                                             {1, 2}, {1, 3}, {0, 2}};

template <std::size_t N>
void WriteMidpoints(const IndexedMesh& mesh, const std::array<std::uint32_t, N>& corners,
                    std::uint64_t base, TextBlock& out) {
  const auto write = [&](const auto& edges) {
    for (const auto& [j, k] : edges) out << ' ' << mesh.MidpointOf(corners[j], corners[k]) + base;
  };
  if constexpr (N == 3) {
    write(kEdgesOf3);
  } else {
    write(kEdgesOf4);
  }
}

// The rows of simplices, each with an end that more(i, text) writes.
template <int D, class More>
void WriteSimplexRows(const IndexedMesh& mesh, const MeshFileOptions& options, FileWriter& out,
                      const More& more) {
  const auto& simplices = SimplicesOf<D>(mesh);
  const std::uint64_t base = options.base();
  WriteRows(simplices.size(), options.threads, out, [&](std::size_t i, TextBlock& text) {
    text << i + base;
    for (const std::uint32_t v : simplices[i]) text << ' ' << v + base;
    if (mesh.order() == 2) WriteMidpoints(mesh, simplices[i], base, text);
    more(i, text);
    text << '\n';
  });
}

void WriteSimplices(const IndexedMesh& mesh, const MeshFileOptions& options, FileWriter& out) {
  const std::vector<double>& values = mesh.labels.simplex_values;
  const bool has_values = mesh.labels.replace_ids && !values.empty();
  const bool has_regions = !mesh.labels.replace_ids && mesh.regions.count() != 0;
  const std::vector<RegionLabel> labels = RegionLabelsOf(mesh);
  const bool has_markers =
      mesh.labels.replace_ids && !has_values &&
      std::ranges::any_of(labels, [](const RegionLabel& label) { return label.marker != 0; });
  const int nodes = (mesh.dimension + 1) * (mesh.order() == 1 ? 2 : mesh.dimension + 2) / 2;
  out << mesh.simplex_count() << ' ' << nodes << ' '
      << (has_regions || has_values || has_markers ? 1 : 0) << '\n';
  const auto more = [&](std::size_t i, TextBlock& text) {
    if (has_regions) text << ' ' << mesh.regions.Of(i);
    if (has_values) text << ' ' << values[i];
    if (has_markers) text << ' ' << labels[mesh.regions.Of(i)].marker;
  };
  mesh.dimension == 2 ? WriteSimplexRows<2>(mesh, options, out, more)
                      : WriteSimplexRows<3>(mesh, options, out, more);
  if (!has_regions) return;
  for (std::size_t k = 0; k < mesh.regions.count(); ++k) {
    out << "# dynmesh region " << k + 1 << ' ' << FormatPolygons(mesh.regions.polygons[k]) << '\n';
  }
}

void WriteFaces(const IndexedMesh& mesh, const MeshFileOptions& options, FileWriter& out) {
  const std::uint64_t base = options.base();
  out << mesh.faces.size() << " 1\n";
  WriteRows(mesh.faces.size(), options.threads, out, [&](std::size_t i, TextBlock& text) {
    text << i + base;
    for (const std::uint32_t v : mesh.faces[i].corners) text << ' ' << v + base;
    text << ' ';
    WriteRowMarker(mesh, mesh.labels.face_markers, i, mesh.faces[i].owner, text);
    text << '\n';
  });
}

void WriteEdges(const IndexedMesh& mesh, const MeshFileOptions& options, FileWriter& out) {
  const std::uint64_t base = options.base();
  out << mesh.edges.size() << " 1\n";
  WriteRows(mesh.edges.size(), options.threads, out, [&](std::size_t i, TextBlock& text) {
    const IndexedMesh::Edge& e = mesh.edges[i];
    text << i + base << ' ' << e.a + base << ' ' << e.b + base << ' ';
    WriteRowMarker(mesh, mesh.labels.edge_markers, i, e.owner, text);
    text << '\n';
  });
}

}  // namespace

std::string StemOfMeshFiles(const std::string& path) {
  const std::filesystem::path p(path);
  const std::string extension = ExtensionOf(path);
  for (const char* known : {".node", ".ele", ".edge", ".face", ".neigh", ".poly", ".smesh"}) {
    if (extension == known) return (p.parent_path() / p.stem()).string();
  }
  return path;
}

absl::Status WriteMeshFiles(const IndexedMesh& mesh, const std::string& path,
                            const MeshFileOptions& options) {
  const std::string stem = StemOfMeshFiles(path);
  const std::string extension = ExtensionOf(path);
  std::deque<FileWriter> files;
  const bool has_constraints = extension == ".poly" || extension == ".smesh";
  WriteNodes(mesh, options, files.emplace_back(stem + ".node"));
  // Beside a surface TetGen takes all rows of an .edge for segments.
  if (mesh.dimension == 2 || !has_constraints) {
    WriteSimplices(mesh, options, files.emplace_back(stem + ".ele"));
    WriteEdges(mesh, options, files.emplace_back(stem + ".edge"));
    if (mesh.dimension == 3) WriteFaces(mesh, options, files.emplace_back(stem + ".face"));
  }
  if (has_constraints) {
    WriteConstraints(mesh, options, extension, files.emplace_back(stem + extension));
  }
  if (options.neighbours || extension == ".neigh") {
    WriteNeighbours(mesh, options.base(), files.emplace_back(stem + ".neigh"));
  }
  if (options.voronoi) {
    FileWriter& nodes = files.emplace_back(stem + ".v.node");
    WriteVoronoi(mesh, options.base(), nodes, files.emplace_back(stem + ".v.edge"));
  }
  for (FileWriter& file : files) {
    if (auto status = file.Finish(); !status.ok()) return status;
  }
  for (FileWriter& file : files) {
    if (auto status = file.Close(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace dynmesh::io
