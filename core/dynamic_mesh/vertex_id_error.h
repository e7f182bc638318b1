// The error of two vertices with the same public id.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_VERTEX_ID_ERROR_H_
#define DYNMESH_CORE_DYNAMIC_MESH_VERTEX_ID_ERROR_H_

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/base/text.h"
#include "dynmesh/error.h"
#include "dynmesh/feature.h"

namespace dynmesh {

struct NamedVertex {
  std::vector<double> coordinates;
  FeatureId owner = kNoFeature;
};

inline absl::Status VertexIdError(const std::array<NamedVertex, 2>& vertices) {
  std::string names;
  std::vector<FeatureId> owners;
  for (const NamedVertex& vertex : vertices) {
    names += names.empty() ? "the vertices at (" : " and (";
    for (std::size_t k = 0; k < vertex.coordinates.size(); ++k) {
      names += (k == 0 ? "" : ", ") + text::Concat(vertex.coordinates[k]);
    }
    names += ")";
    if (vertex.owner == kNoFeature || vertex.owner == kBoxFeature) continue;
    names += " on feature " + std::to_string(vertex.owner);
    if (std::ranges::find(owners, vertex.owner) == owners.end()) owners.push_back(vertex.owner);
  }
  return MakeError(absl::StatusCode::kFailedPrecondition,
                   names +
                       " would have the same id, a hash of coordinates; move one of the "
                       "features a little",
                   {reason::kIdCollision, owners, {}});
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_VERTEX_ID_ERROR_H_
