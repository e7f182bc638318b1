// The physical groups of a `.msh`: their numbers and names, from references, regions and labels.
//
// Features of one name are one group, and so are regions of one name (region_labels.h). If the
// labels replace ids, a group is a marker of the input, of a region that of its polygon or its
// attribute; features with the marker 0 are in no group, regions without one have numbers that no
// marker has.
//
// Readers that look groups up by name take one of each name. So a name belongs to one group: of
// several dimensions to that of the highest, as a region's. The others have " faces", " edges" or
// " points" behind the name; of one dimension, the later ones their number. Immutable.
#ifndef DYNMESH_CORE_IO_MESHES_MSH_GROUPS_H_
#define DYNMESH_CORE_IO_MESHES_MSH_GROUPS_H_

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
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
  // Of the simplices in a region's number.
  int OfRegion(std::uint32_t region) const { return group_of_region_[region]; }

  // The names of the groups in use, by dimension and number. `features`: the references of each
  // dimension below the mesh's; `regions`: those in use. A name too long for the format is replaced
  // by "region 3", and comes with it in `long_names`.
  std::map<std::pair<int, int>, std::string> Names(
      const std::array<std::set<int>, 3>& features, const std::set<std::uint32_t>& regions,
      std::vector<std::pair<std::string, std::string>>& long_names) const;

 private:
  void NumberRegions();
  std::vector<int> MarkersOfRegions();
  FeatureId FeatureOf(int reference) const;
  std::string NameOf(int reference) const;
  std::string NameOfRegion(std::uint32_t region) const;

  const IndexedMesh& mesh_;
  const References& references_;
  std::vector<int> group_of_;  // by reference
  std::vector<int> group_of_region_;
  std::vector<std::string> name_of_region_;  // of its attribute or polygon; empty: none
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_MSH_GROUPS_H_
