// Files of a good 3D mesh, and its input.
#ifndef DYNMESH_TESTS_CLIENT_VERIFY_GOOD_FILES_H_
#define DYNMESH_TESTS_CLIENT_VERIFY_GOOD_FILES_H_

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "client/verify/verify.h"
#include "dynmesh/feature.h"
#include "tests/core/io/meshes/good_space_mesh.h"
#include "tests/support/seed.h"

namespace dynmesh::cli {

inline constexpr double kAnyQuality = 1e9;

struct GoodFiles {
  io::MeshFiles files;
  std::vector<Feature> features;
};

inline GoodFiles MakeGoodFiles(std::uint64_t seed, int count, bool tilted = true) {
  testing::GoodSpaceMesh good = testing::MakeGoodSpaceMesh(seed, count, tilted);
  GoodFiles result;
  result.files.mesh = io::IndexMesh(good.mesh).value();
  result.files.recorded_hash = good.mesh.hash;
  result.features = std::move(good.features);
  return result;
}

using test::NewSeed;

}  // namespace dynmesh::cli

#endif  // DYNMESH_TESTS_CLIENT_VERIFY_GOOD_FILES_H_
