// The first half of BatchCheck: the changes of the batch, and the edit to blame for each.
#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/base/feature_kinds.h"
#include "core/base/rings.h"
#include "core/plc/batch_check.h"
#include "core/plc/messages.h"

namespace dynmesh::plc {
namespace {

using geometry::Point;

template <typename T>
void SortUnique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

// All points, without duplicates, ascending.
std::vector<FeatureId> PointsOf(const Rings& rings) {
  std::vector<FeatureId> points;
  for (const auto& ring : rings) points.insert(points.end(), ring.begin(), ring.end());
  SortUnique(points);
  return points;
}

}  // namespace

template <int D>
void BatchCheck<D>::Collect() {
  if (store_.size() == 0) {  // a first load, mostly of points
    delta_.added_points.reserve(draft_.entries().size());
    events_.reserve(draft_.entries().size());
  }
  for (const typename Draft<D>::Entry& entry : draft_.entries()) {
    if (steps_.Stop()) return;
    CollectPoint(entry);
  }
  SortUnique(affected_sizes_);
  for (const FeatureId id : affected_sizes_) CollectSize(id);
  if (knows_polygons()) {
    SortUnique(affected_polygons_);
    for (const FeatureId id : affected_polygons_) CollectPolygon(id);
    FindAffectedEdges();
    if constexpr (D == 3) {
      affected_facets_.insert(affected_facets_.end(), affected_polygons_.begin(),
                              affected_polygons_.end());
      SortUnique(affected_facets_);
      for (const FeatureId id : affected_facets_) CollectFacet(id);
    }
  }
  SortUnique(affected_segments_);
  for (const FeatureId id : affected_segments_) {
    if (steps_.Stop()) return;
    CollectSegment(id);
  }
  for (const EdgeKey& key : affected_edges_) CollectEdge(key);
}

// Events from the draft's error on are void: their features are unknown.
template <int D>
void BatchCheck<D>::Schedule(const Event& event) {
  if (event.edit < draft_.error_edit()) events_.push_back(event);
}

// Each kind is collected on its own.
static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);

// The part of `entry` that is or was a point. Other kinds are collected later.
template <int D>
void BatchCheck<D>::CollectPoint(const typename Draft<D>::Entry& entry) {
  const auto is_or_was = [&](DraftState state, bool was) { return entry.state == state || was; };
  if (is_or_was(DraftState::kSegment, store_.FindSegment(entry.id) != nullptr)) {
    affected_segments_.push_back(entry.id);
  }
  if (is_or_was(DraftState::kSize, store_.FindSize(entry.id) != nullptr)) {
    affected_sizes_.push_back(entry.id);
  }
  if (is_or_was(DraftState::kPolygon, store_.FindPolygon(entry.id) != nullptr)) {
    affected_polygons_.push_back(entry.id);
  }
  const bool is_point = entry.state == DraftState::kPoint;
  const PointRecord<D>* was = store_.FindPoint(entry.id);
  if (is_point && draft_.IsAsBefore(entry)) return;
  if (was != nullptr) {
    hidden_.insert(entry.id);
    delta_.removed_points.push_back({entry.id, was->p});
    CollectUsers(entry.id, is_point);
  }
  if (is_point) {
    const auto at = static_cast<std::uint32_t>(delta_.added_points.size());
    delta_.added_points.push_back({entry.id, entry.p});
    Schedule({entry.edit, entry.id, Event::Kind::kPoint, at});
  }
}

// A point of the store is moved or removed. A moved point does not change the rings of a polygon.
template <int D>
void BatchCheck<D>::CollectUsers(FeatureId point, bool is_point) {
  const auto segments = store_.SegmentsAt(point);
  affected_segments_.insert(affected_segments_.end(), segments.begin(), segments.end());
  for (const FeatureId id : store_.PolygonsAt(point)) {
    if (store_.FindSize(id) != nullptr) {
      affected_sizes_.push_back(id);
    } else {
      (is_point ? affected_facets_ : affected_polygons_).push_back(id);
    }
  }
  for (const FeatureId end : store_.EdgesAt(point)) affected_edges_.push_back(KeyOf(point, end));
}

