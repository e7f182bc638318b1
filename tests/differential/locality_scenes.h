// Scenes of any size in which an edit must stay local: points and segments beside long segments,
// areas with a target length, sizes without effect.
#ifndef DYNMESH_TESTS_DIFFERENTIAL_LOCALITY_SCENES_H_
#define DYNMESH_TESTS_DIFFERENTIAL_LOCALITY_SCENES_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::test {

struct Scene {
  MeshOptions options;
  std::vector<Feature> features;
  std::vector<EditBatch> edits;  // one after the other
};

struct LocalityScene {
  const char* name;
  Scene (*make)(int n);
  int n, large;                // two sizes; the larger mesh has about 16 times the vertices
  std::uint64_t executed = 0;  // operations that one edit runs at most, at either size
  std::size_t vertices = 0;    // that come or go in one edit at most
};
const std::vector<LocalityScene>& LocalityScenes();

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_DIFFERENTIAL_LOCALITY_SCENES_H_
