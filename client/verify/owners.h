// The features that the rows of a mesh lie on, by their places. For files with the input's markers,
// which do not tell them.
#ifndef DYNMESH_CLIENT_VERIFY_OWNERS_H_
#define DYNMESH_CLIENT_VERIFY_OWNERS_H_

#include <vector>

#include "core/io/meshes/indexed_mesh.h"
#include "dynmesh/feature.h"

namespace dynmesh::cli {

// Sets the owners of vertices, edges and faces, and the containing dimensions of vertices. A vertex
// is at a point if it has its coordinates, and on a segment or a polygon if it is on it but for
// rounding. An edge is on a segment if both ends are; a face on a polygon if its corners are and
// its centre is inside. Owners of other rows, and of the domain box, are removed.
// O(n lg n + sum over segments and polygons of the vertices with an x in its range).
void FindOwners(const std::vector<Feature>& features, io::IndexedMesh& mesh);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_OWNERS_H_
