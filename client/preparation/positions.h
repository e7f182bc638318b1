// The points among features, by id.
#ifndef DYNMESH_CLIENT_PREPARATION_POSITIONS_H_
#define DYNMESH_CLIENT_PREPARATION_POSITIONS_H_

#include <vector>

#include "absl/container/flat_hash_map.h"
#include "client/cleaning/node_table.h"
#include "core/base/feature_kinds.h"
#include "dynmesh/feature.h"

namespace dynmesh::preparation {

using Positions = absl::flat_hash_map<FeatureId, cleaning::Point3>;

// Pure, thread-safe. Expected O(features).
inline Positions PositionsOf(const std::vector<Feature>& features) {
  Positions at;
  for (const Feature& f : features) {
    if (IsPoint(f)) at[f.id] = f.position;
  }
  return at;
}

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_POSITIONS_H_
