#include "core/io/quadtrees/leaf_list.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/base/text.h"

namespace dynmesh::io {

absl::StatusOr<LeafList> LeavesOf(const Mesh& mesh, const MeshOptions& options) {
  LeafList list;
  list.dimension = mesh.dimension;
  const auto width = static_cast<std::size_t>(mesh.dimension);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const double* const centre = &mesh.vertices.coordinates[i * width];
    const std::optional<QuadtreeCell> cell = QuadtreeCellAt(options, centre);
    if (!cell.has_value()) {
      return absl::DataLossError(text::Concat("vertex ", mesh.vertices.ids[i],
                                              " is not the centre of a cell of the quadtree"));
    }
    LeafList::Leaf leaf{*cell, {}, mesh.vertices.ids[i]};
    std::copy_n(centre, width, leaf.centre.begin());
    list.leaves.push_back(leaf);
  }
  std::sort(list.leaves.begin(), list.leaves.end(),
            [](const LeafList::Leaf& a, const LeafList::Leaf& b) {
              return std::tie(a.cell.level, a.cell.at) < std::tie(b.cell.level, b.cell.at);
            });
  return list;
}

}  // namespace dynmesh::io
