#include "core/regions/surface_table.h"

#include <algorithm>
#include <utility>

#include "core/base/rings.h"
#include "core/plc/facet.h"
#include "core/plc/facet_parts.h"
#include "core/regions/region_terms.h"

namespace dynmesh {

namespace {

// Finds `id` in a list sorted by id; null if absent.
const plc::FacetFeature* Find(std::span<const plc::FacetFeature> sorted, FeatureId id) {
  const auto it =
      std::lower_bound(sorted.begin(), sorted.end(), id,
                       [](const plc::FacetFeature& f, FeatureId i) { return f.id < i; });
  return it != sorted.end() && it->id == id ? &*it : nullptr;
}

bool IsApart(const plc::FacetFeature& polygon) {
  return polygon.rings.size() > 1 && IsOn(RegionTerm::kApartIsNone) &&
         plc::FallsApart(plc::Facet(polygon));
}

}  // namespace

const std::vector<SurfaceTable::Change>& SurfaceTable::Update(
    std::span<const plc::FacetFeature> removed, std::span<const plc::FacetFeature> added,
    absl::FunctionRef<geometry::Point3(FeatureId)> position_of) {
  changes_.clear();
  seeds_.clear();
  const auto seed = [this](FeatureId p, FeatureId q) { seeds_.push_back(plc::KeyOf(p, q)); };
  // A polygon that only moves is in both lists with the same rings, but may fall apart now.
  const auto is_same = [](const plc::FacetFeature& f, std::span<const plc::FacetFeature> others) {
    const plc::FacetFeature* other = Find(others, f.id);
    return other != nullptr && other->rings == f.rings;
  };
  for (const plc::FacetFeature& f : removed) {
    if (!is_same(f, added)) {
      Remove(f);
      ForEachEdgeOf(f.rings, seed);
      continue;
    }
    Polygon& polygon = polygons_.at(f.id);
    const bool was_apart = std::exchange(polygon.is_apart, IsApart(*Find(added, f.id)));
    if (polygon.is_crowded || polygon.is_apart != was_apart) ForEachEdgeOf(f.rings, seed);
  }
  for (const plc::FacetFeature& f : added) {
    if (is_same(f, removed)) continue;
    Add(f);
    ForEachEdgeOf(f.rings, seed);
  }
  if (seeds_.empty()) return changes_;
  CollectTouched();
  Peel();
  FindComponents(position_of);
  for (auto& [id, touched] : touched_) {
    Polygon& polygon = polygons_.at(id);
    if (polygon.surfaces != touched.surfaces && Find(added, id) == nullptr) {
      changes_.push_back({id, polygon.surfaces, touched.surfaces});
    }
    polygon.surfaces = std::move(touched.surfaces);
    polygon.is_crowded = touched.is_crowded;
  }
  std::sort(changes_.begin(), changes_.end(),
            [](const Change& a, const Change& b) { return a.polygon < b.polygon; });
  return changes_;
}

void SurfaceTable::Remove(const plc::FacetFeature& polygon) {
  ForEachEdgeOf(polygon.rings, [&](FeatureId p, FeatureId q) {
    const auto at = edges_.find(plc::KeyOf(p, q));
    at->second.erase(std::find(at->second.begin(), at->second.end(), polygon.id));
    if (at->second.empty()) edges_.erase(at);
  });
  polygons_.erase(polygon.id);
}

void SurfaceTable::Add(const plc::FacetFeature& polygon) {
  Polygon& added = polygons_[polygon.id];
  added.rings = polygon.rings;
  added.is_apart = IsApart(polygon);
  ForEachEdgeOf(polygon.rings,
                [&](FeatureId p, FeatureId q) { edges_[plc::KeyOf(p, q)].push_back(polygon.id); });
}

// Collects all polygons connected with a changed edge.
void SurfaceTable::CollectTouched() {
  touched_.clear();
  stack_.clear();
  const auto reach = [&](const plc::EdgeKey& edge) {
    const auto it = edges_.find(edge);
    if (it == edges_.end()) return;
    for (const FeatureId id : it->second) {
      if (touched_.try_emplace(id).second) stack_.push_back(id);
    }
  };
  for (const plc::EdgeKey& edge : seeds_) reach(edge);
  while (!stack_.empty()) {
    const FeatureId id = stack_.back();
    stack_.pop_back();
    ForEachEdgeOf(polygons_.at(id).rings,
                  [&](FeatureId p, FeatureId q) { reach(plc::KeyOf(p, q)); });
  }
}

// The result does not depend on the order in which polygons are removed.
void SurfaceTable::Peel() {
  absl::flat_hash_map<plc::EdgeKey, std::size_t> left;  // polygons left at an edge
  const auto has_lone_edge = [&](FeatureId id) {
    bool found = false;
    ForEachEdgeOf(polygons_.at(id).rings, [&](FeatureId p, FeatureId q) {
      found = found || left.at(plc::KeyOf(p, q)) == 1;
    });
    return found;
  };
  for (auto& [id, touched] : touched_) {
    const Polygon& polygon = polygons_.at(id);
    touched.peeled = polygon.is_apart;
    ForEachEdgeOf(polygon.rings, [&](FeatureId p, FeatureId q) {
      left[plc::KeyOf(p, q)] += polygon.is_apart ? 0 : 1;
    });
  }
  stack_.clear();
  const auto peel = [&](FeatureId id) {
    Touched& touched = touched_.at(id);
    if (touched.peeled || !has_lone_edge(id) || !IsOn(RegionTerm::kOpenIsPeeled)) return;
    touched.peeled = true;
    stack_.push_back(id);
  };
  for (const auto& [id, touched] : touched_) peel(id);
  while (!stack_.empty()) {
    const FeatureId id = stack_.back();
    stack_.pop_back();
    ForEachEdgeOf(polygons_.at(id).rings, [&](FeatureId p, FeatureId q) {
      const plc::EdgeKey edge = plc::KeyOf(p, q);
      if (--left.at(edge) != 1) return;
      for (const FeatureId other : edges_.at(edge)) peel(other);
    });
  }
}

void SurfaceTable::FindComponents(absl::FunctionRef<geometry::Point3(FeatureId)> position_of) {
  std::vector<FeatureId> component;
  for (auto& [first, start] : touched_) {
    if (start.peeled || start.reached) continue;
    start.reached = true;
    component.assign(1, first);
    bool is_crowded = false;
    for (std::size_t i = 0; i < component.size(); ++i) {
      ForEachEdgeOf(polygons_.at(component[i]).rings, [&](FeatureId p, FeatureId q) {
        std::size_t count = 0;
        for (const FeatureId id : edges_.at(plc::KeyOf(p, q))) {
          Touched& other = touched_.at(id);
          if (other.peeled) continue;
          ++count;
          if (!std::exchange(other.reached, true)) component.push_back(id);
        }
        is_crowded = is_crowded || (count > 2 && IsOn(RegionTerm::kCrowdedIsSearched));
      });
    }
    std::sort(component.begin(), component.end());
    if (!is_crowded) {
      for (const FeatureId id : component) touched_.at(id).surfaces = {component.front()};
      continue;
    }
    std::vector<plc::Facet> facets;
    for (const FeatureId id : component) {
      const Rings& rings = polygons_.at(id).rings;
      plc::FacetFeature feature{id, rings, {}};
      for (const auto& ring : rings) {
        auto& positions = feature.positions.emplace_back();
        for (const FeatureId corner : ring) positions.push_back(position_of(corner));
      }
      facets.emplace_back(std::move(feature));
    }
    std::vector<SurfaceIds> surfaces = FindSurfaces(facets);
    for (std::size_t i = 0; i < component.size(); ++i) {
      Touched& touched = touched_.at(component[i]);
      touched.surfaces = std::move(surfaces[i]);
      touched.is_crowded = true;
    }
  }
}

}  // namespace dynmesh
