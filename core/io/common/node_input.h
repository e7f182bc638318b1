// The common parts of 2D and 3D `.node`, `.poly` and `.smesh` files: vertices, which become the
// points 1..n, in the file or in a `.node` beside it; and seeds at the end.
#ifndef DYNMESH_CORE_IO_COMMON_NODE_INPUT_H_
#define DYNMESH_CORE_IO_COMMON_NODE_INPUT_H_

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/common/text_reader.h"
#include "core/io/common/triangle_sections.h"

namespace dynmesh::io {

// A whole `.node` file.
absl::StatusOr<FileFeatures> ParsePoints(TextReader& nodes, int dimension);

// The nonzero ones of `markers`, of the features `first`, `first` + 1, ...
void AddMarkers(std::span<const std::uint64_t> markers, FeatureId first, FeatureLabels& labels);

// Opens the `.node` file with the vertices of a file that has none.
using OpenNodes = std::function<absl::StatusOr<TextReader>()>;
OpenNodes OpenNodesBeside(const std::string& path);

// The vertices of a `.poly` or `.smesh`, its own or the external file's; added to `input` as
// points. NOT_FOUND from `open_nodes` becomes an error of `poly`.
absl::StatusOr<NodeSection> ReadPointsOfPoly(TextReader& poly, int dimension,
                                             const OpenNodes& open_nodes, FileFeatures& input);

// The last sections, holes and regions, up to the end of the file.
absl::Status ReadSeedSections(TextReader& poly, int dimension, FileFeatures& input);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_NODE_INPUT_H_
