#include "client/preparation/default_limit.h"

#include <algorithm>

#include "core/base/feature_kinds.h"

namespace dynmesh::preparation {

std::uint64_t DefaultMostVertices(const std::vector<Feature>& features,
                                  const MeshOptions& options) {
  const std::uint64_t most = options.limits.max_vertices;
  const auto is_size = [](const Feature& f) {
    return Is<ASize>(f, Not<APoint, ASegment, APolygon>);
  };
  if (options.max_edge > 0 || std::ranges::any_of(features, is_size)) return most;
  return std::min(most, std::max(kFewestVertices, kVerticesForFeature * features.size()));
}

}  // namespace dynmesh::preparation
