// The types of refinement: D is the dimension, E the engine, traced (sac::Engine) or not
// (sac::UntracedEngine). Every part of the program is a template over both.
#ifndef DYNMESH_CORE_MESHING_TYPES_H_
#define DYNMESH_CORE_MESHING_TYPES_H_

#include <type_traits>

#include "core/delaunay/triangulation_of.h"
#include "core/meshing/elements.h"
#include "core/meshing/planar_rules.h"
#include "core/meshing/space_rules.h"
#include "core/sac/engine.h"

namespace dynmesh::meshing {
template <int D, template <class> class E>
class Refinement;
}

template <int D, template <class> class E>
struct dynmesh::sac::PayloadOf<dynmesh::meshing::Refinement<D, E>> {
  using Type = meshing::Payload<D>;
};

namespace dynmesh::meshing {

template <int D>
using RulesOf = std::conditional_t<D == 2, PlanarRules, SpaceRules>;
using delaunay::TriangulationOf;

template <int D, template <class> class E>
using EngineOf = E<Refinement<D, E>>;
template <int D, template <class> class E>
using ContextOf = typename EngineOf<D, E>::Context;
template <int D, template <class> class E>
inline constexpr bool kIsTraced = EngineOf<D, E>::kTraced;

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_TYPES_H_
