#include "client/cli/vertex_limit.h"

#include "core/base/text.h"

namespace dynmesh::cli {

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
