// What a report of a mesh reads of the mesher that made it. A report sees a mesher as a MeshSource,
// and need not know its type. Calls come between runs. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_MESH_SOURCE_H_
#define DYNMESH_CORE_MESHING_MESH_SOURCE_H_

#include <cstdint>

#include "absl/functional/function_ref.h"
#include "core/meshing/element_store.h"

namespace dynmesh::meshing {

template <int D>
class MeshSource {
 public:
  using OnChange = absl::FunctionRef<void(std::uint32_t index, bool is, bool was)>;

  virtual const ElementStore<D>& elements() const = 0;
  // As ElementStore::TakeChanges.
  virtual void TakeChanges(OnChange on_vertex, OnChange on_subsegment) = 0;
  // Calls f(u) for vertices u that were near v when it was made, until f returns true, or for some
  // each nearer than those before for which it did. There need not be any.
  virtual void ForSomeNeighbours(VertexIndex v, absl::FunctionRef<bool(VertexIndex)> f) const = 0;
  // 3D: the feature of the facet that contains triangle abc, a side of a tetrahedron with fourth
  // corner d; kNil if there is none (facet_membership.h).
  virtual FeatureSlot FacetAt(VertexIndex a, VertexIndex b, VertexIndex c, VertexIndex d) const = 0;

 protected:
  ~MeshSource() = default;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_MESH_SOURCE_H_
