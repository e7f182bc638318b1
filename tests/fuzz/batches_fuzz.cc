#include "tests/fuzz/batches.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {

std::string FuzzBatches(std::string_view bytes) { return TryBatches<2>(bytes, 24); }

}  // namespace dynmesh::fuzz
