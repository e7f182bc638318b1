// The input as cleaning begins with it, in 2D and 3D: the features are checked, and points become
// nodes.
#ifndef DYNMESH_CLIENT_CLEANING_ENTRY_H_
#define DYNMESH_CLIENT_CLEANING_ENTRY_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "client/cleaning/node_table.h"
#include "core/base/feature_kinds.h"
#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

struct EntryLimits {
  std::size_t dimension;
  int max_exponent;  // coordinates and tolerance are at most 2^max_exponent
  FeatureId max_id;  // leaves room for new ones
};

// Returns the greatest id, 0 if there are no features. INVALID_ARGUMENT, with ErrorDetail
// (dynmesh/error.h), for ids that are 0, above the limit or not unique, for ends and corners that
// are no points, and for coordinates that are not finite or above the limit; INVALID_ARGUMENT for a
// tolerance below 2^-41 of the largest coordinate. Expected O(n).
absl::StatusOr<FeatureId> CheckFeatures(const std::vector<Feature>& features, double tolerance,
                                        const EntryLimits& limits);

// Makes a node of each point, unless one is near, in the order of coordinates; of equal ones, of
// ids. Coordinates near 0 are rounded to 0. Says so in graph.changes. A graph is a LineGraph or a
// Surface. O(n lg n).
template <std::size_t D, class Graph>
void EnterPoints(const std::vector<Feature>& features, Graph& graph,
                 absl::flat_hash_map<FeatureId, Node>& node_of) {
  using OneChange = typename decltype(graph.changes)::value_type;
  using Kind = decltype(OneChange::kind);
  constexpr double kMinCoordinate = 0x1p-200;
  std::vector<std::pair<PointOf<D>, FeatureId>> entries;
  for (const Feature& f : features) {
    if (!IsPoint(f)) continue;
    PointOf<D> given;
    for (std::size_t i = 0; i < D; ++i) given[i] = f.position[i] + 0.0;  // -0 becomes 0
    PointOf<D> at = given;
    for (double& x : at) {
      if (std::abs(x) < kMinCoordinate) x = 0;
    }
    if (at != given) graph.changes.push_back({Kind::kPointRounded, {f.id}, given, at});
    entries.emplace_back(at, f.id);
  }
  std::sort(entries.begin(), entries.end());
  for (const auto& [at, id] : entries) {
    const std::optional<Node> near = graph.Near(at);
    node_of[id] = near ? *near : graph.AddNode(at, id);
    if (!near) continue;
    graph.changes.push_back(
        {Kind::kPointMerged, {id, graph.point_ids[*near]}, at, graph.nodes.at(*near)});
  }
}

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_ENTRY_H_
