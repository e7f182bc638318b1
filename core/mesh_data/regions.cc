#include "core/mesh_data/regions.h"

#include <algorithm>
#include <functional>

namespace dynmesh::mesh_data {

void DropIfIdle(RegionColumn& regions) {
  const auto says = [](RegionId region) { return region != kNoRegion; };
  if (std::none_of(regions.begin(), regions.end(), says)) RegionColumn().swap(regions);
}

void KeepNamed(std::vector<RegionSet>& sets, std::initializer_list<const RegionColumn*> columns) {
  if (sets.empty()) return;
  std::ranges::stable_sort(sets, {}, &RegionSet::id);
  const auto same_id = [](const RegionSet& a, const RegionSet& b) { return a.id == b.id; };
  sets.erase(std::unique(sets.begin(), sets.end(), same_id), sets.end());
  std::vector<bool> named(sets.size());
  for (const RegionColumn* column : columns) {
    RegionId last = kNoRegion;  // adjacent simplices often share it
    for (const RegionId region : *column) {
      if (region == last) continue;
      last = region;
      const auto it = std::ranges::lower_bound(sets, region, {}, &RegionSet::id);
      if (it != sets.end() && it->id == region) {
        named[static_cast<std::size_t>(it - sets.begin())] = true;
      }
    }
  }
  std::size_t row = 0;
  std::erase_if(sets, [&](const RegionSet&) { return !named[row++]; });
}

void AppendSets(std::vector<RegionSet>& to, const std::vector<RegionSet>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

bool IsRegionSet(const RegionSet& set) {
  const std::vector<FeatureId>& p = set.polygons;
  const bool ascend = std::ranges::adjacent_find(p, std::ranges::greater_equal()) == p.end();
  return p.size() >= 2 && ascend && p.front() != kNoFeature && p.back() != kBoxFeature &&
         set.id == RegionIdOf(p);
}

bool AreRegionSets(const std::vector<RegionSet>& sets) {
  return std::ranges::all_of(sets, IsRegionSet) &&
         std::ranges::adjacent_find(sets, std::ranges::greater_equal(), &RegionSet::id) ==
             sets.end();
}

std::size_t ByteSize(const std::vector<RegionSet>& sets) {
  std::size_t bytes = 0;
  for (const RegionSet& set : sets) {
    bytes += sizeof(RegionSet) + set.polygons.size() * sizeof(FeatureId);
  }
  return bytes;
}

}  // namespace dynmesh::mesh_data
