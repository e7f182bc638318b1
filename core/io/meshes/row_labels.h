// Labels of the rows of an IndexedMesh, from those of the features that rows lie on. Plain data.
#ifndef DYNMESH_CORE_IO_MESHES_ROW_LABELS_H_
#define DYNMESH_CORE_IO_MESHES_ROW_LABELS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/io/common/feature_labels.h"

namespace dynmesh::io {

struct IndexedMesh;

// Empty columns say nothing.
struct RowLabels {
  std::shared_ptr<const FeatureLabels> features;  // null: nothing is known
  // Files have the input's markers, and the attributes of its regions, where they otherwise have
  // ids of features and numbers of regions.
  bool replace_ids = false;
  bool steiner_ids = false;  // .node files have the ids of features on their Steiner points, too
  // Markers of the features that rows lie on: a Steiner point on a segment has the segment's, a
  // point of the input without one that of its first segment (in 3D then polygon) with one. Other
  // rows without one have 1 on the border of the mesh, as in Triangle and TetGen, else 0. Empty if
  // the input has no markers, unless replace_ids.
  std::vector<std::int64_t> vertex_markers, edge_markers, face_markers;
  std::size_t attributes = 0;                 // of a vertex
  std::vector<double> vertex_values;          // `attributes` each
  std::map<double, std::string> value_names;  // of values below
  std::vector<double> simplex_values;         // the attribute of a simplex's region

  // The name of a feature; empty if it has none.
  std::string NameOf(FeatureId id) const { return features ? features->NameOf(id) : ""; }
};

// Fills `features`, `replace_ids` and the columns of markers. O(mesh) expected.
void LabelRows(std::shared_ptr<const FeatureLabels> features, bool replace_ids, IndexedMesh& mesh);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_ROW_LABELS_H_
