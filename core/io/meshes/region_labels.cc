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
std::map<FeatureId, Polygons> OwnRegions(const RegionNumbers& regions) {
  std::map<FeatureId, Polygons> own;
  for (const Polygons& row : regions.polygons) {
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

std::set<FeatureId> OwnersOf(const IndexedMesh& mesh) {
  std::set<FeatureId> owners;
  for (const auto& edge : mesh.edges) owners.insert(edge.owner);
  for (const auto& face : mesh.faces) owners.insert(face.owner);
  return owners;
}

// The polygon of each region's number, or none. In a part of a mesh two polygons may lie around the
// same simplices; then the one that has an edge or a face there is meant, if it is the only one.
std::vector<FeatureId> PolygonsOfRegions(const IndexedMesh& mesh) {
  const std::map<FeatureId, Polygons> own = OwnRegions(mesh.regions);
  const std::set<FeatureId> owners = OwnersOf(mesh);
  std::vector<FeatureId> result = {kNoFeature};
  for (const Polygons& row : mesh.regions.polygons) {
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
std::map<FeatureId, std::set<std::string>> NamesOnSurfaces(const IndexedMesh& mesh) {
  using Key = std::array<std::uint32_t, 3>;
  absl::flat_hash_map<Key, std::size_t> row_of;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) row_of.emplace(mesh.faces[i].corners, i);
  // Of both sides; 0 is outside of all surfaces or of the mesh.
  std::vector<std::array<std::uint32_t, 2>> sides(mesh.faces.size());
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    for (const auto& side : kTetrahedronSides) {
      Key key;
      for (std::size_t k = 0; k < 3; ++k) key[k] = mesh.tetrahedra[i][side[k]];
      std::sort(key.begin(), key.end());
      const auto at = row_of.find(key);
      if (at == row_of.end()) continue;
      auto& [first, second] = sides[at->second];
      (first == 0 ? first : second) = mesh.regions.Of(i);
    }
  }
  const Polygons none;
  std::map<FeatureId, std::set<std::string>> names;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const FeatureId owner = mesh.faces[i].owner;
    if (owner == kNoFeature || owner == kBoxFeature) continue;
    const auto polygons_of = [&](std::uint32_t region) -> const Polygons& {
      return region == 0 ? none : mesh.regions.polygons[region - 1];
    };
    const Polygons &first = polygons_of(sides[i][0]), &second = polygons_of(sides[i][1]);
    Polygons surfaces;
    std::set_symmetric_difference(first.begin(), first.end(), second.begin(), second.end(),
                                  std::back_inserter(surfaces));
    for (const FeatureId surface : surfaces) names[surface].insert(mesh.labels.NameOf(owner));
  }
  return names;
}

}  // namespace

std::vector<RegionLabel> RegionLabelsOf(const IndexedMesh& mesh) {
  std::vector<RegionLabel> result(mesh.regions.count() + 1);
  if (mesh.labels.features == nullptr || mesh.regions.count() == 0) return result;
  const FeatureLabels& features = *mesh.labels.features;
  if (features.markers.empty() && features.names.empty()) return result;
  const std::vector<FeatureId> polygons = PolygonsOfRegions(mesh);
  std::map<FeatureId, std::set<std::string>> names;
  if (mesh.dimension == 3 && !features.names.empty()) names = NamesOnSurfaces(mesh);
  for (std::size_t k = 1; k < result.size(); ++k) {
    RegionLabel& label = result[k];
    label.polygon = polygons[k];
    if (label.polygon == kNoFeature) continue;
    label.marker = features.MarkerOf(label.polygon);
    const std::string name = features.NameOf(label.polygon);
    const bool is_of_all = mesh.dimension == 2 || names[label.polygon] == std::set{name};
    if (is_of_all) label.name = name;
  }
  return result;
}

}  // namespace dynmesh::io
