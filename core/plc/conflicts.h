// All conflicts of a set of 3D features at once: for programs that mend them. Plc::Check ends at
// the first one, in the order of the edits.
//
// Thread-safe. Expected O(n lg n) for n features, as Check, less what need not be looked at.
#ifndef DYNMESH_CORE_PLC_CONFLICTS_H_
#define DYNMESH_CORE_PLC_CONFLICTS_H_

#include <vector>

#include "absl/functional/function_ref.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

// Calls found(f, g) for each pair of `features` in conflict (rules.h, facet_rules.h) of which
// `is_looked_at` says yes to one at least, once or several times; found(f, f) for one that is
// illegal by itself. The edge of polygons is looked at with each of them, and reported as each. The
// pairs do not depend on the order of the features. Only points, segments and polygons count.
// REQUIRES: ValidateOptions(options) is OK, the dimension is 3; segments and polygons are of
// points of `features`.
void FindConflicts(const MeshOptions& options, const std::vector<Feature>& features,
                   absl::FunctionRef<bool(FeatureId)> is_looked_at,
                   absl::FunctionRef<void(FeatureId, FeatureId)> found);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_CONFLICTS_H_
