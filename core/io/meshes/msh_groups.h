// The physical groups of a `.msh`: their numbers and names, from references, regions and labels.
//
// Features of one name are one group. If the labels replace ids, a group is a marker of the input
// or the attribute of a region; what has the marker 0 is in no group.
// Regions whose simplices have an attribute with a name have that name. Immutable.
#ifndef DYNMESH_CORE_IO_MESHES_MSH_GROUPS_H_
#define DYNMESH_CORE_IO_MESHES_MSH_GROUPS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/meshes/indexed_mesh.h"
#include "core/io/meshes/references.h"

namespace dynmesh::io {

class MshGroups {
 public:
  // Both must outlive it. O(n lg n).
  MshGroups(const IndexedMesh& mesh, const References& references);

  // Of a feature's reference or the box's; 0: none.
  int Of(int reference) const { return group_of_[static_cast<std::size_t>(reference)]; }
  // REQUIRES: Of(reference) is not 0.
  std::string Name(int reference) const;
  // Of the simplices in a region's number.
  int OfRegion(std::uint32_t region) const { return group_of_region_[region]; }
  std::string NameOfRegion(std::uint32_t region) const;

 private:
  void NumberRegions();
  FeatureId FeatureOf(int reference) const;

  const IndexedMesh& mesh_;
  const References& references_;
  std::vector<int> group_of_;  // by reference
  std::vector<int> group_of_region_;
  std::vector<std::string> name_of_region_;  // of its attribute; empty: none
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_MSH_GROUPS_H_
