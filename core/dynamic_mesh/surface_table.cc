#include "core/dynamic_mesh/surface_table.h"

#include <algorithm>

namespace dynmesh {

namespace {

// Of a list sorted by id, or null.
const plc::FacetFeature* Find(std::span<const plc::FacetFeature> sorted, FeatureId id) {
  const auto it =
      std::lower_bound(sorted.begin(), sorted.end(), id,
                       [](const plc::FacetFeature& f, FeatureId i) { return f.id < i; });
  return it != sorted.end() && it->id == id ? &*it : nullptr;
}

}  // namespace

const std::vector<SurfaceTable::Change>& SurfaceTable::Update(
    std::span<const plc::FacetFeature> removed, std::span<const plc::FacetFeature> added) {
  changes_.clear();
  seeds_.clear();
  // A polygon that only moves stands in both lists with the same rings.
  const auto is_same = [](const plc::FacetFeature& f, std::span<const plc::FacetFeature> others) {
    const plc::FacetFeature* other = Find(others, f.id);
    return other != nullptr && other->rings == f.rings;
  };
  for (const plc::FacetFeature& f : removed) {
    if (!is_same(f, added)) Remove(f);
  }
  for (const plc::FacetFeature& f : added) {
    if (!is_same(f, removed)) Add(f);
  }
  if (seeds_.empty()) return changes_;
  CollectTouched();
  Peel();
  FindSurfaces();
  for (const auto& [id, touched] : touched_) {
    FeatureId& surface = polygons_.at(id).surface;
    if (surface != touched.surface && Find(added, id) == nullptr) {
      changes_.push_back({id, surface, touched.surface});
    }
    surface = touched.surface;
  }
  std::sort(changes_.begin(), changes_.end(),
            [](const Change& a, const Change& b) { return a.polygon < b.polygon; });
  return changes_;
}

void SurfaceTable::Remove(const plc::FacetFeature& polygon) {
  const auto it = polygons_.find(polygon.id);
  for (const plc::EdgeKey& edge : it->second.edges) {
    const auto at = edges_.find(edge);
    at->second.erase(std::find(at->second.begin(), at->second.end(), polygon.id));
    if (at->second.empty()) edges_.erase(at);
    seeds_.push_back(edge);
  }
  polygons_.erase(it);
}

void SurfaceTable::Add(const plc::FacetFeature& polygon) {
  std::vector<plc::EdgeKey>& edges = polygons_[polygon.id].edges;
  for (const auto& ring : polygon.rings) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      edges.push_back(plc::KeyOf(ring[i], ring[j]));
      edges_[edges.back()].push_back(polygon.id);
    }
  }
  seeds_.insert(seeds_.end(), edges.begin(), edges.end());
}

// All that hang together with an edge that has changed.
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
    for (const plc::EdgeKey& edge : polygons_.at(id).edges) reach(edge);
  }
}

// What is left is the same in whatever order polygons are peeled off.
void SurfaceTable::Peel() {
  absl::flat_hash_map<plc::EdgeKey, std::size_t> left;  // polygons at an edge
  const auto has_lone_edge = [&](FeatureId id) {
    const auto& edges = polygons_.at(id).edges;
    return std::any_of(edges.begin(), edges.end(),
                       [&](const plc::EdgeKey& edge) { return left.at(edge) == 1; });
  };
  for (const auto& [id, touched] : touched_) {
    for (const plc::EdgeKey& edge : polygons_.at(id).edges) ++left[edge];
  }
  stack_.clear();
  const auto peel = [&](FeatureId id) {
    Touched& touched = touched_.at(id);
    if (touched.peeled || !has_lone_edge(id)) return;
    touched.peeled = true;
    stack_.push_back(id);
  };
  for (const auto& [id, touched] : touched_) peel(id);
  while (!stack_.empty()) {
    const FeatureId id = stack_.back();
    stack_.pop_back();
    for (const plc::EdgeKey& edge : polygons_.at(id).edges) {
      if (--left.at(edge) != 1) continue;
      for (const FeatureId other : edges_.at(edge)) peel(other);
    }
  }
}

void SurfaceTable::FindSurfaces() {
  std::vector<FeatureId> piece;
  for (auto& [first, start] : touched_) {
    if (start.peeled || start.reached) continue;
    start.reached = true;
    piece.assign(1, first);
    bool is_closed = true;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      for (const plc::EdgeKey& edge : polygons_.at(piece[i]).edges) {
        std::size_t count = 0;
        for (const FeatureId id : edges_.at(edge)) {
          Touched& other = touched_.at(id);
          if (other.peeled) continue;
          ++count;
          if (other.reached) continue;
          other.reached = true;
          piece.push_back(id);
        }
        is_closed = is_closed && count % 2 == 0;
      }
    }
    if (!is_closed) continue;
    const FeatureId least = *std::min_element(piece.begin(), piece.end());
    for (const FeatureId id : piece) touched_.at(id).surface = least;
  }
}

}  // namespace dynmesh
