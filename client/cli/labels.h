// Labels of what a command writes: markers, names and attributes of the input.
#ifndef DYNMESH_CLIENT_CLI_LABELS_H_
#define DYNMESH_CLIENT_CLI_LABELS_H_

#include <memory>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "core/io/common/feature_labels.h"
#include "core/io/common/triangle_sections.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::cli {

struct MeshLabels {
  std::shared_ptr<const io::FeatureLabels> features;  // null: nothing is known
  std::vector<io::SeedRow> regions;                   // whose attributes simplices get
  std::vector<io::SeedRow> holes;                     // of .poly and .smesh
  bool is_part = false;                               // the mesh does not fill its box
  bool replace_ids = false;                           // --markers input
  bool steiner_ids = false;                           // --markers owners
};

// --markers
void AddMarkersFlag(CLI::App& command, std::string& text);
// INVALID_ARGUMENT unless it is "ids", "owners", "input" or empty (ids).
absl::Status ParseMarkersFlag(const std::string& text, MeshLabels& labels);

// Labels the rows of `mesh`, the whole mesh or a part of it. Attributes of points are interpolated:
// linearly along segments, then linearly in the Delaunay triangulation of all vertices with known
// values. O(mesh lg mesh) if there are attributes, else O(mesh).
void ApplyLabels(const MeshLabels& labels, io::IndexedMesh& mesh);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_LABELS_H_
