// Which polygon of a prepared surface each facet of the file became a part of.
#ifndef DYNMESH_CLIENT_PREPARATION_FACET_MAP_H_
#define DYNMESH_CLIENT_PREPARATION_FACET_MAP_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/formats/geometry.h"
#include "dynmesh/feature.h"

namespace dynmesh::preparation {

// For each polygon of `facets`, in their order, the polygon of `prepared` that is nearest to its
// middle; of several the one with the least id. kNoFeature where none is within the distance, as of
// what encloses nothing, and for a facet without an area. The middle is that of the largest of the
// triangles that it is cut into: a facet that was kept is its own. Pure, thread-safe. Expected O(n
// lg n).
std::vector<FeatureId> NearestPolygons(const std::vector<Feature>& facets,
                                       const std::vector<Feature>& prepared, double within);

// The same for each facet of a surface file, in its order, and what was made of it. `within`: D; at
// least a millionth of the box's diagonal, as joining moves corners, too. INVALID_ARGUMENT for a
// file that is no surface; else as io::ReadGeometry.
absl::StatusOr<std::vector<FeatureId>> PolygonsOfFacets(const std::string& path,
                                                        const io::Geometry& prepared,
                                                        double within);

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_FACET_MAP_H_
