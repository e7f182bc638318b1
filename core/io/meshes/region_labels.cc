#include "core/io/meshes/region_labels.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <map>
#include <set>

#include "absl/container/flat_hash_map.h"
#include "core/io/meshes/tetrahedron_sides.h"

namespace dynmesh::io {
namespace {

using Polygons = std::vector<FeatureId>;

// The region of each polygon: what all regions in it have in common.
std::map<FeatureId, Polygons> OwnRegions(std::span<const Polygons> regions) {
  std::map<FeatureId, Polygons> own;
  for (const Polygons& row : regions) {
    for (const FeatureId polygon : row) {
      const auto [at, is_new] = own.try_emplace(polygon, row);
      if (is_new) continue;
      Polygons common;
      std::set_intersection(at->second.begin(), at->second.end(), row.begin(), row.end(),
                            std::back_inserter(common));
      at->second = std::move(common);
    }
  }
  return own;
}

// The polygon of each region's number, or none. In a part of a mesh two polygons may lie around the
// same simplices; then the one that has a facet there is meant, if it is the only one.
std::vector<FeatureId> PolygonsOfRegions(const RegionScene& scene) {
  const std::map<FeatureId, Polygons> own = OwnRegions(scene.polygons);
  std::set<FeatureId> owners;
  for (const auto& facet : scene.facets) owners.insert(facet.owner);
  std::vector<FeatureId> result = {kNoFeature};
  for (const Polygons& row : scene.polygons) {
    Polygons candidates;
    for (const FeatureId polygon : row) {
      if (own.at(polygon) == row) candidates.push_back(polygon);
    }
    if (candidates.size() > 1) {
      std::erase_if(candidates, [&](FeatureId polygon) { return !owners.contains(polygon); });
    }
    result.push_back(candidates.size() == 1 ? candidates.front() : kNoFeature);
  }
  return result;
}

// 3D: the names of the polygons of each surface. A face is part of the surfaces that only one of
// its sides is inside of.
std::map<FeatureId, std::set<std::string>> NamesOnSurfaces(const RegionScene& scene,
                                                           const FeatureLabels& labels) {
  const Polygons none;
  const auto polygons_of = [&](std::uint32_t region) -> const Polygons& {
    return region == 0 ? none : scene.polygons[region - 1];
  };
  std::map<FeatureId, std::set<std::string>> names;
  for (const auto& facet : scene.facets) {
    if (facet.owner == kNoFeature || facet.owner == kBoxFeature) continue;
    const Polygons& first = polygons_of(facet.regions[0]);
    const Polygons& second = polygons_of(facet.regions[1]);
    Polygons surfaces;
    std::set_symmetric_difference(first.begin(), first.end(), second.begin(), second.end(),
                                  std::back_inserter(surfaces));
    for (const FeatureId surface : surfaces) names[surface].insert(labels.NameOf(facet.owner));
  }
  return names;
}

std::vector<RegionScene::Facet> EdgesOf(const IndexedMesh& mesh) {
  std::vector<RegionScene::Facet> facets;
  for (const auto& edge : mesh.edges) facets.push_back({edge.owner, {0, 0}});
  return facets;
}

std::vector<RegionScene::Facet> FacesOf(const IndexedMesh& mesh) {
  using Key = std::array<std::uint32_t, 3>;
  absl::flat_hash_map<Key, std::size_t> row_of;
  std::vector<RegionScene::Facet> facets;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    row_of.emplace(mesh.faces[i].corners, i);
    facets.push_back({mesh.faces[i].owner, {0, 0}});
  }
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    for (const auto& side : kTetrahedronSides) {
      Key key;
      for (std::size_t k = 0; k < 3; ++k) key[k] = mesh.tetrahedra[i][side[k]];
      std::sort(key.begin(), key.end());
      const auto at = row_of.find(key);
      if (at == row_of.end()) continue;
      auto& [first, second] = facets[at->second].regions;
      (first == 0 ? first : second) = mesh.regions.Of(i);
    }
  }
  return facets;
}

}  // namespace

std::vector<RegionLabel> RegionLabelsOf(const RegionScene& scene, const FeatureLabels& labels) {
  std::vector<RegionLabel> result(scene.polygons.size() + 1);
  if (scene.polygons.empty() || (labels.markers.empty() && labels.names.empty())) return result;
  const std::vector<FeatureId> polygons = PolygonsOfRegions(scene);
  std::map<FeatureId, std::set<std::string>> names;
  if (scene.dimension == 3 && !labels.names.empty()) names = NamesOnSurfaces(scene, labels);
  for (std::size_t k = 1; k < result.size(); ++k) {
    RegionLabel& label = result[k];
    label.polygon = polygons[k];
    if (label.polygon == kNoFeature) continue;
    label.marker = labels.MarkerOf(label.polygon);
    const std::string name = labels.NameOf(label.polygon);
    const bool is_of_all = scene.dimension == 2 || names[label.polygon] == std::set{name};
    if (is_of_all) label.name = name;
  }
  return result;
}

std::vector<RegionLabel> RegionLabelsOf(const IndexedMesh& mesh) {
  if (mesh.labels.features == nullptr || mesh.regions.count() == 0) {
    return std::vector<RegionLabel>(mesh.regions.count() + 1);
  }
  RegionScene scene;
  scene.dimension = mesh.dimension;
  scene.polygons = mesh.regions.polygons;
  scene.facets = mesh.dimension == 2 ? EdgesOf(mesh) : FacesOf(mesh);
  return RegionLabelsOf(scene, *mesh.labels.features);
}

}  // namespace dynmesh::io
