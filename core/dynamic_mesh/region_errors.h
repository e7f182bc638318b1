// Errors of a batch with regions that cannot be labelled.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_REGION_ERRORS_H_
#define DYNMESH_CORE_DYNAMIC_MESH_REGION_ERRORS_H_

#include <span>

#include "absl/status/status.h"
#include "core/regions/region_sets.h"
#include "dynmesh/feature.h"

namespace dynmesh {

// ID_COLLISION: two sets of polygons (3D: closed surfaces) would have the same id.
absl::Status CollisionError(int dimension, const RegionSets::Collision& collision);

// POLYGON_LIMIT: these polygons lie over each other.
absl::Status TooManyPolygonsError(int dimension, std::span<const FeatureId> polygons);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_REGION_ERRORS_H_
