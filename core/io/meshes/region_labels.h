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

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/io/common/feature_labels.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

struct RegionLabel {
  FeatureId polygon = kNoFeature;  // whose own region it is; kNoFeature if there is none
  std::int64_t marker = 0;         // 0: none
  std::string name;                // empty: none
};

// What labels of regions follow from, of a mesh in any form.
struct RegionScene {
  // A facet of a feature: an edge, in 3D a face.
  struct Facet {
    FeatureId owner;
    std::array<std::uint32_t, 2> regions;  // of both sides; 0: of none, or beyond the mesh
  };
  int dimension = 2;
  std::span<const std::vector<FeatureId>> polygons;  // of regions 1, 2, ...; ascending
  std::vector<Facet> facets;                         // in 2D their regions are not looked at
};

// By the number of the region, from 0. O(n lg n) for n facets and polygons of regions.
std::vector<RegionLabel> RegionLabelsOf(const RegionScene& scene, const FeatureLabels& labels);

// By the number of the region, from 0. All are empty if the features of `mesh` have no labels.
// O(mesh) expected.
std::vector<RegionLabel> RegionLabelsOf(const IndexedMesh& mesh);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_REGION_LABELS_H_
