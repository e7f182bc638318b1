// Small numbers for feature ids. Feature ids have 64 bits; some formats have 32-bit references
// (Gmsh's physical tags, Medit's references).
//
// The features that own a vertex, an edge or a face of the mesh are numbered from 1, by ascending
// id. The domain box comes after them; 0 is none. So the features 1..n of a `.node` or `.poly` file
// keep their numbers. Immutable.
#ifndef DYNMESH_CORE_IO_MESHES_REFERENCES_H_
#define DYNMESH_CORE_IO_MESHES_REFERENCES_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

class References {
 public:
  // INVALID_ARGUMENT if the mesh has more rows than 32 bits can number. O(n lg n).
  static absl::StatusOr<References> Of(const IndexedMesh& mesh);

  // REQUIRES: `owner` is one of the mesh's, the box or none. O(lg n).
  int Find(FeatureId owner) const;
  int box() const { return static_cast<int>(features_.size()) + 1; }
  // The feature of reference i + 1.
  const std::vector<FeatureId>& features() const { return features_; }
  // The name of a reference from 1 on: "feature 30" or "box".
  std::string Name(int reference) const;

 private:
  std::vector<FeatureId> features_;  // ascending
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_REFERENCES_H_
