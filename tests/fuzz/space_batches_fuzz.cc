#include "tests/fuzz/batches.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {

// A 3D mesh is expensive: fewer batches.
std::string FuzzSpaceBatches(std::string_view bytes) { return TryBatches<3>(bytes, 8); }

}  // namespace dynmesh::fuzz
