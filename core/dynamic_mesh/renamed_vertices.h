// Vertices that stay in the mesh under another id: what they were called before an update.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_RENAMED_VERTICES_H_
#define DYNMESH_CORE_DYNAMIC_MESH_RENAMED_VERTICES_H_

#include <algorithm>
#include <vector>

#include "core/meshing/elements.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

class RenamedVertices {
 public:
  struct Renamed {
    meshing::VertexIndex v;
    VertexId old_id;
  };

  void Clear() { all_.clear(); }
  void Add(meshing::VertexIndex v, VertexId old_id) { all_.push_back({v, old_id}); }
  // Call it after Clear and Add. Of several ids of a vertex the first added counts. new_id(v): that
  // of now; vertices with the same id are dropped.
  template <class NewId>
  void Close(NewId new_id) {
    if (all_.empty()) return;
    std::stable_sort(all_.begin(), all_.end(), IsLess);
    all_.erase(std::unique(all_.begin(), all_.end(),
                           [](const Renamed& a, const Renamed& b) { return a.v == b.v; }),
               all_.end());
    std::erase_if(all_, [&](const Renamed& r) { return new_id(r.v) == r.old_id; });
  }

  bool empty() const { return all_.empty(); }
  auto begin() const { return all_.begin(); }
  auto end() const { return all_.end(); }
  // The vertex, or null if it is not renamed. O(log n).
  const Renamed* Find(meshing::VertexIndex v) const {
    const auto at = std::lower_bound(all_.begin(), all_.end(), Renamed{v, 0}, IsLess);
    return at != all_.end() && at->v == v ? &*at : nullptr;
  }

 private:
  static bool IsLess(const Renamed& a, const Renamed& b) { return a.v < b.v; }

  std::vector<Renamed> all_;  // sorted by index
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_RENAMED_VERTICES_H_
