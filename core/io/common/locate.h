// Errors of features with their places in files. Pure, thread-safe.
#ifndef DYNMESH_CORE_IO_COMMON_LOCATE_H_
#define DYNMESH_CORE_IO_COMMON_LOCATE_H_

#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "dynmesh/feature.h"

namespace dynmesh::io {

// "file:line" of a feature, empty if unknown.
using WhereFeature = std::function<std::string(FeatureId)>;

// `status` with the place of the first feature to blame before its message, and those of the
// others after it. A status without features stays as it is.
absl::Status Locate(const absl::Status& status, const WhereFeature& where);
// The same for features that the caller has extracted from the status.
absl::Status LocateFeatures(const absl::Status& status, const std::vector<FeatureId>& features,
                            const WhereFeature& where);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_LOCATE_H_
