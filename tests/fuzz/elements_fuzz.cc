#include <cmath>

#include "core/io/elements/element_mesh.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {
namespace {

std::string Check(const absl::StatusOr<io::ElementMesh>& mesh) {
  if (!mesh.ok()) {
    const bool placed = mesh.status().message().substr(0, 5) == "fuzz.";
    return placed ? "" : "an error without a file: " + mesh.status().ToString();
  }
  for (const auto vertices : {io::ElementVertices::kOfConstraints, io::ElementVertices::kAll}) {
    const io::FileFeatures input = io::FeaturesOf(*mesh, vertices);
    if (input.lines.size() != input.features.size()) return "counts disagree";
    for (std::size_t i = 0; i < input.features.size(); ++i) {
      const Feature& f = input.features[i];
      if (f.id != i + 1) return "ids are not in order";
      if (input.Where(f.id).empty()) return "a feature without a place";
      if (f.kind == FeatureKind::kPoint) continue;
      std::vector<FeatureId> ends(f.ends.begin(), f.ends.end());
      if (f.kind == FeatureKind::kPolygon) ends = f.rings.at(0);
      for (const FeatureId end : ends) {
        if (end < 1 || end > input.point_count) return "an end is no point";
      }
    }
    for (const auto* const seeds : {&input.holes, &input.regions}) {
      for (const io::SeedRow& seed : *seeds) {
        for (const double c : seed.position) {
          if (!std::isfinite(c)) return "a seed nowhere";
        }
      }
    }
  }
  const io::IndexedMesh indexed = io::ToIndexed(*mesh);
  if (indexed.vertices.size() != mesh->positions.size()) return "a vertex was lost";
  const std::size_t simplices =
      mesh->dimension == 2 ? mesh->triangles.size() : mesh->tetrahedra.size();
  return indexed.simplex_count() == simplices ? "" : "a simplex was lost";
}

}  // namespace

std::string FuzzElements(std::string_view bytes) {
  const std::string text(bytes);
  if (auto problem = Check(io::ParseMsh(io::TextReader("fuzz.msh", text))); !problem.empty()) {
    return problem;
  }
  if (auto problem = Check(io::ParseMedit(io::TextReader("fuzz.mesh", text))); !problem.empty()) {
    return problem;
  }
  return Check(io::ParseVtu("fuzz.vtu", text));
}

}  // namespace dynmesh::fuzz
