#include "core/io/solvers/sms_writer.h"

#include <vector>

#include "core/io/common/file_writer.h"
#include "core/io/solvers/edge_chains.h"
#include "core/io/solvers/named_facets.h"

namespace dynmesh::io {
namespace {

constexpr std::size_t kOnALine = 10;

void WriteChain(const Chain& chain, std::size_t number, FileWriter& out) {
  for (std::size_t i = 0; i < chain.size(); ++i) {
    if (i % kOnALine == 0) out << (i == 0 ? "NS" : "\nNS");
    out << (i + 1 == chain.size() ? " -" : " ") << std::uint64_t{chain[i]} + 1;
  }
  out << ' ' << number << '\n';
}

}  // namespace

absl::Status WriteSms(const IndexedMesh& mesh, const std::string& path) {
  const absl::StatusOr<NamedParts> parts = NamePartsOf(mesh);
  if (!parts.ok()) return parts.status();
  FileWriter out(path);
  out << "MESH2D\n";
  std::vector<std::size_t> region_of(mesh.triangles.size(), 0);
  for (std::size_t k = 0; k < parts->regions.size(); ++k) {
    out << "# region " << k + 1 << ": " << parts->regions[k].name << '\n';
    for (const std::uint32_t i : parts->regions[k].simplices) region_of[i] = k + 1;
  }
  for (std::size_t k = 0; k < parts->facets.size(); ++k) {
    out << "# string " << k + 1 << ": " << parts->facets[k].name << '\n';
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    out << "E3T " << i + 1;
    for (const std::uint32_t corner : mesh.triangles[i]) out << ' ' << std::uint64_t{corner} + 1;
    out << ' ' << region_of[i] << '\n';
  }
  const std::size_t width = mesh.labels.attributes;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    out << "ND " << i + 1 << ' ' << mesh.vertices[i].x << ' ' << mesh.vertices[i].y << ' '
        << (width == 0 ? 0.0 : mesh.labels.vertex_values[width * i]) << '\n';
  }
  for (std::size_t k = 0; k < parts->facets.size(); ++k) {
    for (const Chain& chain : ChainsOf(EdgesOf(mesh, parts->facets[k]))) {
      WriteChain(chain, k + 1, out);
    }
  }
  return out.Close();
}

}  // namespace dynmesh::io
