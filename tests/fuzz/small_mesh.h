// Meshing small inputs of any content, within a budget.
#ifndef DYNMESH_TESTS_FUZZ_SMALL_MESH_H_
#define DYNMESH_TESTS_FUZZ_SMALL_MESH_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::fuzz {

inline constexpr std::uint64_t kMostVertices = 300;
inline constexpr std::uint64_t kMostVerticesInSpace = 1000;  // the bare box alone has 386
inline constexpr std::size_t kMostFeatures = 60;

// Empty, or the fault: a refusal without a message, or a mesh with a wrong hash.
inline std::string MeshOrRefuse(const std::vector<Feature>& features, MeshOptions options) {
  if (features.size() > kMostFeatures) return "";
  options.limits.max_vertices = options.dimension == 3 ? kMostVerticesInSpace : kMostVertices;
  const absl::StatusOr<Mesh> mesh = BuildMesh(features, options);
  if (!mesh.ok()) return mesh.status().message().empty() ? "a refusal without a message" : "";
  return ComputeHash(*mesh) == mesh->hash ? "" : "the hash is not that of the parts";
}

// The parts of `bytes` between lines `---`.
inline std::vector<std::string_view> SplitFiles(std::string_view bytes) {
  constexpr std::string_view kSeparator = "\n---\n";
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = bytes.find(kSeparator);
    parts.push_back(bytes.substr(0, end));
    if (end == std::string_view::npos) return parts;
    bytes.remove_prefix(end + kSeparator.size());
  }
}

}  // namespace dynmesh::fuzz

#endif  // DYNMESH_TESTS_FUZZ_SMALL_MESH_H_
