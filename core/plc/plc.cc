#include "core/plc/plc.h"

#include <algorithm>

#include "core/plc/batch_check.h"

namespace dynmesh::plc {

Plc2::Plc2(const MeshOptions& options, std::uint32_t hub_degree)
    : options_(options),
      limit_(CloseLimit(options)),
      grid_(options.box, limit_),
      index_(grid_, hub_degree) {}

absl::StatusOr<Delta> Plc2::Check(const Edits& batch, std::uint64_t* cost,
                                  absl::FunctionRef<bool()> interrupted) const {
  BatchCheck check(options_, limit_, grid_, store_, index_, batch);
  absl::StatusOr<Delta> delta = check.Run(interrupted);
  if (cost != nullptr) *cost += check.cost();
  return delta;
}

void Plc2::Commit(const Delta& delta) {
  for (const SegmentFeature& f : delta.removed_segments) index_.EraseSegment(store_.Remove(f));
  for (const PolygonFeature& f : delta.removed_polygons) store_.RemovePolygon(f.id);
  for (const PointFeature& f : delta.removed_points) {
    index_.ErasePoint(store_.FindPoint(f.id)->slot);
    store_.RemovePoint(f.id);
  }
  for (const SizeFeature& f : delta.removed_sizes) store_.RemoveSize(f.id);
  store_.Reserve(delta.added_points.size(), delta.added_segments.size());
  for (const PointFeature& f : delta.added_points) store_.Add(f, index_.Insert(f));
  for (const SegmentFeature& f : delta.added_segments) store_.Add(f, index_.Insert(f));
  for (const SizeFeature& f : delta.added_sizes) store_.Add(f);
  for (const PolygonFeature& f : delta.added_polygons) store_.Add(f);
}

std::vector<Feature> Plc2::Features() const {
  std::vector<Feature> features;
  features.reserve(size());
  for (const auto& [id, record] : store_.points()) {
    features.push_back(Feature::Point(id, record.p[0], record.p[1]));
  }
  for (const auto& [id, record] : store_.segments()) {
    features.push_back(Feature::Segment(id, record.ends[0], record.ends[1]));
  }
  for (const auto& [id, size] : store_.sizes()) {
    features.push_back(Feature::Size(id, {size.at[0], size.at[1], 0}, size.sizing));
    features.back().rings = size.rings;
  }
  for (const auto& [id, rings] : store_.polygons()) {
    features.push_back(Feature::Polygon(id, rings));
  }
  std::sort(features.begin(), features.end(),
            [](const Feature& a, const Feature& b) { return a.id < b.id; });
  return features;
}

Delta Plc2::FromNothing() const {
  Delta all;
  for (const auto& [id, record] : store_.points()) all.added_points.push_back({id, record.p});
  for (const auto& [id, record] : store_.segments()) {
    all.added_segments.push_back(store_.Expand(id, record));
  }
  for (const auto& [key, record] : store_.edges()) {
    if (record.segment != kNoFeature) continue;
    all.added_segments.push_back(store_.Expand(key, record));
  }
  for (const auto& [id, size] : store_.sizes()) all.added_sizes.push_back(size);
  for (const auto& [id, rings] : store_.polygons()) all.added_polygons.push_back({id, rings});
  all.Sort();
  return all;
}

std::optional<PointFeature> Plc2::FindPoint(FeatureId id) const {
  const PointRecord* record = store_.FindPoint(id);
  if (record == nullptr) return std::nullopt;
  return PointFeature{id, record->p};
}

std::optional<SegmentFeature> Plc2::FindSegment(FeatureId id) const {
  const SegmentRecord* record = store_.FindSegment(id);
  if (record == nullptr) return std::nullopt;
  return store_.Expand(id, *record);
}

std::optional<SizeFeature> Plc2::FindSize(FeatureId id) const {
  const SizeFeature* size = store_.FindSize(id);
  if (size == nullptr) return std::nullopt;
  return *size;
}

std::vector<FeatureId> Plc2::SegmentsAt(FeatureId point) const {
  const auto at = store_.SegmentsAt(point);
  std::vector<FeatureId> segments(at.begin(), at.end());
  std::sort(segments.begin(), segments.end());
  return segments;
}

}  // namespace dynmesh::plc
