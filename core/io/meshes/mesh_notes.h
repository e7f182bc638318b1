// Comments "# dynmesh ..." of .node and .ele files: what their rows cannot say.
#ifndef DYNMESH_CORE_IO_MESHES_MESH_NOTES_H_
#define DYNMESH_CORE_IO_MESHES_MESH_NOTES_H_

#include <string_view>

namespace dynmesh::io {

inline constexpr std::string_view kHashNote = "hash ";
// The notes for vertices of the box, by containing dimension.
inline constexpr std::string_view kBoxNotes[] = {"", "box-side-vertices ", "box-face-vertices "};
inline constexpr std::string_view kRegionNote = "region ";
inline constexpr std::string_view kNameNote = "name ";
inline constexpr std::string_view kMarkersNote = "markers input";
inline constexpr std::string_view kRhoNote = "rho ";
inline constexpr std::string_view kDihedralNote = "min-dihedral ";
// A constrained Delaunay triangulation without Steiner points (MeshKind::kTriangulation).
inline constexpr std::string_view kTriangulationNote = "kind triangulation";
// The mesh is a part of a whole one: what --inside, --region or --outside chose.
inline constexpr std::string_view kPartNote = "part";

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_MESH_NOTES_H_
