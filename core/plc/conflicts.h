// All features of a 3D set that are in conflict: for programs that mend them. Plc::Check ends at
// the first one, in the order of the edits.
//
// Thread-safe. Expected O(n lg n) for n features, as Check, less what is far from all that is new.
#ifndef DYNMESH_CORE_PLC_CONFLICTS_H_
#define DYNMESH_CORE_PLC_CONFLICTS_H_

#include <vector>

#include "absl/functional/function_ref.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

// Calls found(f), once, for each of `features` that is looked at and is illegal by itself, or in
// conflict (rules.h, facet_rules.h) with another one. Pairs of which none is new are not judged,
// nor what is not new by itself: they are known to be legal, or do not matter. The edge of polygons
// is looked at, and new, with each of them. What is found does not depend on the order of the
// features. Only points, segments and polygons count. REQUIRES: ValidateOptions(options) is OK, the
// dimension is 3; segments and polygons are of points of `features`.
void FindConflicts(const MeshOptions& options, const std::vector<Feature>& features,
                   absl::FunctionRef<bool(FeatureId)> is_looked_at,
                   absl::FunctionRef<bool(FeatureId)> is_new,
                   absl::FunctionRef<void(FeatureId)> found);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_CONFLICTS_H_
