// Rows with any content, for writers: every kind of double, owners from 1 to 2^64 - 2 and the
// box, regions. No valid mesh.
#ifndef DYNMESH_TESTS_CORE_IO_MESHES_ANY_MESH_H_
#define DYNMESH_TESTS_CORE_IO_MESHES_ANY_MESH_H_

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::testing {

inline io::IndexedMesh AnyMesh(std::uint64_t seed, std::uint32_t vertices) {
  std::mt19937_64 random(seed);
  using Limits = std::numeric_limits<double>;
  const double special[] = {
      0.0, -0.0,   Limits::min(), Limits::denorm_min(), Limits::max(), -Limits::denorm_min(),
      0.1, 1.0 / 3};
  const auto coordinate = [&] {
    for (;;) {
      const double c = random() % 4 == 0 ? special[random() % 8] : std::bit_cast<double>(random());
      if (std::isfinite(c)) return c;
    }
  };
  const auto owner = [&]() -> FeatureId {
    switch (random() % 4) {
      case 0:
        return kBoxFeature;
      case 1:
        return 1 + random() % 50;
      default:
        return std::clamp<FeatureId>(random(), 1, kBoxFeature - 1);
    }
  };
  io::IndexedMesh mesh;
  for (std::uint32_t i = 0; i < vertices; ++i) {
    const int dimension = static_cast<int>(random() % 3);
    const double x = coordinate();
    mesh.vertices.push_back({x, coordinate(), dimension, dimension == 2 ? kNoFeature : owner()});
  }
  mesh.regions.polygons = {{1}, {1, 7, kBoxFeature - 1}, {7}};
  for (std::uint32_t i = 0; i + 2 < vertices; ++i) {
    // In runs, as no triangle of a real mesh has a neighbour across a free vertex elsewhere.
    mesh.regions.numbers.push_back(i / 50 % 4);
    mesh.triangles.push_back({i, i + 2, i + 1});
    mesh.edges.push_back({i, i + 1, random() % 2 == 0 ? kNoFeature : owner()});
  }
  return mesh;
}

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_IO_MESHES_ANY_MESH_H_
