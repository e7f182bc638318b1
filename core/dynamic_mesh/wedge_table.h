// The segments by their two ends, and the segments at each point with their angles. A segment's
// shape determines how it is split (meshing/shells.h), and depends on its neighbours in angle at
// both ends. Reports the segments with changed shapes after additions and removals, and keeps the
// mesher's data of each. Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_WEDGE_TABLE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_WEDGE_TABLE_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "core/base/large_vector.h"
#include "core/meshing/elements.h"
#include "core/meshing/shells.h"

namespace dynmesh {

template <int D>
class WedgeTable {
 public:
  using Vertex = meshing::VertexIndex;

  struct Segment {
    std::array<Vertex, 2> ends;  // the lesser point first
    std::array<meshing::WedgeEnd, 2> wedges = {};
    meshing::SegmentShape shape = {};
    meshing::FeatureSlot slot = meshing::kNil;      // the caller's
    meshing::SubsegmentIndex root = meshing::kNil;  // the caller's; kNil: does not exist yet
  };

  using Index = std::uint32_t;  // of a segment; may be reused after it is removed

  void Reserve(std::size_t segments) { segments_.reserve(segments_.size() + segments); }

  // REQUIRES: no segment joins the two points yet.
  Index Add(Vertex lesser, Vertex greater, meshing::FeatureSlot slot) {
    Index index = static_cast<Index>(segments_.size());
    if (free_.empty()) {
      segments_.emplace_back();
    } else {
      index = free_.back();
      free_.pop_back();
    }
    segments_[index] = Segment{{lesser, greater}};
    segments_[index].slot = slot;
    for (const Vertex end : {lesser, greater}) {
      at_[end].push_back(index);
      touched_.push_back(end);
    }
    return index;
  }
  const Segment& operator[](Index index) const { return segments_[index]; }
  // The segment between two points, which must exist. O(segments at one of them).
  Index Find(Vertex a, Vertex b) const {
    const Users& at_a = at_.at(a);
    const Users& at_b = at_.at(b);
    for (const Index index : at_a.size() < at_b.size() ? at_a : at_b) {
      const auto& [p, q] = segments_[index].ends;
      if ((p == a && q == b) || (p == b && q == a)) return index;
    }
    return meshing::kNil;
  }
  void Remove(Index index) {
    for (const Vertex end : segments_[index].ends) {
      const auto at = at_.find(end);
      at->second.erase(std::find(at->second.begin(), at->second.end(), index));
      if (at->second.empty()) at_.erase(at);
      touched_.push_back(end);
    }
    free_.push_back(index);
  }

  // Calls changed(&segment) for each segment that is new or has another shape since the last call;
  // changed sets its root. position(v) is v's point. O(k log k) for a point with k
  // segments, in 3D O(k^2).
  template <class Position, class Changed>
  void Update(Position position, Changed changed) {
    std::vector<Index> affected;
    SortUnique(touched_);
    for (const Vertex apex : touched_) {
      const auto at = at_.find(apex);
      if (at == at_.end()) continue;
      FindWedgesAt(apex, at->second, position);
      affected.insert(affected.end(), at->second.begin(), at->second.end());
    }
    touched_.clear();
    SortUnique(affected);
    for (const Index index : affected) {
      Segment& s = segments_[index];
      const meshing::SegmentShape shape = ShapeOf(s, position);
      if (s.root != meshing::kNil && shape == s.shape) continue;
      s.shape = shape;
      changed(&s);
    }
  }

  std::size_t bytes() const {
    return segments_.capacity() * sizeof(Segment) + free_.capacity() * sizeof(Index) +
           at_.capacity() * (sizeof(Vertex) + sizeof(Users) + 1);
  }

 private:
  using Users = absl::InlinedVector<Index, 4>;
  template <class Position>
  void FindWedgesAt(Vertex apex, const Users& users, Position position) {
    others_.clear();
    for (const Index index : users) {
      const Segment& s = segments_[index];
      others_.push_back(position(s.ends[s.ends[0] == apex ? 1 : 0]));
    }
    const auto wedges = meshing::FindWedges<D>(position(apex), others_);
    for (std::size_t i = 0; i < others_.size(); ++i) {
      Segment& s = segments_[users[i]];
      s.wedges[s.ends[0] == apex ? 0 : 1] = wedges[i];
    }
  }
  template <class Position>
  meshing::SegmentShape ShapeOf(const Segment& s, Position position) const {
    const double length = meshing::LengthOf(position(s.ends[0]), position(s.ends[1]));
    return meshing::ShapeOf<D>(length, s.wedges[0], s.wedges[1]);
  }
  template <class T>
  static void SortUnique(std::vector<T>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
  }

  LargeVector<Segment> segments_;
  std::vector<Index> free_;
  absl::flat_hash_map<Vertex, Users> at_;
  std::vector<Vertex> touched_;
  std::vector<geometry::Point<D>> others_;  // scratch
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_WEDGE_TABLE_H_
