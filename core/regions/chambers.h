// The chambers between polygons in 3D, and the closed surface of polygons around each (mesh.h,
// RegionId).
//
// Each polygon has two sides. Around an edge, a side of each polygon faces a side of the next one:
// such sides belong to the same chamber, or to the outside. The angle between facets is at least 1
// degree, so doubles order them. Each component of sides bounds a chamber. Its signed volume is >
// 0; the outside's is < 0.
//
// Pure, thread-safe.
#ifndef DYNMESH_CORE_REGIONS_CHAMBERS_H_
#define DYNMESH_CORE_REGIONS_CHAMBERS_H_

#include <span>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "core/plc/facet.h"
#include "dynmesh/feature.h"

namespace dynmesh {

// The surfaces that a polygon is part of, by their ids, ascending. Two if there is a chamber on
// either side; none if both sides are in the same chamber.
using SurfaceIds = absl::InlinedVector<FeatureId, 2>;

// The surfaces of each polygon of `component`, which is sorted by id. REQUIRES: the component is
// connected by edges, each edge has at least two polygons, no polygon falls apart (facet_parts.h).
// O(k lg k) expected for k corners.
std::vector<SurfaceIds> FindSurfaces(std::span<const plc::Facet> component);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_REGIONS_CHAMBERS_H_
