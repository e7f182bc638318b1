// Pictures of quadtrees; of an octree the leaves at a plane across one axis.
#ifndef DYNMESH_CORE_IO_PICTURES_LEAF_SVG_H_
#define DYNMESH_CORE_IO_PICTURES_LEAF_SVG_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/pictures/svg_writer.h"
#include "core/io/quadtrees/leaf_list.h"

namespace dynmesh::io {

// `options`: crop, cut, legend (with kSize) and width as for meshes; the fill is kSize (by level:
// the finer, the darker), kPlain or kNone, else INVALID_ARGUMENT. UNAVAILABLE, naming the path, on
// an error. O(leaves).
absl::Status WriteLeafSvg(const LeafList& list, const SvgOptions& options, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_LEAF_SVG_H_
