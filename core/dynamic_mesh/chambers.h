// The chambers that polygons of space leave between them, and the polygons around each: its closed
// surface (mesh.h, RegionId).
//
// Each polygon has two sides. Around an edge, whoever leaves one polygon meets a side of the next:
// such sides belong to one chamber, or to the outside. No two facets are at less than 70 degrees
// there, so doubles tell which is next. What hangs together so encloses a volume, seen from the
// chamber; seen from the outside that is negative.
//
// Pure, thread-safe.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_CHAMBERS_H_
#define DYNMESH_CORE_DYNAMIC_MESH_CHAMBERS_H_

#include <span>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "core/plc/facet.h"
#include "dynmesh/feature.h"

namespace dynmesh {

// Of a polygon: the surfaces that it is part of, by their ids, ascending. Both if it has a chamber
// on either side, none if it has the same on both.
using SurfaceIds = absl::InlinedVector<FeatureId, 2>;

// Of each polygon of a piece, which is joined by edges and has at least two polygons at each. None
// of them falls apart (facet_parts.h). `piece` by ascending id. O(k lg k) expected for k corners.
std::vector<SurfaceIds> FindSurfaces(std::span<const plc::Facet> piece);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_CHAMBERS_H_