// A sizing feature that the batch names, or a sizing polygon with a changed point.
template <int D>
void BatchCheck<D>::CollectSize(FeatureId id) {
  const SizeFeature<D>* was = store_.FindSize(id);
  const typename Draft<D>::Entry* entry = draft_.Find(id);
  const bool is_size = entry == nullptr || entry->state == DraftState::kSize;
  EditIndex edit = draft_.BlameOf(id);
  SizeFeature<D> now;
  bool whole = false;
  if (is_size) {
    now = entry == nullptr ? *was : draft_.SizeFeatureOf(*entry);
    whole = CheckPoints(id, PointsOf(now.rings), edit);
    now.positions.clear();
    for (const auto& ring : now.rings) {
      std::vector<Point<D>>& positions = now.positions.emplace_back();
      for (const FeatureId point : ring) {
        if (!whole) break;
        positions.push_back(*draft_.FindPoint(point));
        edit = std::max(edit, draft_.BlameOf(point));
      }
    }
  }
  if (was != nullptr) {
    if (whole && *was == now && edit < draft_.error_edit()) return;
    delta_.removed_sizes.push_back(*was);
  }
  if (!whole) return;
  const auto at = static_cast<std::uint32_t>(delta_.added_sizes.size());
  delta_.added_sizes.push_back(std::move(now));
  Schedule({edit, id, Event::Kind::kSize, at});
}

// A polygon that the batch names, or that loses a point: its rings. Positions of its points concern
// its edges.
template <int D>
void BatchCheck<D>::CollectPolygon(FeatureId id) {
  const Rings* was = store_.FindPolygon(id);
  const typename Draft<D>::Entry* entry = draft_.Find(id);
  const EditIndex own = draft_.BlameOf(id);
  bool whole = false;
  PolygonFeature now;
  if (entry == nullptr || entry->state == DraftState::kPolygon) {
    now = entry == nullptr ? PolygonFeature{id, *was, store_.IsUnsplit(id)}
                           : draft_.PolygonOf(*entry);
    whole = CheckQuality(id, options_, own).ok() && CheckRings(id, now.rings, own).ok();
    if (!whole) Schedule({own, id, Event::Kind::kPolygon});
    whole = whole && CheckPoints(id, PointsOf(now.rings), own);
  }
  const auto note = [&](FeatureId p, FeatureId q) { affected_edges_.push_back(KeyOf(p, q)); };
  if (was != nullptr) {
    if (whole && own == kUntouched) return;
    changed_polygons_.insert(id);
    ForEachEdgeOf(*was, note);
    delta_.removed_polygons.push_back({id, *was, store_.IsUnsplit(id)});
  }
  if (!whole) return;
  ForEachEdgeOf(now.rings, note);
  ForEachEdgeOf(now.rings,
                [&](FeatureId p, FeatureId q) { new_users_[KeyOf(p, q)].push_back(id); });
  delta_.added_polygons.push_back(std::move(now));
}

// A 3D polygon that the batch names, or with a changed point. Missing points are reported already.
template <int D>
void BatchCheck<D>::CollectFacet(FeatureId id) {
  if constexpr (D == 3) {
    const Rings* was = store_.FindPolygon(id);
    const typename Draft<D>::Entry* entry = draft_.Find(id);
    FacetFeature now{id, {}, {}};
    if (entry == nullptr) now.rings = *was;
    if (entry != nullptr && entry->state == DraftState::kPolygon) {
      now.rings = draft_.PolygonOf(*entry).rings;
    }
    bool whole =
        CheckQuality(id, options_, kUntouched).ok() && CheckRings(id, now.rings, kUntouched).ok();
    EditIndex edit = draft_.BlameOf(id);
    for (const auto& ring : now.rings) {
      auto& positions = now.positions.emplace_back();
      for (const FeatureId point : ring) {
        const Point<D>* p = draft_.FindPoint(point);
        whole = whole && p != nullptr;
        if (!whole) break;
        positions.push_back(*p);
        edit = std::max(edit, draft_.BlameOf(point));
      }
    }
    if (was != nullptr) {
      FacetFeature before = store_.FacetOf(id, *was);
      if (whole && before == now && edit < draft_.error_edit()) return;
      hidden_facets_.insert(id);
      delta_.removed_facets.push_back(std::move(before));
    }
    if (!whole) return;
    const auto at = static_cast<std::uint32_t>(delta_.added_facets.size());
    delta_.added_facets.push_back(std::move(now));
    Schedule({edit, id, Event::Kind::kFacet, at});
  }
}

// If a segment feature is added, removed or changed where polygons have an edge, both are affected:
// adds them to `affected_edges_` and `affected_segments_`.
template <int D>
void BatchCheck<D>::FindAffectedEdges() {
  for (const typename Draft<D>::Entry& entry : draft_.entries()) {
    if (entry.state != DraftState::kSegment) continue;
    const EdgeKey key = KeyOf(entry.ends[0], entry.ends[1]);
    FeatureId& first = drafted_segments_.try_emplace(key, entry.id).first->second;
    if (BlameOfEdge(entry.id, key) < BlameOfEdge(first, key)) first = entry.id;
  }
  for (const FeatureId id : affected_segments_) {
    if (const SegmentRecord* was = store_.FindSegment(id)) {
      affected_edges_.push_back(KeyOf(was->ends[0], was->ends[1]));
    }
    const typename Draft<D>::Entry* entry = draft_.Find(id);
    if (entry != nullptr && entry->state == DraftState::kSegment) {
      affected_edges_.push_back(KeyOf(entry->ends[0], entry->ends[1]));
    }
  }
  SortUnique(affected_edges_);
  for (const EdgeKey& key : affected_edges_) {
    const FeatureId segment = store_.SegmentBetween(key);
    if (segment != kNoFeature) affected_segments_.push_back(segment);
  }
}

