// Makes a mesh, edits it and prints its hash.
#include <cstdio>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/quality.h"
#include "dynmesh/version.h"
#include "plate.h"

static_assert(DYNMESH_VERSION_MAJOR == dynmesh::kVersionMajor);

int main() {
  const auto mesh = dynmesh::DynamicMesh::Create(PlateOptions());
  if (!mesh.ok()) return 1;
  for (const dynmesh::EditBatch& batch : {Plate(), Cut()}) {
    const auto diff = (*mesh)->Apply(batch);
    if (!diff.ok()) return std::puts(diff.status().ToString().c_str()), 1;
  }
  std::printf("%s %s\n", dynmesh::kVersion, (*mesh)->hash().ToHex().c_str());
}
