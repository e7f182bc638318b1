#include "core/dynamic_mesh/feature_table.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <memory>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "core/base/feature_kinds.h"
#include "core/delaunay/delaunay_insert_order.h"
#include "core/meshing/polygon_area.h"
#include "core/meshing/polyline.h"
#include "core/plc/text.h"
#include "core/regions/region_terms.h"

namespace dynmesh {
namespace {

// For fewer points, sorting costs more than it saves.
constexpr std::size_t kFewPoints = 16;

template <int D>
meshing::SizingRegion<D> RegionOf(const plc::SizeFeature<D>& f) {
  const Sizing& s = f.sizing;
  if constexpr (D == 2) {
    if (s.shape == SizeShape::kPolygon) {
      const auto area = std::make_shared<const meshing::PolygonArea>(f.positions);
      return {area->lo(), area->hi(), 0, s.target, area};
    }
  }
  if (s.shape == SizeShape::kCapsule) {
    std::vector<geometry::Point<D>> vertices;
    for (const auto& vertex : s.path) vertices.push_back(plc::CornerOf<D>(vertex));
    const auto line = std::make_shared<const meshing::Polyline<D>>(vertices);
    return {line->lo(), line->hi(), s.radius, s.target, line};
  }
  geometry::Point<D> hi = f.at;
  if (s.shape == SizeShape::kBox) {
    for (int k = 0; k < D; ++k) hi[k] = s.hi[k];
  }
  return {f.at, hi, s.shape == SizeShape::kDisc ? s.radius : 0, s.target, nullptr};
}

}  // namespace

// What a mesher is told of (InputSink); polygons are segments and facets to it.
static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);

// --- Changes --------------------------------------------------------------------------

template <int D>
void FeatureTable<D>::Apply(const Delta& delta, EditableSink& mesher, Steps& steps) {
  for (const plc::SizeFeature<D>& f : delta.removed_sizes) {
    const auto it = sizes_.find(f.id);
    mesher.RemoveSizing(it->second);
    sizes_.erase(it);
  }
  AddSizes(delta, mesher);
  RemoveFacets(delta, mesher);
  RemoveSegments(delta, mesher);
  for (const plc::PointFeature<D>& p : delta.removed_points) {
    const auto it = points_.find(p.id);
    FreeSlot(mesher.elements().vertex(it->second).feature);
    mesher.RemovePoint(it->second);
    points_.erase(it);
  }
  AddOthers(delta, mesher, &mesher, steps);
}

template <int D>
void FeatureTable<D>::Add(const Delta& delta, Sink& mesher, Steps& steps) {
  AddSizes(delta, mesher);
  AddOthers(delta, mesher, nullptr, steps);
}

// Points, segments, facets. `editable`: the mesher, if it can remove; else no segment is known yet.
template <int D>
void FeatureTable<D>::AddOthers(const Delta& delta, Sink& mesher, EditableSink* editable,
                                Steps& steps) {
  AddPoints(delta, mesher, steps);
  AddSegments(delta, mesher, editable, steps);
  AddFacets(delta, mesher, steps);
  if (!steps.stopped()) UpdateSurfaces(delta, mesher);
}

template <int D>
bool FeatureTable<D>::IsIdle(const plc::SizeFeature<D>& f, const Delta& delta,
                             const meshing::SizingField<D>& present) const {
  const meshing::SizingRegion<D> region = RegionOf(f);
  return present.AnyAround(region.Box(), f.sizing.target, [&](auto i) {
    return present[i].Holds(region) &&
           std::ranges::none_of(delta.removed_sizes, [&](const auto& s) {
             const auto it = sizes_.find(s.id);
             return it != sizes_.end() && it->second == i;
           });
  });
}

template <int D>
void FeatureTable<D>::AddSizes(const Delta& delta, Sink& mesher) {
  for (const plc::SizeFeature<D>& f : delta.added_sizes) {
    sizes_[f.id] = mesher.AddSizing(RegionOf(f));
  }
}

