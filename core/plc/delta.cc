#include "core/plc/delta.h"

#include <tuple>

namespace dynmesh::plc {
namespace {

template <typename F>
void SortById(std::vector<F>& features) {
  std::sort(features.begin(), features.end(), [](const F& a, const F& b) { return a.id < b.id; });
}

// Edges of a polygon have its id.
template <int D>
void SortById(std::vector<SegmentFeature<D>>& segments) {
  std::sort(segments.begin(), segments.end(), [](const auto& a, const auto& b) {
    return std::tie(a.id, a.p_id, a.q_id) < std::tie(b.id, b.p_id, b.q_id);
  });
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

template struct Delta<2>;
template struct Delta<3>;

}  // namespace dynmesh::plc
