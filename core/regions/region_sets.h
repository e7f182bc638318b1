// Sets of polygons by their ids (mesh.h, RegionId): the region of a simplex, and the owners of a
// wall.
//
// Ids are hashes, and clients choose polygons' ids: two sets may have the same id. Then one of them
// gets another number here, so that labels stay correct, and `collision` reports it: a mesh made of
// these labels must not be returned. Thread-compatible; even const members must not run
// concurrently. O(1) expected.
#ifndef DYNMESH_CORE_REGIONS_REGION_SETS_H_
#define DYNMESH_CORE_REGIONS_REGION_SETS_H_

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/hash/hash.h"
#include "core/regions/region_terms.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

class RegionSets {
 public:
  // The tag of a finite simplex without a label; not a region's id.
  static constexpr RegionId kPending = ~RegionId{0};
  // The result of Toggle for more than kMostPolygonsAtAPlace polygons; not a region's id.
  static constexpr RegionId kTooMany = ~RegionId{0} - 1;

  // REQUIRES: `polygons` ascend.
  RegionId Add(std::span<const FeatureId> polygons) {
    const RegionId id = RegionIdOf(polygons);
    if (polygons.size() < 2 || Enter(id, polygons)) return id;
    return AddElsewhere(id, polygons);
  }
  // The polygons in exactly one of the two sets. If these are too many the set is not kept, except
  // the least such set in lexicographic order (`overfull`). REQUIRES: `a` is not kTooMany.
  RegionId Toggle(RegionId a, RegionId b) {
    if (b == kNoRegion) return a;
    if (a == kNoRegion) return Checked(b);
    if (!IsOn(RegionTerm::kHolesAreOutside) && a == b) return a;
    if (a == b) return kNoRegion;
    const std::pair<RegionId, RegionId> key = std::minmax(a, b);
    const auto known = toggles_.find(key);
    if (known != toggles_.end()) return known->second;
    std::vector<FeatureId> polygons;
    const std::vector<FeatureId> of_a = PolygonsOf(a), of_b = PolygonsOf(b);
    std::set_symmetric_difference(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                                  std::back_inserter(polygons));
    if (polygons.size() <= kMostPolygonsAtAPlace) return toggles_[key] = Add(polygons);
    return toggles_[key] = Refuse(polygons);
  }
  // Empty if no set was too large.
  std::span<const FeatureId> overfull() const { return overfull_; }

  using Polygons = std::vector<FeatureId>;
  struct Collision {
    Polygons first, second;  // no second: the id of the first is reserved
  };
  // Two added sets with the same id: the least such id, the first two sets. A function of the sets.
  std::optional<Collision> collision() const {
    for (const auto& [id, sets] : collided_) {
      if (sets.size() > 1) return Collision{*sets.begin(), *std::next(sets.begin())};
      if (id >= kTooMany) return Collision{*sets.begin(), {}};
    }
    return std::nullopt;
  }
  std::vector<FeatureId> PolygonsOf(RegionId id) const {
    const auto it = sets_.find(id);
    return it != sets_.end() ? it->second : std::vector<FeatureId>{id};
  }
  // The sets of several polygons among `ids`, by ascending id. Sorts `ids`.
  std::vector<RegionSet> SetsOf(std::vector<RegionId>* ids) const {
    std::sort(ids->begin(), ids->end());
    ids->erase(std::unique(ids->begin(), ids->end()), ids->end());
    std::vector<RegionSet> sets;
    for (const RegionId id : *ids) {
      const auto it = sets_.find(id);
      if (it != sets_.end()) sets.push_back({id, it->second});
    }
    return sets;
  }

  // Drops the sets with ids not among `used`.
  template <class Ids>
  void Keep(const Ids& used) {
    toggles_.clear();
    absl::erase_if(sets_, [&](const auto& set) { return !used.contains(set.first); });
  }
  std::size_t size() const { return sets_.size() + toggles_.size(); }

 private:
  static constexpr RegionId kFirstSetId = kLastPolygonId + 1;

  // Is the number now that of these polygons?
  bool Enter(RegionId number, std::span<const FeatureId> polygons) {
    if (number >= kTooMany) return false;
    const auto [it, is_new] = sets_.try_emplace(number, polygons.begin(), polygons.end());
    return is_new || std::ranges::equal(it->second, polygons);
  }
  RegionId AddElsewhere(RegionId id, std::span<const FeatureId> polygons) {
    Polygons set(polygons.begin(), polygons.end());
    const auto it = sets_.find(id);
    // Otherwise it has that number because of another collision.
    if (it != sets_.end() && RegionIdOf(it->second) == id) collided_[id].insert(it->second);
    RegionId number = absl::HashOf(set) | kFirstSetId;
    while (!Enter(number, polygons)) number = (number + 1) | kFirstSetId;
    collided_[id].insert(std::move(set));
    return number;
  }
  RegionId Checked(RegionId id) {
    const auto it = sets_.find(id);
    return it == sets_.end() || it->second.size() <= kMostPolygonsAtAPlace ? id
                                                                           : Refuse(it->second);
  }
  RegionId Refuse(const std::vector<FeatureId>& polygons) {
    if (overfull_.empty() || polygons < overfull_) overfull_ = polygons;
    return kTooMany;
  }

  absl::flat_hash_map<RegionId, std::vector<FeatureId>> sets_;  // of several polygons
  absl::flat_hash_map<std::pair<RegionId, RegionId>, RegionId> toggles_;
  std::vector<FeatureId> overfull_;
  std::map<RegionId, std::set<Polygons>> collided_;  // by the id of RegionIdOf
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_REGIONS_REGION_SETS_H_
