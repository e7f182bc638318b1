// Vertices near a vertex, as the trace knows them.
#ifndef DYNMESH_CORE_MESHING_NEIGHBOURS_H_
#define DYNMESH_CORE_MESHING_NEIGHBOURS_H_

#include "core/meshing/complex.h"
#include "core/meshing/star.h"
#include "core/meshing/star_reads.h"

namespace dynmesh::meshing {

// Calls f(u) for vertices u near v until f returns true. Untraced: for none.
template <int D, template <class> class E, class F>
void ForSomeNeighbours(const Complex<D, E>& complex, VertexIndex v, F f) {
  if constexpr (kIsTraced<D, E>) {
    const auto& engine = complex.engine;
    if (IsOfCure(complex.vertex(v))) {
      for (const VertexIndex u : complex.slivers[engine.item(complex.vertex(v).creator)].v) {
        if (f(u)) return;
      }
    }
    for (sac::OpId o = complex.vertex(v).operations; o != sac::kNoOp; o = engine.next_of_item(o)) {
      for (const std::uint32_t u : engine.reads(o)) {
        if (!Star<D>::IsGhost(u) && f(u)) return;
      }
    }
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_NEIGHBOURS_H_
