// Scenes of any size with the features that a benchmark edits: points, segments, polygons, long
// ones among them.
#ifndef DYNMESH_TESTS_BENCH_EDIT_SCENES_H_
#define DYNMESH_TESTS_BENCH_EDIT_SCENES_H_

#include <cstddef>
#include <string>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh {

struct EditScene {
  std::string name;
  int dimension = 2;
  std::vector<Feature> features;
  // Rows of `features` that no other feature needs.
  std::vector<std::size_t> edited;
};

// The names of all scenes, 2D first.
std::vector<std::string> EditSceneNames();
// The greatest `n` of which the mesh is not enormous. REQUIRES: `name` is one of EditSceneNames.
int MostFeatures(const std::string& name);
// About `n` features. REQUIRES: the same.
EditScene MakeEditScene(const std::string& name, int n);

}  // namespace dynmesh

#endif  // DYNMESH_TESTS_BENCH_EDIT_SCENES_H_
