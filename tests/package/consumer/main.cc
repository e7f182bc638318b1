// Makes a mesh, edits it and prints its hash.
#include <cstdio>
#include <cstring>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/quality.h"
#include "dynmesh/version.h"
#include "plate.h"

#if DYNMESH_VERSION < DYNMESH_MAKE_VERSION(0, 1, 0)
#error "dynmesh 0.1 or later"
#endif
static_assert(DYNMESH_VERSION_MAJOR == dynmesh::kVersionMajor);

int main() {
  // Headers and library are of one version.
  if (std::strcmp(dynmesh::LinkedVersion(), dynmesh::kVersion) != 0) return 2;
  if (dynmesh::LinkedVersionNumber() != DYNMESH_VERSION) return 3;
  const auto mesh = dynmesh::DynamicMesh::Create(PlateOptions());
  if (!mesh.ok()) return 1;
  for (const dynmesh::EditBatch& batch : {Plate(), Cut()}) {
    const auto diff = (*mesh)->Apply(batch);
    if (!diff.ok()) return std::puts(diff.status().ToString().c_str()), 1;
  }
  std::printf("%s %s\n", dynmesh::kVersion, (*mesh)->hash().ToHex().c_str());
}
