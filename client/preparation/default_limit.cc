#include "client/preparation/default_limit.h"

#include <algorithm>

namespace dynmesh::preparation {

std::uint64_t DefaultMostVertices(const std::vector<Feature>& features,
                                  const MeshOptions& options) {
  const std::uint64_t most = options.limits.max_vertices;
  const auto is_size = [](const Feature& f) { return f.kind == FeatureKind::kSize; };
  if (options.max_edge > 0 || std::ranges::any_of(features, is_size)) return most;
  return std::min(most, std::max(kFewestVertices, kVerticesForFeature * features.size()));
}

}  // namespace dynmesh::preparation
