// Writes 3D features to files that read back as the same features, coordinates bit for bit:
// TetGen's
// `.poly` and `.smesh`, and `.off`.
//
// Points are numbered 1..n (`.off`: from 0) in their order in `features`; segments, then polygons
// follow, each in their order. So ids are kept iff they are 1..n, n+1, ... already. Sizing features
// are left out. `.off` has no segments and no markers.
//
// INVALID_ARGUMENT for a polygon of several rings, as these formats need a position in each hole,
// and for ends and corners that are no points; UNAVAILABLE if writing fails. O(n). Thread-safe.
#ifndef DYNMESH_CORE_IO_SPACE_SURFACE_OUTPUT_H_
#define DYNMESH_CORE_IO_SPACE_SURFACE_OUTPUT_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/io/common/feature_labels.h"
#include "core/io/common/triangle_sections.h"
#include "dynmesh/feature.h"

namespace dynmesh::io {

// `holes` and `regions` are positions of the whole surface, in three coordinates.
absl::Status WriteSpacePolyFile(const std::string& path, const std::vector<Feature>& features,
                                const std::vector<SeedRow>& holes,
                                const std::vector<SeedRow>& regions, const FeatureLabels& labels);
absl::Status WriteSmeshFile(const std::string& path, const std::vector<Feature>& features,
                            const std::vector<SeedRow>& holes, const std::vector<SeedRow>& regions,
                            const FeatureLabels& labels);
absl::Status WriteOffFile(const std::string& path, const std::vector<Feature>& features);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SPACE_SURFACE_OUTPUT_H_
