// Which segments meet at which points, and at what angles: the shape of a segment, by which
// it is split (meshing/shells.h), depends on its neighbours in angle at both ends. Tells
// whose shape has changed after some have come or gone, and keeps what stands for each in the
// mesher. Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_WEDGE_TABLE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_WEDGE_TABLE_H_

#include <algorithm>
#include <array>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "core/meshing/elements.h"
#include "core/meshing/shells.h"
#include "dynmesh/feature.h"

namespace dynmesh {

class WedgeTable {
 public:
  using Vertex = meshing::VertexIndex;

  struct Segment {
    std::array<Vertex, 2> ends;  // the lesser point first
    std::array<meshing::WedgeEnd, 2> wedges = {};
    meshing::SegmentShape shape = {};
    meshing::SubsegmentIndex root = meshing::kNil;  // the caller's; kNil: not made yet
  };

  void Reserve(std::size_t segments) { segments_.reserve(segments_.size() + segments); }

  void Add(FeatureId id, Vertex lesser, Vertex greater) {
    segments_[id] = Segment{{lesser, greater}};
    for (const Vertex end : {lesser, greater}) {
      at_[end].push_back(id);
      touched_.push_back(end);
    }
  }
  const Segment& at(FeatureId id) const { return segments_.at(id); }
  void Remove(FeatureId id) {
    const auto segment = segments_.find(id);
    for (const Vertex end : segment->second.ends) {
      const auto at = at_.find(end);
      at->second.erase(std::find(at->second.begin(), at->second.end(), id));
      if (at->second.empty()) at_.erase(at);
      touched_.push_back(end);
    }
    segments_.erase(segment);
  }

  // Calls changed(id, &segment) for each segment that is new or has another shape since the
  // last call; changed sets its root. position(v) is v's point. O(k log k) for a point where k
  // segments meet.
  template <class Position, class Changed>
  void Update(Position position, Changed changed) {
    std::vector<FeatureId> affected;
    std::vector<geometry::Point2> others;
    SortUnique(touched_);
    for (const Vertex apex : touched_) {
      const auto at = at_.find(apex);
      if (at == at_.end()) continue;
      others.clear();
      for (const FeatureId id : at->second) {
        const Segment& s = segments_.find(id)->second;
        others.push_back(position(s.ends[s.ends[0] == apex ? 1 : 0]));
      }
      const auto wedges = meshing::FindWedges(position(apex), others);
      for (std::size_t i = 0; i < others.size(); ++i) {
        Segment& s = segments_.find(at->second[i])->second;
        s.wedges[s.ends[0] == apex ? 0 : 1] = wedges[i];
      }
      affected.insert(affected.end(), at->second.begin(), at->second.end());
    }
    touched_.clear();
    SortUnique(affected);
    for (const FeatureId id : affected) {
      Segment& s = segments_.find(id)->second;
      const double length = meshing::LengthOf(position(s.ends[0]), position(s.ends[1]));
      const auto shape = meshing::ShapeOf(length, s.wedges[0], s.wedges[1]);
      if (s.root != meshing::kNil && shape == s.shape) continue;
      s.shape = shape;
      changed(id, &s);
    }
  }

  std::size_t bytes() const {
    return segments_.capacity() * (sizeof(FeatureId) + sizeof(Segment) + 1) +
           at_.capacity() * (sizeof(Vertex) + sizeof(Users) + 1);
  }

 private:
  using Users = absl::InlinedVector<FeatureId, 2>;
  template <class T>
  static void SortUnique(std::vector<T>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
  }

  absl::flat_hash_map<FeatureId, Segment> segments_;
  absl::flat_hash_map<Vertex, Users> at_;
  std::vector<Vertex> touched_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_WEDGE_TABLE_H_
