// Columns of labels (dynmesh/mesh.h). Pure functions, thread-safe.
#ifndef DYNMESH_CORE_MESH_DATA_LABELS_H_
#define DYNMESH_CORE_MESH_DATA_LABELS_H_

#include <cstddef>

#include "dynmesh/mesh.h"

namespace dynmesh::mesh_data {

// Do the ids ascend, none of them 0?
bool AreLabels(const LabelColumn& labels);
// The same, and none is empty: those of a mesh.
bool AreLabelsOfMesh(const LabelColumn& labels);

// `labels` of a mesh, changed by those of a diff. O(both).
LabelColumn ChangedLabels(const LabelColumn& labels, const LabelColumn& changes);
// The labels of a diff between meshes with these labels. O(both).
LabelColumn DiffLabels(const LabelColumn& from, const LabelColumn& to);

// Memory of the rows.
std::size_t ByteSize(const LabelColumn& labels);

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_LABELS_H_