template <int D>
std::vector<FeatureId> BatchCheck<D>::PolygonsAfter(const EdgeKey& key) const {
  std::vector<FeatureId> polygons;
  if (const EdgeRecord* record = store_.FindEdge(key)) polygons = record->polygons;
  std::erase_if(polygons, [&](FeatureId id) { return changed_polygons_.contains(id); });
  if (const auto it = new_users_.find(key); it != new_users_.end()) {
    polygons.insert(polygons.end(), it->second.begin(), it->second.end());
    std::sort(polygons.begin(), polygons.end());
  }
  return polygons;
}

// Is the polygon, of the result, marked unsplit?
template <int D>
bool BatchCheck<D>::IsMarkedAfter(FeatureId polygon) const {
  const typename Draft<D>::Entry* entry = draft_.Find(polygon);
  return entry != nullptr && entry->given != nullptr ? entry->given->unsplit
                                                     : store_.IsUnsplit(polygon);
}

// The earliest edit to blame for the mark of one of them; kNever if none is marked unsplit.
template <int D>
EditIndex BatchCheck<D>::BlameOfMarks(std::span<const FeatureId> polygons) const {
  EditIndex edit = kNever;
  for (const FeatureId id : polygons) {
    if (!IsMarkedAfter(id)) continue;
    edit = std::min(edit, store_.IsUnsplit(id) ? kUntouched : draft_.BlameOf(id));
  }
  return edit;
}

// A segment feature of the result between the two points; kNoFeature if there is none.
template <int D>
FeatureId BatchCheck<D>::SegmentAfter(const EdgeKey& key) const {
  const FeatureId was = store_.SegmentBetween(key);
  if (was != kNoFeature && draft_.Find(was) == nullptr) return was;
  const auto it = drafted_segments_.find(key);
  return it == drafted_segments_.end() ? kNoFeature : it->second;
}

// The edit to blame for a segment feature, or for an edge of a polygon. Other changes of the
// polygon are not to blame for an edge that it had before.
template <int D>
EditIndex BatchCheck<D>::BlameOfEdge(FeatureId feature, const EdgeKey& key) const {
  const EdgeRecord* record = store_.FindEdge(key);
  const bool had = record != nullptr &&
                   std::binary_search(record->polygons.begin(), record->polygons.end(), feature);
  return std::max({had ? kUntouched : draft_.BlameOf(feature), draft_.BlameOf(key.first),
                   draft_.BlameOf(key.second)});
}

// An edge that polygons have or had, without a segment feature before or after.
template <int D>
void BatchCheck<D>::CollectEdge(const EdgeKey& key) {
  const std::vector<FeatureId> polygons = PolygonsAfter(key);
  const FeatureId segment = SegmentAfter(key);
  const Point<D>* p = draft_.FindPoint(key.first);
  const Point<D>* q = draft_.FindPoint(key.second);
  const bool is_edge = !polygons.empty() && p != nullptr && q != nullptr;
  SegmentFeature<D> now;
  FeatureId first = kNoFeature;  // the polygon with the earliest edit to blame
  EditIndex edit = kUntouched;
  if (is_edge) {
    now = {polygons.front(), key.first, key.second, *p, *q};
    now.polygons = polygons;
    first = *std::min_element(polygons.begin(), polygons.end(), [&](FeatureId a, FeatureId b) {
      return BlameOfEdge(a, key) < BlameOfEdge(b, key);
    });
    edit = BlameOfEdge(first, key);
    const EditIndex of_mark = BlameOfMarks(polygons);
    now.unsplit = of_mark != kNever;
    if (now.unsplit) edit = std::max(edit, of_mark);
  }
  const EdgeRecord* record = store_.FindEdge(key);
  if (record != nullptr && record->segment == kNoFeature) {
    SegmentFeature<D> before = store_.Expand(key, *record);
    const bool stays = is_edge && segment == kNoFeature && before == now;
    if (stays && edit < draft_.error_edit()) return;
    hidden_edges_.insert(key);
    delta_.removed_segments.push_back(std::move(before));
  }
  if (!is_edge) return;
  if (segment == kNoFeature) delta_.added_segments.push_back(now);
  // A segment feature with an earlier or equal edit represents the edge.
  if (segment != kNoFeature && BlameOfEdge(segment, key) <= edit) return;
  now.id = first;
  now.polygons = {now.id};
  if (segment != kNoFeature) {
    const typename Draft<D>::Entry* entry = draft_.Find(segment);
    now.is_marked = entry != nullptr ? entry->is_marked : store_.FindSegment(segment)->is_marked;
  }
  edges_.push_back(std::move(now));
  Schedule(
      {edit, edges_.back().id, Event::Kind::kEdge, static_cast<std::uint32_t>(edges_.size() - 1)});
}

