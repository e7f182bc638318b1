// 3D `.node` files and TetGen's `.poly` and `.smesh` files as features: points of the file become
// 1..n; segments follow, then polygons, each in file order. For 2D: planar_input.h.
//
// A facet becomes a polygon of its polygons with at least three corners. Polygons of two corners
// become segments, without duplicates. Polygons of one corner are vertices on the facet, and all
// vertices are points anyway. The inside is even-odd: a ring in a ring is a hole. TetGen instead
// needs a position in each hole and keeps the face without one. If the two differ, it is an error:
//   * a ring inside an odd number of others without a position of a hole in it;
//   * a position of a hole in a part that even-odd keeps.
// Also errors: an edge shared by two polygons of a facet; a polygon that visits a vertex twice; two
// facets with the same corners; and, if there are holes, a ring with all of its corners on another
// one. With FaceRules::kAsTheyCome, of these only the positions of holes are checked. Holes and
// regions of the whole file are kept as positions.
//
// INVALID_ARGUMENT as `file:line: what is wrong`; NOT_FOUND and the like if a file cannot be read.
// Does not check geometry, such as flat facets or their intersections. O(file) expected time, but
// O(corners * rings) for a facet of many rings. Thread-safe.
#ifndef DYNMESH_CORE_IO_SPACE_SPACE_INPUT_H_
#define DYNMESH_CORE_IO_SPACE_SPACE_INPUT_H_

#include <string>

#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/common/node_input.h"
#include "core/io/common/text_reader.h"
#include "core/io/space/face_rules.h"

namespace dynmesh::io {

absl::StatusOr<FileFeatures> ReadSpaceNodeFile(const std::string& path);
// A file without vertices uses those of the `.node` beside it.
absl::StatusOr<FileFeatures> ReadSpacePolyFile(const std::string& path,
                                               FaceRules rules = FaceRules::kStrict);
absl::StatusOr<FileFeatures> ReadSmeshFile(const std::string& path,
                                           FaceRules rules = FaceRules::kStrict);

// The same from texts in memory. Calls `open_nodes` for the vertices of a file without any;
// NOT_FOUND from it becomes an error of that file.
absl::StatusOr<FileFeatures> ParseSpaceNodeText(TextReader nodes);
absl::StatusOr<FileFeatures> ParseSpacePolyText(TextReader poly, const OpenNodes& open_nodes,
                                                FaceRules rules = FaceRules::kStrict);
absl::StatusOr<FileFeatures> ParseSmeshText(TextReader smesh, const OpenNodes& open_nodes,
                                            FaceRules rules = FaceRules::kStrict);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SPACE_SPACE_INPUT_H_
