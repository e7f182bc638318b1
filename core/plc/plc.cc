#include "core/plc/plc.h"

#include <algorithm>

#include "core/base/feature_kinds.h"
#include "core/plc/batch_check.h"

namespace dynmesh::plc {

template <int D>
Plc<D>::Plc(const MeshOptions& options, std::uint32_t hub_degree)
    : options_(options),
      limit_(CloseLimit(options)),
      grid_(options.box, limit_),
      index_(std::make_unique<FeatureIndex<D>>(grid_, hub_degree)) {}

template <int D>
absl::StatusOr<Delta<D>> Plc<D>::Check(const Edits& batch, std::uint64_t* cost,
                                       Interrupted interrupted) const {
  const auto stop = [&] { return interrupted(kNotKnown); };
  Steps steps(stop);
  BatchCheck<D> check(options_, limit_, grid_, store_, *index_, batch, steps);
  absl::StatusOr<Delta<D>> delta = check.Run(interrupted);
  if (cost != nullptr) *cost += check.cost();
  return delta;
}

template <int D>
absl::StatusOr<Delta<D>> Plc<D>::ChangeOfValid(const Edits& batch, Interrupted interrupted) const {
  const auto stop = [&] { return interrupted(kNotKnown); };
  Steps steps(stop);
  return BatchCheck<D>(options_, limit_, grid_, store_, *index_, batch, steps).RunValid();
}

template <int D>
void Plc<D>::Apply(const Delta<D>& delta) {
  for (const SegmentFeature<D>& f : delta.removed_segments) index_->EraseSegment(store_.Remove(f));
  for (const PolygonFeature& f : delta.removed_polygons) store_.RemovePolygon(f.id);
  if constexpr (D == 3) {
    for (const FacetFeature& f : delta.removed_facets) {
      index_->EraseFacet(store_.RemoveFacet(f.id));
    }
  }
  for (const PointFeature<D>& f : delta.removed_points) {
    index_->ErasePoint(store_.FindPoint(f.id)->slot);
    store_.RemovePoint(f.id);
  }
  for (const SizeFeature<D>& f : delta.removed_sizes) store_.RemoveSize(f.id);
  Insert(delta);
  constexpr std::size_t kFew = 16;  // these use little memory
  most_ = std::max(most_, size());
  if (most_ > kFew && size() <= most_ / 4) GiveMemoryBack();
}

// Here and below each kind has its lists.
static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);

// Inserts what the delta adds.
template <int D>
void Plc<D>::Insert(const Delta<D>& delta) {
  store_.Reserve(delta.added_points.size(), delta.added_segments.size());
  for (const PointFeature<D>& f : delta.added_points) store_.Add(f, index_->Insert(f));
  for (const SegmentFeature<D>& f : delta.added_segments) store_.Add(f, index_->Insert(f));
  for (const SizeFeature<D>& f : delta.added_sizes) store_.Add(f);
  for (const PolygonFeature& f : delta.added_polygons) store_.Add(f);
  if constexpr (D == 3) {
    for (const FacetFeature& f : delta.added_facets) {
      store_.AddFacet(f.id, index_->Insert(Facet(f)));
    }
  }
}

// Tables keep the memory of their largest size; new ones do not.
template <int D>
void Plc<D>::GiveMemoryBack() {
  const Delta<D> all = FromNothing();
  store_ = FeatureStore<D>();
  index_ = std::make_unique<FeatureIndex<D>>(grid_, index_->hub_degree());
  Insert(all);
  most_ = size();
}

template <int D>
std::vector<Feature> Plc<D>::Features() const {
  std::vector<Feature> features;
  features.reserve(size());
  for (const auto& [id, record] : store_.points()) {
    features.push_back(Feature::Point(id, 0, 0));
    std::copy_n(record.p.c.begin(), D, features.back().position.begin());
  }
  for (const auto& [id, record] : store_.segments()) {
    features.push_back(Feature::Segment(id, record.ends[0], record.ends[1]));
    features.back().unsplit = record.is_marked;
  }
  for (const auto& [id, size] : store_.sizes()) {
    features.push_back(Feature::Size(id, {0, 0, 0}, size.sizing));
    std::copy_n(size.at.c.begin(), D, features.back().position.begin());
    features.back().rings = size.rings;
  }
  for (const auto& [id, rings] : store_.polygons()) {
    features.push_back(Feature::Polygon(id, rings));
    features.back().unsplit = store_.IsUnsplit(id);
  }
  std::sort(features.begin(), features.end(),
            [](const Feature& a, const Feature& b) { return a.id < b.id; });
  return features;
}

template <int D>
Delta<D> Plc<D>::FromNothing(Steps& steps) const {
  Delta<D> all;
  for (const auto& [id, record] : store_.points()) {
    if (steps.Stop()) return all;
    all.added_points.push_back({id, record.p});
  }
  for (const auto& [id, record] : store_.segments()) {
    if (steps.Stop()) return all;
    all.added_segments.push_back(store_.Expand(id, record));
  }
  for (const auto& [key, record] : store_.edges()) {
    if (steps.Stop()) return all;
    if (record.segment != kNoFeature) continue;
    all.added_segments.push_back(store_.Expand(key, record));
  }
  for (const auto& [id, size] : store_.sizes()) all.added_sizes.push_back(size);
  for (const auto& [id, rings] : store_.polygons()) {
    all.added_polygons.push_back({id, rings, store_.IsUnsplit(id)});
    if constexpr (D == 3) all.added_facets.push_back(store_.FacetOf(id, rings));
  }
  all.Sort();
  return all;
}

template class Plc<2>;
template class Plc<3>;

}  // namespace dynmesh::plc
