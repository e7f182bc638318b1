// The labels of regions: markers and names that simplices get from the polygons they lie in.
//
// A polygon's *own* region is the one that lies in nothing that the polygon does not lie in, too:
// the intersection of all regions in it. So of a plate with an island the plate's own region is
// what is beside the island, and the island's is the island. Where polygons overlap, the overlap is
// no polygon's own.
//
// A region has the marker and the name of the polygon whose own it is. In 3D that is the polygon
// that names the surface (dynmesh/mesh.h). There polygons are faces, so the name counts only if all
// polygons of the surface have it: a room whose bottom is named is not called bottom.
#ifndef DYNMESH_CORE_IO_MESHES_REGION_LABELS_H_
#define DYNMESH_CORE_IO_MESHES_REGION_LABELS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

struct RegionLabel {
  FeatureId polygon = kNoFeature;  // whose own region it is; kNoFeature if there is none
  std::int64_t marker = 0;         // 0: none
  std::string name;                // empty: none
};

// By the number of the region, from 0. All are empty if the features of `mesh` have no labels.
// O(mesh) expected.
std::vector<RegionLabel> RegionLabelsOf(const IndexedMesh& mesh);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_REGION_LABELS_H_
