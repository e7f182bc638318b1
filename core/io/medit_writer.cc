#include "core/io/medit_writer.h"

#include <algorithm>
#include <cstdint>

#include "core/io/file_writer.h"
#include "core/io/references.h"

namespace dynmesh::io {

absl::Status WriteMedit(const IndexedMesh& mesh, const std::string& path) {
  const absl::StatusOr<References> references = References::Of(mesh);
  if (!references.ok()) return references.status();
  FileWriter out(path);
  out << "MeshVersionFormatted 2\n\nDimension 2\n\n";
  for (int r = 1; r <= references->box(); ++r) {
    out << "# reference " << r << ": " << references->Name(r) << '\n';
  }
  if (mesh.regions.count() != 0) {
    for (std::uint32_t k = 0; k <= mesh.regions.count(); ++k) {
      out << "# triangle reference " << k + 1 << ": " << mesh.regions.Name(k) << '\n';
    }
  }
  out << "\nVertices\n" << mesh.vertices.size() << '\n';
  for (const IndexedMesh::Vertex& v : mesh.vertices) {
    out << v.x << ' ' << v.y << ' ' << references->Find(v.owner) << '\n';
  }
  const auto is_owned = [](const IndexedMesh::Edge& e) { return e.owner != kNoFeature; };
  out << "\nEdges\n" << std::count_if(mesh.edges.begin(), mesh.edges.end(), is_owned) << '\n';
  for (const IndexedMesh::Edge& e : mesh.edges) {
    if (!is_owned(e)) continue;
    out << std::uint64_t{e.a} + 1 << ' ' << std::uint64_t{e.b} + 1 << ' '
        << references->Find(e.owner) << '\n';
  }
  out << "\nTriangles\n" << mesh.triangles.size() << '\n';
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t corner : mesh.triangles[i]) out << std::uint64_t{corner} + 1 << ' ';
    out << mesh.regions.Of(i) + 1 << '\n';
  }
  out << "\nEnd\n";
  return out.Close();
}

}  // namespace dynmesh::io
