#include "core/io/meshes/references.h"

#include <algorithm>
#include <limits>

#include "core/base/text.h"

namespace dynmesh::io {

absl::StatusOr<References> References::Of(const IndexedMesh& mesh) {
  // Elements of all kinds are numbered together.
  const std::uint64_t rows = std::uint64_t{mesh.vertices.size()} + mesh.edges.size() +
                             mesh.simplex_count() + mesh.faces.size() + mesh.vertices.size();
  if (rows >= std::numeric_limits<std::int32_t>::max()) {
    return absl::InvalidArgumentError(
        "the mesh has more rows than such files can number (2^31 - 2); write .node or .vtu");
  }
  References references;
  std::vector<FeatureId>& features = references.features_;
  for (const auto& v : mesh.vertices) features.push_back(v.owner);
  for (const auto& e : mesh.edges) features.push_back(e.owner);
  for (const auto& f : mesh.faces) features.push_back(f.owner);
  std::erase_if(features, [](FeatureId id) { return id == kNoFeature || id == kBoxFeature; });
  std::sort(features.begin(), features.end());
  features.erase(std::unique(features.begin(), features.end()), features.end());
  return references;
}

int References::Find(FeatureId owner) const {
  if (owner == kNoFeature) return 0;
  if (owner == kBoxFeature) return box();
  const auto at = std::lower_bound(features_.begin(), features_.end(), owner);
  return static_cast<int>(at - features_.begin()) + 1;
}

std::string References::Name(int reference) const {
  if (reference == box()) return "box";
  return text::Concat("feature ", features_[static_cast<std::size_t>(reference) - 1]);
}

}  // namespace dynmesh::io
