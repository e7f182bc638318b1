// Meshes before the verifier of mesh files, which shares no code with a mesher. Needs
// dynmesh_verify.
#ifndef DYNMESH_TESTS_SUPPORT_JUDGED_H_
#define DYNMESH_TESTS_SUPPORT_JUDGED_H_

#include <string>
#include <vector>

#include "client/verify/verify.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::test {

// The findings on a mesh of quality `rho` of these features; empty if there are none.
inline std::string Judged(const Mesh& mesh, double rho, const std::vector<Feature>& features) {
  io::MeshFiles files;
  files.mesh = io::IndexMesh(mesh).value();
  files.recorded_hash = mesh.hash;
  const cli::VerifyReport report = cli::VerifyMesh(files, rho, &features);
  std::string wrong;
  for (const cli::VerifyCheck& check : report.checks) {
    if (check.failures > 0) wrong += check.name + ": " + check.examples.front() + "\n";
  }
  return report.Passed() ? "" : "the judge: " + wrong;
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_JUDGED_H_
