// Positions and error bounds of a star in the complex.
#ifndef DYNMESH_CORE_MESHING_STAR_VIEW_H_
#define DYNMESH_CORE_MESHING_STAR_VIEW_H_

#include "core/base/rounding.h"
#include "core/meshing/complex.h"
#include "core/meshing/star.h"
#include "core/meshing/star_reads.h"

namespace dynmesh::meshing {

// The position of a vertex or a ghost of the star at p.
template <int D, template <class> class E>
geometry::Point<D> PositionInStar(const Complex<D, E>& complex, std::uint32_t id,
                                  const geometry::Point<D>& p, double reach) {
  return Star<D>::IsGhost(id)
             ? Star<D>::Ghost(p, reach, static_cast<int>(id - Star<D>::kFirstGhost))
             : complex.vertex(id).p;
}

// The greatest squared distance from v within a ball through v inside the ghosts.
template <int D>
double FarthestInView2(double reach) {
  return 4 * D * reach * reach * kWider;
}

// A bound of the error of a corner's computed centre. `error`: the corner's own bound.
template <int D>
double MarginOf(const RulesOf<D>& rules, double reach, double error) {
  return error + 1e-9 * reach + 2 * rules.ulp();
}

// Inserts the vertex with this id into the star if it is one, is there as of now, and is not in the
// star.
template <int D, template <class> class E>
void Offer(const Complex<D, E>& complex, const ContextOf<D, E>& context, std::uint32_t id,
           Star<D>& star) {
  if (!IsVertexWord(id) || id == star.vertex()) return;
  const Vertex<D>& u = complex.vertex(id);
  if (!u.present || !context.Sees(u.birth) || star.Has(id)) return;
  star.Insert(id, u.p);
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_STAR_VIEW_H_
