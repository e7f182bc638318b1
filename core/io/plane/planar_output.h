// Writes features to files that read back as the same features, coordinates bit for bit.
#ifndef DYNMESH_CORE_IO_PLANE_PLANAR_OUTPUT_H_
#define DYNMESH_CORE_IO_PLANE_PLANAR_OUTPUT_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/io/common/feature_labels.h"
#include "core/io/common/triangle_sections.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::io {

// Triangle's `.poly`, for points and segments only, with markers and attributes of `labels`.
// Numbers points 1..n and segments 1..m in their order in `features`. So it keeps ids iff they
// are 1..n and n+1..n+m already. INVALID_ARGUMENT if a segment's end is no point among them;
// UNAVAILABLE if writing fails.
absl::Status WritePolyFile(const std::string& path, const std::vector<Feature>& features,
                           const std::vector<SeedRow>& holes = {},
                           const std::vector<SeedRow>& regions = {},
                           const FeatureLabels& labels = {});

// An edit script with one batch that adds every feature under its id, and the markers and names of
// `labels`. In a name `#` becomes a blank, since it begins a comment.
absl::Status WriteFeatureScript(const std::string& path, const MeshOptions& options,
                                const std::vector<Feature>& features,
                                const FeatureLabels& labels = {});

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PLANE_PLANAR_OUTPUT_H_
