// The segments by their two ends, and the segments at each point with their angles. A segment's
// shape determines how it is split (meshing/shells.h), and depends on its neighbours in angle at
// both ends. Reports the segments with changed shapes after additions and removals, and keeps the
// mesher's data of each. Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_WEDGE_TABLE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_WEDGE_TABLE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "absl/functional/function_ref.h"
#include "core/base/large_vector.h"
#include "core/meshing/element_store.h"
#include "core/meshing/elements.h"
#include "core/meshing/shells.h"

namespace dynmesh {

template <int D>
class WedgeTable {
 public:
  using Vertex = meshing::VertexIndex;
  using Elements = meshing::ElementStore<D>;

  struct Segment {
    std::array<Vertex, 2> ends;  // the lesser point first
    std::array<meshing::WedgeEnd, 2> wedges = {};
    meshing::SegmentShape shape = {};
    bool unsplit = false;
    meshing::FeatureSlot slot = meshing::kNil;      // the caller's
    meshing::SubsegmentIndex root = meshing::kNil;  // the caller's; kNil: does not exist yet
  };

  using Index = std::uint32_t;  // of a segment; may be reused after it is removed

  void Reserve(std::size_t segments) { segments_.reserve(segments_.size() + segments); }

  // REQUIRES: no segment joins the two points yet.
  Index Add(Vertex lesser, Vertex greater, meshing::FeatureSlot slot, bool unsplit = false);
  const Segment& operator[](Index index) const { return segments_[index]; }
  // The segment between two points, which must exist. O(segments at one of them).
  Index Find(Vertex a, Vertex b) const;
  void Remove(Index index);

  // Calls changed(&segment) for each segment that is new or has another shape since the last call;
  // changed sets its root. `elements` has the points. O(k log k) for a point with k segments, in 3D
  // O(k^2).
  void Update(const Elements& elements, absl::FunctionRef<void(Segment*)> changed);

  std::size_t bytes() const;

 private:
  using Users = absl::InlinedVector<Index, 4>;
  void FindWedgesAt(Vertex apex, const Users& users, const Elements& elements);

  LargeVector<Segment> segments_;
  std::vector<Index> free_;
  absl::flat_hash_map<Vertex, Users> at_;
  std::vector<Vertex> touched_;
  std::vector<geometry::Point<D>> others_;  // scratch
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_WEDGE_TABLE_H_
