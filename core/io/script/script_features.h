// The features after the last line of an edit script.
#ifndef DYNMESH_CORE_IO_SCRIPT_SCRIPT_FEATURES_H_
#define DYNMESH_CORE_IO_SCRIPT_SCRIPT_FEATURES_H_

#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/script/edit_script.h"
#include "dynmesh/feature.h"

namespace dynmesh::io {

struct ScriptFeatures {
  std::vector<Feature> features;            // by id
  std::map<FeatureId, std::string> places;  // "file:line" of the last edit of each
};

// INVALID_ARGUMENT as `file:line: ...` for an edit that does not fit those before it: a feature is
// added twice, or is not there, or is moved and no point. Does not check geometry. O(n lg n).
absl::StatusOr<ScriptFeatures> FeaturesAfter(const EditScript& script);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SCRIPT_SCRIPT_FEATURES_H_
