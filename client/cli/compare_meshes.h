// Compares two meshes of one dimension. Vertices are equal if their coordinates are; simplices,
// subsegments and subfacets are equal if their vertices (and feature) are.
#ifndef DYNMESH_CLIENT_CLI_COMPARE_MESHES_H_
#define DYNMESH_CLIENT_CLI_COMPARE_MESHES_H_

#include <cstdint>

#include "dynmesh/mesh.h"

namespace dynmesh::cli {

struct MeshComparison {
  struct Part {
    std::uint64_t shared = 0;
    std::uint64_t only_a = 0;
    std::uint64_t only_b = 0;
  };
  Part vertices;
  Part simplices;
  Part subsegments;
  Part subfacets;
  std::uint64_t remarked_vertices = 0;     // shared, but with another owner or containing dimension
  std::uint64_t relabelled_simplices = 0;  // shared, but in other polygons
  MeshHash hash_a;
  MeshHash hash_b;

  bool Same() const;
};

// O(n lg n).
MeshComparison CompareMeshes(const Mesh& a, const Mesh& b);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_COMPARE_MESHES_H_
