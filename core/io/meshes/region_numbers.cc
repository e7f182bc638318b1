#include "core/io/meshes/region_numbers.h"

#include <algorithm>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/base/text.h"
#include "core/mesh_data/regions.h"

namespace dynmesh::io {

using text::Concat;

std::string RegionNumbers::Name(std::uint32_t number) const {
  if (number == 0) return "domain";
  const std::vector<FeatureId>& row = polygons[number - 1];
  return Concat(row.size() == 1 ? "polygon " : "polygons ", FormatPolygons(row));
}

RegionNumbers NumberRegions(const Mesh& mesh) {
  absl::flat_hash_map<RegionId, std::uint32_t> number_of;
  for (const RegionId region : mesh.regions) {
    if (region != kNoRegion) number_of.emplace(region, 0);
  }
  RegionNumbers result;
  if (number_of.empty()) return result;
  std::vector<std::pair<std::vector<FeatureId>, RegionId>> rows;
  for (const auto& [region, number] : number_of) {
    rows.emplace_back(PolygonsOf(region, mesh.region_sets), region);
  }
  std::sort(rows.begin(), rows.end());
  for (auto& [polygons, region] : rows) {
    // Only a damaged mesh has two ids for the same polygons.
    if (result.polygons.empty() || result.polygons.back() != polygons) {
      result.polygons.push_back(std::move(polygons));
    }
    number_of[region] = static_cast<std::uint32_t>(result.polygons.size());
  }
  result.numbers.reserve(mesh.regions.size());
  number_of[kNoRegion] = 0;
  for (const RegionId region : mesh.regions) result.numbers.push_back(number_of[region]);
  return result;
}

void SetRegions(const RegionNumbers& regions, Mesh& mesh) {
  mesh.regions.clear();
  mesh.region_sets.clear();
  std::vector<RegionId> id_of = {kNoRegion};
  for (const std::vector<FeatureId>& row : regions.polygons) {
    id_of.push_back(row.size() == 1 ? row.front() : RegionIdOf(row));
  }
  for (const std::uint32_t number : regions.numbers) mesh.regions.push_back(id_of[number]);
  for (std::size_t k = 1; k < id_of.size(); ++k) {
    const std::vector<FeatureId>& row = regions.polygons[k - 1];
    if (row.size() > 1) mesh.region_sets.push_back({id_of[k], row});
  }
  mesh_data::DropIfIdle(mesh.regions);
  mesh_data::KeepNamed(mesh.region_sets, {&mesh.regions});
}

std::string FormatPolygons(std::span<const FeatureId> polygons) {
  std::string text;
  for (const FeatureId id : polygons) text += Concat(text.empty() ? "" : " ", id);
  return text;
}

}  // namespace dynmesh::io
