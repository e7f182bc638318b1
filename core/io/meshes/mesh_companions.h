// Files beside a mesh's .node and .ele: neighbours, the Voronoi diagram, and the constraints as
// input for Triangle and TetGen. Rows are numbered from `base`.
#ifndef DYNMESH_CORE_IO_MESHES_MESH_COMPANIONS_H_
#define DYNMESH_CORE_IO_MESHES_MESH_COMPANIONS_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/io/common/file_writer.h"
#include "core/io/meshes/indexed_mesh.h"
#include "core/io/meshes/mesh_files.h"

namespace dynmesh::io {

// .neigh: of each simplex those across the sides opposite to its corners, -1 on the border.
void WriteNeighbours(const IndexedMesh& mesh, std::uint64_t base, FileWriter& out);

// .v.node: the circumcentres of simplices; .v.edge: "end end" for each side of two simplices, "end
// -1 direction" (a ray outwards) for each side of one. As by `triangle -v` and `tetgen -v`.
void WriteVoronoi(const IndexedMesh& mesh, std::uint64_t base, FileWriter& nodes,
                  FileWriter& edges);

// A .poly (2D, 3D) or .smesh (3D) without vertices: subsegments as segments, subfacets as facets,
// with the markers of .edge and .face; and holes.
void WriteConstraints(const IndexedMesh& mesh, const MeshFileOptions& options,
                      const std::string& extension, FileWriter& out);

// The marker of an owner: -1 is the box, which is its id in two's complement.
template <class Out>
void WriteMarker(FeatureId owner, Out& out) {
  if (owner == kBoxFeature) {
    out << "-1";
  } else {
    out << owner;
  }
}
// The marker of row i, from the labels if they have it in place of ids.
template <class Out>
void WriteRowMarker(const IndexedMesh& mesh, const std::vector<std::int64_t>& labels, std::size_t i,
                    FeatureId owner, Out& out) {
  if (mesh.labels.replace_ids) {
    out << labels[i];
  } else {
    WriteMarker(owner, out);
  }
}

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_MESH_COMPANIONS_H_
