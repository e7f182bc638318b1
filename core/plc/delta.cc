#include "core/plc/delta.h"

#include <algorithm>
#include <cstddef>
#include <tuple>

#include "core/base/feature_kinds.h"

namespace dynmesh::plc {

// A delta has lists of each, and of facets. The functions here go through all of them.
static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);

namespace {

struct ById {
  template <typename F>
  bool operator()(const F& a, const F& b) const {
    return a.id < b.id;
  }
  // Edges of a polygon have its id.
  template <int D>
  bool operator()(const SegmentFeature<D>& a, const SegmentFeature<D>& b) const {
    return std::tie(a.id, a.p_id, a.q_id) < std::tie(b.id, b.p_id, b.q_id);
  }
};

template <typename F>
void SortById(std::vector<F>& features) {
  std::sort(features.begin(), features.end(), ById());
}

template <typename F>
void Replace(std::vector<F>& features, const std::vector<F>& removed, const std::vector<F>& added) {
  std::erase_if(features, [&](const F& f) {
    return std::binary_search(removed.begin(), removed.end(), f, ById());
  });
  features.insert(features.end(), added.begin(), added.end());
}

}  // namespace

template <int D>
void Delta<D>::Sort() {
  SortById(removed_points);
  SortById(added_points);
  SortById(removed_segments);
  SortById(added_segments);
  SortById(removed_sizes);
  SortById(added_sizes);
  SortById(removed_polygons);
  SortById(added_polygons);
  SortById(removed_facets);
  SortById(added_facets);
}

template <int D>
void Delta<D>::Then(const Delta& next) {
  Replace(added_points, next.removed_points, next.added_points);
  Replace(added_segments, next.removed_segments, next.added_segments);
  Replace(added_sizes, next.removed_sizes, next.added_sizes);
  Replace(added_polygons, next.removed_polygons, next.added_polygons);
  Replace(added_facets, next.removed_facets, next.added_facets);
  Sort();
}

template <int D>
Delta<D> Delta<D>::Part(std::size_t from, std::size_t to) const {
  Delta part;
  std::size_t at = 0;  // index of the list's first element
  const auto take = [&](auto list) {
    const auto& all = this->*list;
    const auto within = [&](std::size_t i) { return std::clamp(i, at, at + all.size()) - at; };
    (part.*list)
        .assign(all.begin() + static_cast<std::ptrdiff_t>(within(from)),
                all.begin() + static_cast<std::ptrdiff_t>(within(to)));
    at += all.size();
  };
  take(&Delta::removed_facets);
  take(&Delta::removed_polygons);
  take(&Delta::removed_segments);
  take(&Delta::removed_points);
  take(&Delta::removed_sizes);
  take(&Delta::added_sizes);
  take(&Delta::added_points);
  take(&Delta::added_segments);
  take(&Delta::added_polygons);
  take(&Delta::added_facets);
  return part;
}

template struct Delta<2>;
template struct Delta<3>;

}  // namespace dynmesh::plc
