// Segments that are near others, and the vertices that they cause there at least
// (least_vertices.h).
//
// Functions of the segments: candidates are chosen by measure, distance and ends, never by the
// order of visits. Thread-safe.
#ifndef DYNMESH_CORE_PLC_SEGMENT_GAPS_H_
#define DYNMESH_CORE_PLC_SEGMENT_GAPS_H_

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/base/steps.h"
#include "core/plc/delta.h"
#include "core/plc/feature_index.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

// Of one segment.
template <int D>
struct SegmentGap {
  double vertices = 0;       // inside the segment, at least
  SegmentFeature<D> other;   // that causes most of them
  double distance = 0;       // of the two
  geometry::Point<D> place;  // of the segment, where they are nearest
};

// The segments nearest to one.
template <int D>
class NearestSegments {
 public:
  // Within `reach`. `s` must outlive this.
  NearestSegments(const SegmentFeature<D>& s, double reach) : s_(s), reach_(reach) {}

  // Segments may come twice.
  void Add(const SegmentFeature<D>& t);
  // `limit`: CloseLimit.
  SegmentGap<D> Gap(const Limits& limits, double limit) const;

 private:
  struct Entry {
    double distance;
    SegmentFeature<D> segment;
  };

  const SegmentFeature<D>& s_;
  const double reach_;
  std::vector<Entry> nearest_;  // by distance, then by ends
};

template <int D>
struct SegmentGaps {
  struct One {
    std::size_t at;  // of the given segments
    SegmentGap<D> gap;
  };
  std::vector<One> gaps;
  double sum = 0;  // of their vertices

  // That with most vertices. REQUIRES: there is one.
  const One& Worst() const;
  // The least distance such that the gaps above it have at most `most` vertices together.
  double DistanceBelowWhich(double most) const;
};

// query(s, distance, visit) visits segments within the distance from s, and maybe others.
template <int D>
using SegmentQuery = absl::FunctionRef<void(const SegmentFeature<D>& s, double distance,
                                            absl::FunctionRef<void(const SegmentFeature<D>&)>)>;

// The gaps on `segments`: neighbours so near that one alone may cause `need` vertices. If there are
// very many segments, on the longest. If `steps` stop, the result is unspecified.
template <int D>
SegmentGaps<D> FindSegmentGaps(std::span<const SegmentFeature<D>> segments, double need,
                               const Limits& limits, double limit, Steps& steps,
                               SegmentQuery<D> query);
// The share of each of `segments` in `most` vertices.
double NeedOf(std::size_t segments, double most);

// The gaps among `segments`, which do not cross, and those that `also` visits. For messages, about
// a mesh that has more than `most` vertices: gaps that together cause a hundredth of them are
// found. Expected O(n lg n).
template <int D>
SegmentGaps<D> GapsAmong(std::span<const SegmentFeature<D>> segments, const MeshOptions& options,
                         double most, Steps& steps, SegmentQuery<D> also);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_SEGMENT_GAPS_H_
