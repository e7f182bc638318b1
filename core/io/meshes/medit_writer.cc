#include "core/io/meshes/medit_writer.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/io/common/file_writer.h"
#include "core/io/meshes/msh_groups.h"
#include "core/io/meshes/references.h"
#include "core/io/meshes/region_labels.h"
#include "core/io/meshes/tetrahedron_sides.h"

namespace dynmesh::io {

namespace {

constexpr double kMost = 2147483647;  // references have 32 bits

// A section of rows with owners or markers, and their references: those of owners unless the labels
// replace them by `markers`. `corners(i)` returns the corners of row i.
template <class Rows, class Corners>
void WriteOwned(const char* name, const Rows& rows, const References& references,
                const RowLabels& labels, const std::vector<std::int64_t>& markers, Corners corners,
                FileWriter& out) {
  const auto reference_of = [&](std::size_t i) -> std::int64_t {
    return labels.replace_ids ? markers[i] : references.Find(rows[i].owner);
  };
  const auto is_written = [&](std::size_t i) {
    return rows[i].owner != kNoFeature || reference_of(i) != 0;
  };
  std::size_t count = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) count += is_written(i) ? 1 : 0;
  out << '\n' << name << '\n' << count << '\n';
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!is_written(i)) continue;
    for (const std::uint32_t v : corners(i)) out << std::uint64_t{v} + 1 << ' ';
    out << reference_of(i) << '\n';
  }
}

using FaceCorners = std::array<std::uint32_t, 3>;

// The corners of each face, in the order that the header describes. O(n) expected.
std::vector<FaceCorners> OrientedFaces(const IndexedMesh& mesh) {
  std::vector<FaceCorners> faces;
  absl::flat_hash_map<FaceCorners, std::size_t> row_of;
  for (const IndexedMesh::Face& face : mesh.faces) {
    row_of.emplace(face.corners, faces.size());
    faces.push_back(face.corners);
  }
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> regions(faces.size(), kNone);
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    for (const auto& side : kTetrahedronSides) {
      FaceCorners outward;
      for (std::size_t k = 0; k < 3; ++k) outward[k] = mesh.tetrahedra[i][side[k]];
      std::rotate(outward.begin(), std::min_element(outward.begin(), outward.end()), outward.end());
      FaceCorners ascending = outward;
      if (ascending[1] > ascending[2]) std::swap(ascending[1], ascending[2]);
      const auto it = row_of.find(ascending);
      if (it == row_of.end() || mesh.regions.Of(i) >= regions[it->second]) continue;
      regions[it->second] = mesh.regions.Of(i);
      faces[it->second] = outward;
    }
  }
  return faces;
}

// Which reference is what, as comments.
void WriteReferences(const IndexedMesh& mesh, const References& references, FileWriter& out) {
  for (int r = 1; r <= references.box(); ++r) {
    out << "# reference " << r << ": " << references.Name(r);
    if (r != references.box()) {
      const std::string name =
          mesh.labels.NameOf(references.features()[static_cast<std::size_t>(r) - 1]);
      if (!name.empty()) out << ", " << name;
    }
    out << '\n';
  }
}

// The names of features by their markers.
void WriteMarkers(const IndexedMesh& mesh, const References& references, FileWriter& out) {
  out << "# references are markers of the input\n";
  std::set<std::pair<std::int64_t, std::string>> rows;
  for (const FeatureId id : references.features()) {
    const std::string name = mesh.labels.NameOf(id);
    if (!name.empty()) rows.emplace(mesh.labels.features->MarkerOf(id), name);
  }
  for (const auto& [marker, name] : rows) out << "# marker " << marker << ": " << name << '\n';
}

// The same of triangles, in 3D of tetrahedra.
void WriteRegionReferences(const IndexedMesh& mesh, const std::vector<std::int64_t>& references,
                           FileWriter& out) {
  if (mesh.regions.count() == 0) return;
  const std::vector<RegionLabel> labels = RegionLabelsOf(mesh);
  for (std::uint32_t k = 0; k <= mesh.regions.count(); ++k) {
    out << "# " << (mesh.dimension == 3 ? "tetrahedron" : "triangle") << " reference "
        << references[k] << ": " << mesh.regions.Name(k);
    if (!labels[k].name.empty()) out << ", " << labels[k].name;
    out << '\n';
  }
}

// The references of regions, by number: as the groups of a `.msh`.
std::vector<std::int64_t> RegionReferences(const IndexedMesh& mesh, const References& references) {
  std::vector<std::int64_t> result;
  const MshGroups groups(mesh, references);
  for (std::uint32_t k = 0; k <= mesh.regions.count(); ++k) {
    result.push_back(mesh.labels.replace_ids ? groups.OfRegion(k) : std::int64_t{k} + 1);
  }
  return result;
}

}  // namespace

absl::Status WriteMedit(const IndexedMesh& mesh, const std::string& path) {
  const absl::StatusOr<References> references = References::Of(mesh);
  if (!references.ok()) return references.status();
  const bool in_space = mesh.dimension == 3;
  FileWriter out(path);
  out << "MeshVersionFormatted 2\n\nDimension " << mesh.dimension << "\n\n";
  const RowLabels& labels = mesh.labels;
  if (labels.replace_ids) {
    WriteMarkers(mesh, *references, out);
  } else {
    WriteReferences(mesh, *references, out);
  }
  const bool has_values = labels.replace_ids && !labels.simplex_values.empty();
  const std::vector<std::int64_t> of_regions = RegionReferences(mesh, *references);
  if (!has_values) WriteRegionReferences(mesh, of_regions, out);
  out << "\nVertices\n" << mesh.vertices.size() << '\n';
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const IndexedMesh::Vertex& v = mesh.vertices[i];
    out << v.x << ' ' << v.y << ' ';
    if (in_space) out << v.z << ' ';
    if (labels.replace_ids) {
      out << labels.vertex_markers[i] << '\n';
    } else {
      out << references->Find(v.owner) << '\n';
    }
  }
  WriteOwned(
      "Edges", mesh.edges, *references, labels, labels.edge_markers,
      [&](std::size_t i) {
        return std::array{mesh.edges[i].a, mesh.edges[i].b};
      },
      out);
  if (in_space) {
    const std::vector<FaceCorners> faces = OrientedFaces(mesh);
    WriteOwned(
        "Triangles", mesh.faces, *references, labels, labels.face_markers,
        [&](std::size_t i) { return faces[i]; }, out);
  }
  out << (in_space ? "\nTetrahedra\n" : "\nTriangles\n") << mesh.simplex_count() << '\n';
  std::size_t i = 0;
  ForEachSimplex(mesh, [&](const auto& corners) {
    for (const std::uint32_t corner : corners) out << std::uint64_t{corner} + 1 << ' ';
    if (has_values) {
      out << static_cast<std::int64_t>(std::clamp(labels.simplex_values[i], -kMost, kMost)) << '\n';
    } else {
      out << of_regions[mesh.regions.Of(i)] << '\n';
    }
    ++i;
  });
  out << "\nEnd\n";
  return out.Close();
}

}  // namespace dynmesh::io
