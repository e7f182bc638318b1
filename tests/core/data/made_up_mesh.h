// Meshes that look right to everything that knows only rows and hashes: random ids,
// rows that are no triangulation of anything.
#ifndef DYNMESH_TESTS_CORE_DATA_MADE_UP_MESH_H_
#define DYNMESH_TESTS_CORE_DATA_MADE_UP_MESH_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <iostream>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "dynmesh/mesh.h"

namespace dynmesh::testing {

using Random = std::mt19937_64;

// A new seed each run, printed, so that a failure can be replayed.
inline Random MakeRandom() {
  const std::uint64_t seed = std::random_device{}();
  std::cout << "seed " << seed << "\n";
  return Random(seed);
}

// `count` vertices on a grid of 40 x 40 places (so that two meshes share some), twice
// as many simplices, half as many subsegments.
inline Mesh MakeUpMesh(Random& random, int count, std::uint64_t revision) {
  Mesh mesh;
  mesh.revision = revision;
  std::set<std::array<double, 2>> places;
  while (static_cast<int>(places.size()) < count) {
    places.insert({static_cast<double>(random() % 40), static_cast<double>(random() % 40)});
  }
  for (const auto& place : places) {
    mesh.vertices.ids.push_back(VertexIdAt(place.data(), 2));
    mesh.vertices.coordinates.insert(mesh.vertices.coordinates.end(), place.begin(), place.end());
    const auto dimension = static_cast<std::uint8_t>(random() % 3);
    mesh.vertices.containing_dimensions.push_back(dimension);
    mesh.vertices.owners.push_back(dimension == 2 ? kNoFeature : 1 + random() % 3);
  }
  const auto any = [&] { return mesh.vertices.ids[random() % mesh.vertices.size()]; };
  std::set<std::array<VertexId, 3>> simplices;
  while (static_cast<int>(simplices.size()) < 2 * count) {
    std::array<VertexId, 3> s = {any(), any(), any()};
    if (s[0] == s[1] || s[1] == s[2] || s[2] == s[0]) continue;
    std::rotate(s.begin(), std::min_element(s.begin(), s.end()), s.end());
    simplices.insert(s);
  }
  for (const auto& s : simplices) {
    mesh.simplices.insert(mesh.simplices.end(), s.begin(), s.end());
  }
  std::set<std::array<VertexId, 2>> subsegments;
  while (static_cast<int>(subsegments.size()) < count / 2) {
    const VertexId a = any();
    const VertexId b = any();
    if (a != b) subsegments.insert({std::min(a, b), std::max(a, b)});
  }
  for (const auto& s : subsegments) {
    mesh.subsegments.ends.insert(mesh.subsegments.ends.end(), s.begin(), s.end());
    mesh.subsegments.owners.push_back(1 + random() % 3);
  }
  mesh.hash = ComputeHash(mesh);
  return mesh;
}

// Puts each simplex into none to three of the polygons 101 to 104.
inline void Label(Random& random, Mesh& mesh) {
  std::map<RegionId, std::vector<FeatureId>> sets;
  mesh.regions.clear();
  for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
    std::set<FeatureId> in;
    for (auto n = random() % 4; n > 0; --n) in.insert(101 + random() % 4);
    const std::vector<FeatureId> polygons(in.begin(), in.end());
    mesh.regions.push_back(RegionIdOf(polygons));
    if (polygons.size() > 1) sets[mesh.regions.back()] = polygons;
  }
  mesh.region_sets.clear();
  for (const auto& [id, polygons] : sets) mesh.region_sets.push_back({id, polygons});
  mesh.hash = ComputeHash(mesh);
}

inline Mesh MakeUpLabelledMesh(Random& random, int count, std::uint64_t revision) {
  Mesh mesh = MakeUpMesh(random, count, revision);
  Label(random, mesh);
  return mesh;
}

// Same rows in the same order, revision and hash.
inline bool Identical(const Mesh& a, const Mesh& b) {
  return a.dimension == b.dimension && a.revision == b.revision && a.vertices == b.vertices &&
         a.simplices == b.simplices && a.regions == b.regions && a.region_sets == b.region_sets &&
         a.subsegments == b.subsegments && a.hash == b.hash;
}

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_DATA_MADE_UP_MESH_H_