template <int D>
void FeatureTable<D>::RemoveSegments(const Delta& delta, EditableSink& mesher) {
  for (const plc::SegmentFeature<D>& s : delta.removed_segments) {
    const auto index = segments_.Find(points_.at(s.p_id), points_.at(s.q_id));
    FreeSlot(segments_[index].slot);
    mesher.RemoveSegment(segments_[index].root);
    segments_.Remove(index);
    if constexpr (D == 2) {
      if (!s.polygons.empty()) toggled_walls_.push_back({s.p, s.q, s.polygons});
    }
  }
}

template <int D>
void FeatureTable<D>::RemoveFacets(const Delta& delta, EditableSink& mesher) {
  // If an edit is undone, its facets are removed, and their corners may be removed, too.
  if (!new_facets_.empty()) {
    absl::flat_hash_set<meshing::FeatureSlot> gone;
    for (const plc::FacetFeature& f : delta.removed_facets) gone.insert(facets_.at(f.id).slot);
    std::erase_if(new_facets_, [&](const NewFacet& added) { return gone.contains(added.slot); });
  }
  for (const plc::FacetFeature& f : delta.removed_facets) {
    const auto it = facets_.find(f.id);
    mesher.RemoveFacet(it->second.index);
    const meshing::FeatureSlot slot = it->second.slot;
    gone_facets_.push_back(slot);
    FreeSlot(slot);
    facets_.erase(it);
  }
}

// Adds many points in an order that suits a triangulation that is filled meanwhile.
template <int D>
void FeatureTable<D>::AddPoints(const Delta& delta, Sink& mesher, Steps& steps) {
  const bool is_kept = !is_fixed_ || !delta.added_segments.empty() || !delta.added_facets.empty();
  const auto add = [&](const plc::PointFeature<D>& p) {
    const meshing::VertexIndex vertex = mesher.AddPoint(p.p, NewSlot(p.id));
    if (is_kept) points_[p.id] = vertex;
  };
  if (delta.added_points.size() <= kFewPoints) {
    for (const plc::PointFeature<D>& p : delta.added_points) add(p);
    return;
  }
  if (is_kept) points_.reserve(points_.size() + delta.added_points.size());
  segments_.Reserve(delta.added_segments.size());
  std::vector<Point> positions;
  positions.reserve(delta.added_points.size());
  for (const plc::PointFeature<D>& p : delta.added_points) positions.push_back(p.p);
  const std::vector<std::uint32_t> order = delaunay::InsertOrder(positions, steps);
  constexpr std::size_t kAhead = 8;  // prefetched so many steps ahead
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (steps.Stop()) return;
    if (i + 2 * kAhead < order.size()) {
      __builtin_prefetch(&delta.added_points[order[i + 2 * kAhead]]);
    }
    if (is_kept && i + kAhead < order.size())
      points_.prefetch(delta.added_points[order[i + kAhead]].id);
    add(delta.added_points[order[i]]);
  }
}

// A segment that gets another shape is removed and added.
template <int D>
void FeatureTable<D>::AddSegments(const Delta& delta, Sink& mesher, EditableSink* editable,
                                  Steps& steps) {
  for (const plc::SegmentFeature<D>& s : delta.added_segments) {
    if (steps.Stop()) return;
    const bool forward = s.p < s.q;
    const meshing::FeatureSlot slot = NewSlot(s.id);
    segments_.Add(points_.at(forward ? s.p_id : s.q_id), points_.at(forward ? s.q_id : s.p_id),
                  slot, s.unsplit);
    if constexpr (D == 2) {
      if (s.polygons.empty()) continue;
      walls_[slot] = s.polygons;
      toggled_walls_.push_back({s.p, s.q, s.polygons});
    }
  }
  segments_.Update(mesher.elements(), [&](typename WedgeTable<D>::Segment* s) {
    if (steps.Stop()) return;
    if (editable != nullptr && s->root != meshing::kNil) editable->RemoveSegment(s->root);
    s->root = mesher.AddSegment(s->ends[0], s->ends[1], s->slot, s->shape);
  });
}

