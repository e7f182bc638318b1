// Features into files that read back as the same features, coordinates bit for bit.
#ifndef DYNMESH_CORE_IO_PLANAR_OUTPUT_H_
#define DYNMESH_CORE_IO_PLANAR_OUTPUT_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/io/triangle_sections.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::io {

// Triangle's `.poly`, which has no place for other kinds of feature. Points are numbered 1..n and
// segments 1..m as they follow each other in `features`, so ids are kept exactly where they
// are 1..n and n+1..n+m already. INVALID_ARGUMENT if a segment's end is no point among them,
// UNAVAILABLE if writing fails.
absl::Status WritePolyFile(const std::string& path, const std::vector<Feature>& features,
                           const std::vector<SeedRow>& holes = {},
                           const std::vector<SeedRow>& regions = {});

// An edit script of one batch, which adds every feature under its id.
absl::Status WriteFeatureScript(const std::string& path, const MeshOptions& options,
                                const std::vector<Feature>& features);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PLANAR_OUTPUT_H_
