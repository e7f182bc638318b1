// Meshes as Gmsh's `.msh`, ASCII or binary: 4.1, for Gmsh, DOLFINx, deal.II, Elmer and meshio, and
// 2.2, for programs that read no other.
#ifndef DYNMESH_CORE_IO_MESHES_MSH_WRITER_H_
#define DYNMESH_CORE_IO_MESHES_MSH_WRITER_H_

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

// Node tags are rows of the canonical order of IndexedMesh, from 1; coordinates read back bit for
// bit. Entities in 2D:
//   input point               a point with one element
//   segment, the box's border a curve with the subsegments as elements
//   everything else           surface 1, counter-clockwise triangles; in polygons, surface
//                             1 + the number of the region (region_numbers.h)
// In 3D the box's border and each polygon are surfaces with the subfacets as elements. Everything
// else is volume 1, positively oriented tetrahedra; in polygons volume 1 + the number of the
// region.
//
// Feature ids have 64 bits, so they are in the names of physical groups: "feature 30", "box".
// Surfaces (3D: volumes) have "domain", "polygon 12" and "polygons 12 40", or the name of their
// polygon (region_labels.h); each name is a group. No two groups have one name (msh_groups.h): in
// 3D the edges of polygon 30 are "feature 30 edges". Readers take at most 127 characters. A longer
// list is in a $Comments section, which they skip: "region 3: polygons 12 40 ..."; the group is
// then "region 3", by the region's number. The other groups' tags are the references of
// references.h; points, curves and surfaces of features have the same numbers as their group.
// INVALID_ARGUMENT if there are too many rows; UNAVAILABLE, naming the path, if it cannot be
// written.
// A mesh with midpoints (order 2) has elements of order 2.
//
// In version 2.2 nodes are in the order of rows, and entities are but numbers: each element has its
// group and its entity; tags are ints, also where they are text.
enum class MshVersion { k41, k22 };
absl::Status WriteMsh(const IndexedMesh& mesh, const std::string& path,
                      MshVersion version = MshVersion::k41, bool binary = false);
// 4.1 or 2.2. INVALID_ARGUMENT for another; `name` is what the caller calls it.
absl::StatusOr<MshVersion> MshVersionOf(double version, std::string_view name);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_MSH_WRITER_H_
