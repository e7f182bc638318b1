#include "core/io/meshes/row_labels.h"

#include <algorithm>
#include <array>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {
namespace {

constexpr std::int64_t kOnBorder = 1;  // of what has no marker

// The sides of simplices that only one simplex has, each ascending.
template <int D>
std::vector<std::array<std::uint32_t, D>> BorderOf(const IndexedMesh& mesh) {
  using Side = std::array<std::uint32_t, D>;
  absl::flat_hash_map<Side, int> uses;
  for (const auto& corners : SimplicesOf<D>(mesh)) {
    for (std::size_t k = 0; k <= D; ++k) {
      Side side;
      std::size_t count = 0;
      for (std::size_t j = 0; j <= D; ++j) {
        if (j != k) side[count++] = corners[j];
      }
      std::sort(side.begin(), side.end());
      ++uses[side];
    }
  }
  std::vector<Side> border;
  for (const auto& [side, count] : uses) {
    if (count == 1) border.push_back(side);
  }
  return border;
}

// Input points without a marker get that of the segment with the least id, in 3D then of the
// polygon, that has one: as in Triangle, what is told of a border holds at its corners, too.
void LabelEnds(IndexedMesh& mesh) {
  std::vector<std::int64_t>& of_vertices = mesh.labels.vertex_markers;
  std::vector<bool> is_open(of_vertices.size());
  for (std::size_t v = 0; v < is_open.size(); ++v) {
    is_open[v] = of_vertices[v] == 0 && mesh.vertices[v].containing_dimension == 0;
  }
  const auto add = [&](const auto& rows, const std::vector<std::int64_t>& markers,
                       const auto& corners_of) {
    std::vector<FeatureId> least(is_open.size(), kBoxFeature);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (markers[i] == 0) continue;
      for (const std::uint32_t v : corners_of(rows[i])) {
        if (!is_open[v] || rows[i].owner >= least[v]) continue;
        least[v] = rows[i].owner;
        of_vertices[v] = markers[i];
      }
    }
    for (std::size_t v = 0; v < is_open.size(); ++v) is_open[v] = is_open[v] && of_vertices[v] == 0;
  };
  add(mesh.edges, mesh.labels.edge_markers, [](const IndexedMesh::Edge& e) {
    return std::array{e.a, e.b};
  });
  add(mesh.faces, mesh.labels.face_markers, [](const IndexedMesh::Face& f) { return f.corners; });
}

template <int D>
void Label(IndexedMesh& mesh) {
  RowLabels& labels = mesh.labels;
  const auto marker_of = [&](FeatureId owner) { return labels.features->MarkerOf(owner); };
  for (const auto& v : mesh.vertices) labels.vertex_markers.push_back(marker_of(v.owner));
  for (const auto& e : mesh.edges) labels.edge_markers.push_back(marker_of(e.owner));
  for (const auto& f : mesh.faces) labels.face_markers.push_back(marker_of(f.owner));
  LabelEnds(mesh);
  absl::flat_hash_map<std::array<std::uint32_t, 2>, std::size_t> edge_of;
  absl::flat_hash_map<std::array<std::uint32_t, 3>, std::size_t> face_of;
  for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
    edge_of.emplace(std::array{mesh.edges[i].a, mesh.edges[i].b}, i);
  }
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) face_of.emplace(mesh.faces[i].corners, i);
  const auto mark = [](const auto& rows, const auto& key, std::vector<std::int64_t>& markers) {
    const auto it = rows.find(key);
    if (it != rows.end() && markers[it->second] == 0) markers[it->second] = kOnBorder;
  };
  for (const auto& side : BorderOf<D>(mesh)) {
    for (const std::uint32_t v : side) {
      if (labels.vertex_markers[v] == 0) labels.vertex_markers[v] = kOnBorder;
    }
    if constexpr (D == 2) {
      mark(edge_of, side, labels.edge_markers);
    } else {
      mark(face_of, side, labels.face_markers);
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [a, b] = std::minmax(side[k], side[(k + 1) % 3]);
        mark(edge_of, std::array{a, b}, labels.edge_markers);
      }
    }
  }
}

}  // namespace

void LabelRows(std::shared_ptr<const FeatureLabels> features, bool replace_ids, IndexedMesh& mesh) {
  mesh.labels.features = std::move(features);
  mesh.labels.replace_ids = replace_ids;
  if (mesh.labels.features->markers.empty() && !replace_ids) return;
  mesh.dimension == 2 ? Label<2>(mesh) : Label<3>(mesh);
}

}  // namespace dynmesh::io
