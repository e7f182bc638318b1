#include "core/io/meshes/medit_writer.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/io/common/file_writer.h"
#include "core/io/meshes/references.h"

namespace dynmesh::io {

namespace {

// A section of rows with owners and their references. `corners` returns the corners of a row.
template <class Rows, class Corners>
void WriteOwned(const char* name, const Rows& rows, const References& references, Corners corners,
                FileWriter& out) {
  const auto is_owned = [](const auto& row) { return row.owner != kNoFeature; };
  out << '\n' << name << '\n' << std::count_if(rows.begin(), rows.end(), is_owned) << '\n';
  for (const auto& row : rows) {
    if (!is_owned(row)) continue;
    for (const std::uint32_t v : corners(row)) out << std::uint64_t{v} + 1 << ' ';
    out << references.Find(row.owner) << '\n';
  }
}

}  // namespace

absl::Status WriteMedit(const IndexedMesh& mesh, const std::string& path) {
  const absl::StatusOr<References> references = References::Of(mesh);
  if (!references.ok()) return references.status();
  const bool in_space = mesh.dimension == 3;
  FileWriter out(path);
  out << "MeshVersionFormatted 2\n\nDimension " << mesh.dimension << "\n\n";
  for (int r = 1; r <= references->box(); ++r) {
    out << "# reference " << r << ": " << references->Name(r) << '\n';
  }
  if (mesh.regions.count() != 0) {
    for (std::uint32_t k = 0; k <= mesh.regions.count(); ++k) {
      out << "# " << (in_space ? "tetrahedron" : "triangle") << " reference " << k + 1 << ": "
          << mesh.regions.Name(k) << '\n';
    }
  }
  out << "\nVertices\n" << mesh.vertices.size() << '\n';
  for (const IndexedMesh::Vertex& v : mesh.vertices) {
    out << v.x << ' ' << v.y << ' ';
    if (in_space) out << v.z << ' ';
    out << references->Find(v.owner) << '\n';
  }
  WriteOwned(
      "Edges", mesh.edges, *references,
      [](const auto& e) {
        return std::array{e.a, e.b};
      },
      out);
  if (in_space) {
    WriteOwned(
        "Triangles", mesh.faces, *references, [](const auto& f) { return f.corners; }, out);
  }
  out << (in_space ? "\nTetrahedra\n" : "\nTriangles\n") << mesh.simplex_count() << '\n';
  std::size_t i = 0;
  ForEachSimplex(mesh, [&](const auto& corners) {
    for (const std::uint32_t corner : corners) out << std::uint64_t{corner} + 1 << ' ';
    out << mesh.regions.Of(i++) + 1 << '\n';
  });
  out << "\nEnd\n";
  return out.Close();
}

}  // namespace dynmesh::io
