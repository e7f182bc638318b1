// The limits that a mutation test can switch off (base/mutation.h). The name is what holds; the
// comment, what happens instead.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LIMIT_TERMS_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LIMIT_TERMS_H_

#include "core/base/mutation.h"

namespace dynmesh {

enum class LimitTerm {
  kVerticesEnd,   // there may be more than max_vertices
  kDepthRefuses,  // a segment that cannot be split is no error
  kCount,
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LIMIT_TERMS_H_