// A segment that the batch names, or that ends at a changed point.
template <int D>
void BatchCheck<D>::CollectSegment(FeatureId id) {
  const SegmentRecord* was = store_.FindSegment(id);
  const typename Draft<D>::Entry* entry = draft_.Find(id);
  const EditIndex own = draft_.BlameOf(id);
  const bool is_segment = entry == nullptr || entry->state == DraftState::kSegment;
  const std::array<FeatureId, 2> ends = entry == nullptr ? was->ends : entry->ends;

  EditIndex edit = own;
  SegmentFeature<D> now;
  if (is_segment && ends[0] == ends[1]) Schedule({own, id, Event::Kind::kDegenerate});
  const bool whole = is_segment && ends[0] != ends[1] && CheckPoints(id, ends, own);
  if (whole) {
    for (const FeatureId end : ends) edit = std::max(edit, draft_.BlameOf(end));
    now = {id, ends[0], ends[1], *draft_.FindPoint(ends[0]), *draft_.FindPoint(ends[1])};
    now.is_marked = now.unsplit = entry == nullptr ? was->is_marked : entry->is_marked;
    if (knows_polygons()) now.polygons = PolygonsAfter(KeyOf(now));
    if (const EditIndex mark = BlameOfMarks(now.polygons); mark != kNever && !now.unsplit) {
      now.unsplit = true;
      edit = std::max(edit, mark);
    }
  }
  if (was != nullptr) {
    const SegmentFeature<D> before = store_.Expand(id, *was);
    if (whole && before == now && edit < draft_.error_edit()) return;
    hidden_.insert(id);
    delta_.removed_segments.push_back(before);
  }
  if (!whole) return;
  const auto at = static_cast<std::uint32_t>(delta_.added_segments.size());
  delta_.added_segments.push_back(now);
  Schedule({edit, id, Event::Kind::kSegment, at});
}

// Are all of `points` (no duplicates), which feature `id` needs, points of the result? Otherwise
// schedules the problem. If a later edit than the feature's removed a point: a point in use. Else
// the feature is to blame.
template <int D>
bool BatchCheck<D>::CheckPoints(FeatureId id, std::span<const FeatureId> points, EditIndex own) {
  bool whole = true, own_fault = false;
  for (const FeatureId point : points) {
    if (draft_.FindPoint(point) != nullptr) continue;
    whole = false;
    const EditIndex edit = draft_.BlameOf(point);
    if (edit <= own) {
      own_fault = true;
      continue;
    }
    std::vector<FeatureId>& users = users_of_missing_[point];
    users.push_back(id);
    if (users.size() == 1) Schedule({edit, point, Event::Kind::kPointGone});
  }
  if (own_fault) Schedule({own, id, Event::Kind::kUnknownEnd});
  return whole;
}

template <int D>
absl::Status BatchCheck<D>::UnknownEnd(FeatureId feature, EditIndex edit) const {
  const typename Draft<D>::Entry& entry = *draft_.Find(feature);
  std::vector<FeatureId> points;
  switch (entry.state) {
    case DraftState::kSegment:
      points = {entry.ends[0], entry.ends[1]};
      break;
    case DraftState::kPolygon:
      points = PointsOf(draft_.PolygonOf(entry).rings);
      break;
    case DraftState::kSize:
      points = PointsOf(draft_.SizeFeatureOf(entry).rings);
      break;
    case DraftState::kPoint:
    case DraftState::kAbsent:
      break;  // name no points
  }
  std::erase_if(points, [&](FeatureId point) {
    return draft_.FindPoint(point) != nullptr || draft_.BlameOf(point) > edit;
  });
  return UnknownEndError(feature, points, edit);
}

template void BatchCheck<2>::Collect();
template void BatchCheck<3>::Collect();
template absl::Status BatchCheck<2>::UnknownEnd(FeatureId, EditIndex) const;
template absl::Status BatchCheck<3>::UnknownEnd(FeatureId, EditIndex) const;

}  // namespace dynmesh::plc
