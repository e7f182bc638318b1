#include "dynmesh/version.h"

namespace dynmesh {

const char* LinkedVersion() { return kVersion; }
int LinkedVersionNumber() { return kVersionNumber; }

}  // namespace dynmesh
