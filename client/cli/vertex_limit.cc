#include "client/cli/vertex_limit.h"

#include <algorithm>

#include "core/base/text.h"

namespace dynmesh::cli {

std::uint64_t DefaultMostVertices(const std::vector<Feature>& features,
                                  const MeshOptions& options) {
  const std::uint64_t most = options.limits.max_vertices;
  const auto is_size = [](const Feature& f) { return f.kind == FeatureKind::kSize; };
  if (options.max_edge > 0 || std::ranges::any_of(features, is_size)) return most;
  return std::min(most, std::max(kFewestVertices, kVerticesForFeature * features.size()));
}

VertexLimit VertexLimitOf(const std::vector<Feature>& features, const MeshOptions& options,
                          bool is_given, const MemoryBudget& memory) {
  VertexLimit limit{options.limits.max_vertices, ""};
  if (!is_given) {
    limit.most = DefaultMostVertices(features, options);
    if (limit.most < options.limits.max_vertices) {
      limit.reason =
          "the default of `mesh` for so many features without target lengths; --max-vertices "
          "allows more";
    }
  }
  if (const std::uint64_t fit = memory.MostVertices(options.dimension); fit < limit.most) {
    limit = {fit, text::Concat("what fits into ", memory.Text(), "; --max-memory allows more")};
  }
  return limit;
}

}  // namespace dynmesh::cli
