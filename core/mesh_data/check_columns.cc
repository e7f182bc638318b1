#include "core/mesh_data/check_columns.h"

#include <cstddef>
#include <string_view>
#include <vector>

#include "core/base/text.h"
#include "core/mesh_data/constraints.h"
#include "core/mesh_data/labels.h"
#include "core/mesh_data/regions.h"

namespace dynmesh::mesh_data {
namespace {

bool Agree(int dimension, const VertexColumns& v) {
  const std::size_t n = v.ids.size();
  return v.coordinates.size() == n * static_cast<std::size_t>(dimension) &&
         v.containing_dimensions.size() == n && v.owners.size() == n;
}

bool Agree(int dimension, const SimplexColumn& s, const RegionColumn& regions) {
  const std::size_t corners = static_cast<std::size_t>(dimension) + 1;
  return s.size() % corners == 0 && (regions.empty() || regions.size() == s.size() / corners);
}

absl::Status BadColumns(std::string_view what) {
  return absl::InvalidArgumentError(text::Concat("the columns of ", what, " disagree in length"));
}

absl::Status CheckSets(const std::vector<RegionSet>& sets) {
  if (AreRegionSets(sets)) return absl::OkStatus();
  return absl::InvalidArgumentError("a region set is not what its id says, or out of order");
}

absl::Status BadLabels() {
  return absl::InvalidArgumentError("labels do not ascend by id, or are empty in a mesh");
}

absl::Status CheckDimension(int dimension) {
  if (dimension == 2 || dimension == 3) return absl::OkStatus();
  return absl::InvalidArgumentError(text::Concat("dimension ", dimension, " is neither 2 nor 3"));
}

}  // namespace

absl::Status CheckColumns(const Mesh& mesh) {
  if (auto status = CheckDimension(mesh.dimension); !status.ok()) return status;
  if (!Agree(mesh.dimension, mesh.vertices)) return BadColumns("vertices");
  if (!Agree(mesh.dimension, mesh.simplices, mesh.regions)) return BadColumns("simplices");
  if (!Agree(mesh.subsegments)) return BadColumns("subsegments");
  if (!Agree(mesh.subfacets)) return BadColumns("subfacets");
  if (!AreLabelsOfMesh(mesh.labels)) return BadLabels();
  return CheckSets(mesh.region_sets);
}

absl::Status CheckColumns(const MeshDiff& diff) {
  if (auto status = CheckDimension(diff.dimension); !status.ok()) return status;
  if (!Agree(diff.dimension, diff.added_vertices)) return BadColumns("added vertices");
  if (!Agree(diff.dimension, diff.added_simplices, diff.added_regions)) {
    return BadColumns("added simplices");
  }
  if (!Agree(diff.dimension, diff.removed_simplices, diff.removed_regions)) {
    return BadColumns("removed simplices");
  }
  if (!Agree(diff.added_subsegments)) return BadColumns("added subsegments");
  if (!Agree(diff.removed_subsegments)) return BadColumns("removed subsegments");
  if (!Agree(diff.added_subfacets)) return BadColumns("added subfacets");
  if (!Agree(diff.removed_subfacets)) return BadColumns("removed subfacets");
  if (!AreLabels(diff.labels)) return BadLabels();
  return CheckSets(diff.region_sets);
}

}  // namespace dynmesh::mesh_data