template <int D>
void FeatureTable<D>::AddFacets(const Delta& delta, Sink& mesher, Steps& steps) {
  for (const plc::FacetFeature& f : delta.added_facets) {
    if (steps.Stop()) return;
    const meshing::FeatureSlot slot = NewSlot(f.id);
    NewFacet fresh = {slot, {}};
    std::vector<std::vector<meshing::VertexIndex>> rings;
    for (const auto& ring : f.rings) {
      rings.emplace_back();
      for (const FeatureId id : ring) rings.back().push_back(points_.at(id));
      fresh.corners.insert(fresh.corners.end(), rings.back().begin(), rings.back().end());
    }
    facets_[f.id] = {mesher.AddFacet(rings, slot), slot};
    new_facets_.push_back(std::move(fresh));
  }
}

// Call after all facets were removed and added.
template <int D>
void FeatureTable<D>::UpdateSurfaces(const Delta& delta, const Sink& mesher) {
  if constexpr (D == 3) {
    const auto toggle = [&](const plc::FacetFeature& f) {
      const auto owners = surfaces_.SurfacesOf(f.id);
      if (!owners.empty()) toggled_walls_.push_back({f.positions, {owners.begin(), owners.end()}});
    };
    for (const plc::FacetFeature& f : delta.removed_facets) toggle(f);
    const auto& changes =
        surfaces_.Update(delta.removed_facets, delta.added_facets,
                         [&](FeatureId id) { return mesher.elements().vertex(points_.at(id)).p; });
    for (const plc::FacetFeature& f : delta.added_facets) toggle(f);
    for (const SurfaceTable::Change& change : changes) {
      const Facet& facet = facets_.at(change.polygon);
      if (!IsOn(RegionTerm::kOthersFollow)) continue;
      resurfaced_facets_.push_back(facet.slot);
      std::vector<FeatureId> owners;
      std::set_symmetric_difference(change.before.begin(), change.before.end(),
                                    change.after.begin(), change.after.end(),
                                    std::back_inserter(owners));
      toggled_walls_.push_back({mesher.facets()[facet.index].rings(), std::move(owners)});
    }
  }
}

// --- Slots and walls --------------------------------------------------------------------

template <int D>
meshing::FeatureSlot FeatureTable<D>::NewSlot(FeatureId id) {
  if (free_.empty()) {
    ids_.push_back(id);
    return static_cast<meshing::FeatureSlot>(ids_.size() - 1);
  }
  const meshing::FeatureSlot slot = free_.back();
  free_.pop_back();
  ids_[slot] = id;
  return slot;
}

template <int D>
std::span<const FeatureId> FeatureTable<D>::OwnersOfWall(meshing::FeatureSlot slot) const {
  if constexpr (D == 3) return surfaces_.SurfacesOf(ids_[slot]);
  if (walls_.empty()) return {};
  const auto it = walls_.find(slot);
  return it == walls_.end() ? std::span<const FeatureId>() : it->second;
}

template <int D>
void FeatureTable<D>::Collect() {
  if (!walls_.empty()) {
    for (const meshing::FeatureSlot slot : freed_) walls_.erase(slot);
  }
  toggled_walls_.clear();
  new_facets_.clear();
  gone_facets_.clear();
  resurfaced_facets_.clear();
  free_.insert(free_.end(), freed_.begin(), freed_.end());
  freed_.clear();
}

template <int D>
std::size_t FeatureTable<D>::bytes() const {
  const auto of = [](const auto& map) { return map.capacity() * (sizeof(*map.begin()) + 1); };
  return of(points_) + of(sizes_) + of(facets_) + of(walls_) + ids_.capacity() * sizeof(FeatureId) +
         (free_.capacity() + freed_.capacity()) * sizeof(meshing::FeatureSlot) + segments_.bytes();
}

template class FeatureTable<2>;
template class FeatureTable<3>;

}  // namespace dynmesh
