#include "core/io/solvers/su2_writer.h"

#include <vector>

#include "core/io/common/file_writer.h"
#include "core/io/solvers/named_facets.h"

namespace dynmesh::io {
namespace {

constexpr std::size_t kMostOfMarker = 200;
// VTK's numbers of line, triangle and tetrahedron, by the number of corners.
constexpr int kKindOf[] = {0, 1, 3, 5, 10};

}  // namespace

absl::Status WriteSu2(const IndexedMesh& mesh, const std::string& path) {
  absl::StatusOr<NamedParts> parts = NamePartsOf(mesh);
  if (!parts.ok()) return parts.status();
  for (FacetSet& set : parts->facets) {
    std::erase_if(set.facets, [](const NamedFacet& facet) { return !facet.is_border; });
  }
  std::erase_if(parts->facets, [](const FacetSet& set) { return set.facets.empty(); });

  FileWriter out(path);
  const auto dimension = static_cast<std::size_t>(mesh.dimension);
  out << "NDIME= " << dimension << "\nNELEM= " << mesh.simplex_count() << '\n';
  std::size_t row = 0;
  ForEachSimplex(mesh, [&](const auto& corners) {
    out << kKindOf[corners.size()];
    for (const std::uint32_t corner : corners) out << ' ' << corner;
    out << ' ' << row++ << '\n';
  });
  out << "NPOIN= " << mesh.vertices.size() << '\n';
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const std::array<double, 3> position = mesh.vertices[i].position();
    for (std::size_t k = 0; k < dimension; ++k) out << position[k] << ' ';
    out << i << '\n';
  }
  std::vector<std::string> names;
  for (const FacetSet& set : parts->facets) names.push_back(set.name);
  const std::vector<std::string> words = WordsOf(names, kMostOfMarker);
  out << "NMARK= " << parts->facets.size() << '\n';
  for (std::size_t k = 0; k < words.size(); ++k) {
    out << "MARKER_TAG= " << words[k] << "\nMARKER_ELEMS= " << parts->facets[k].facets.size()
        << '\n';
    for (const NamedFacet& facet : parts->facets[k].facets) {
      const auto corners = CornersOf(mesh, facet);
      out << kKindOf[dimension];
      for (std::size_t c = 0; c < dimension; ++c) out << ' ' << corners[c];
      out << '\n';
    }
  }
  return out.Close();
}

}  // namespace dynmesh::io
