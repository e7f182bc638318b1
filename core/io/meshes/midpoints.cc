// Elements of order 2.
#include <algorithm>
#include <array>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

std::uint32_t IndexedMesh::MidpointOf(std::uint32_t a, std::uint32_t b) const {
  const auto [lo, hi] = std::minmax(a, b);
  const auto at =
      std::lower_bound(edges.begin(), edges.end(), std::pair(lo, hi),
                       [](const Edge& e, const auto& ends) { return std::pair(e.a, e.b) < ends; });
  return first_midpoint + static_cast<std::uint32_t>(at - edges.begin());
}

void AddMidpoints(IndexedMesh& mesh) {
  // The faces of features around edges in them.
  absl::flat_hash_map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> face_at;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const auto& c = mesh.faces[i].corners;
    for (std::size_t k = 0; k < 3; ++k) {
      // Faces of features first: the box has none of their edges but on the border of a part.
      const auto [it, is_new] = face_at.emplace(std::minmax(c[k], c[(k + 1) % 3]), i);
      if (!is_new && mesh.faces[it->second].owner == kBoxFeature) it->second = i;
    }
  }
  RowLabels& labels = mesh.labels;
  mesh.first_midpoint = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
    const IndexedMesh::Edge& e = mesh.edges[i];
    const IndexedMesh::Vertex &a = mesh.vertices[e.a], &b = mesh.vertices[e.b];
    IndexedMesh::Vertex middle = {a.x / 2 + b.x / 2, a.y / 2 + b.y / 2, mesh.dimension, kNoFeature,
                                  a.z / 2 + b.z / 2};
    const auto face = face_at.find({e.a, e.b});
    if (e.owner != kNoFeature) {
      middle.owner = e.owner, middle.containing_dimension = 1;
    } else if (face != face_at.end()) {
      middle.owner = mesh.faces[face->second].owner, middle.containing_dimension = 2;
    }
    mesh.vertices.push_back(middle);
    if (!labels.vertex_markers.empty()) {
      std::int64_t marker = labels.edge_markers[i];
      if (face != face_at.end() && e.owner == kNoFeature) {
        marker = labels.face_markers[face->second];
      }
      labels.vertex_markers.push_back(marker);
    }
    for (std::size_t k = 0; k < labels.attributes; ++k) {
      labels.vertex_values.push_back((labels.vertex_values[e.a * labels.attributes + k] +
                                      labels.vertex_values[e.b * labels.attributes + k]) /
                                     2);
    }
  }
}

}  // namespace dynmesh::io
