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
// All of them.
const std::vector<LocalityScene>& LocalityScenes();
// Those with facets, in 3D.
std::vector<LocalityScene> SpaceLocalityScenes();

// --- For the makers of scenes -----------------------------------------------------------------

inline constexpr FeatureId kFar = 10'000'000;  // ids of what the edits bring

inline FeatureId Id(int i) { return static_cast<FeatureId>(i); }

// Adds the feature and takes it out again.
inline void InAndOut(const Feature& feature, Scene& scene) {
  scene.edits.push_back({Edit::Add(feature)});
  scene.edits.push_back({Edit::Remove(feature.id)});
}
// Takes out the feature and puts it back.
inline void OutAndIn(const Feature& feature, Scene& scene) {
  scene.edits.push_back({Edit::Remove(feature.id)});
  scene.edits.push_back({Edit::Add(feature)});
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_DIFFERENTIAL_LOCALITY_SCENES_H_
