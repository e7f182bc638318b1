// Meshes that are valid for code that knows only rows and hashes: random ids, rows that do not form
// a triangulation.
#ifndef DYNMESH_TESTS_CORE_MESH_DATA_MADE_UP_MESH_H_
#define DYNMESH_TESTS_CORE_MESH_DATA_MADE_UP_MESH_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "core/mesh_data/constraints.h"
#include "dynmesh/mesh.h"
#include "tests/support/seed.h"

namespace dynmesh::testing {

using Random = std::mt19937_64;

// A new seed each run, printed, so that a failure can be replayed.
inline Random MakeRandom() { return Random(test::NewSeed()); }

inline constexpr int kDimensions[] = {2, 3};

namespace internal {

// `count` different rows of kIds of the vertices, ascending.
template <std::size_t kIds>
std::set<std::array<VertexId, kIds>> AnyRows(Random& random, const std::vector<VertexId>& ids,
                                             std::size_t count) {
  std::set<std::array<VertexId, kIds>> rows;
  while (rows.size() < count) {
    std::array<VertexId, kIds> row;
    for (VertexId& id : row) id = ids[random() % ids.size()];
    std::sort(row.begin(), row.end());
    if (std::adjacent_find(row.begin(), row.end()) == row.end()) rows.insert(row);
  }
  return rows;
}

// Ascending is canonical; half of them are turned over.
template <std::size_t kIds>
SimplexColumn AnySimplices(Random& random, const std::vector<VertexId>& ids, std::size_t count) {
  SimplexColumn simplices;
  for (auto row : AnyRows<kIds>(random, ids, count)) {
    if (random() % 2 == 0) std::swap(row[kIds - 1], row[kIds - 2]);
    simplices.insert(simplices.end(), row.begin(), row.end());
  }
  return simplices;
}

template <class Columns>
Columns AnyConstraints(Random& random, const std::vector<VertexId>& ids, std::size_t count) {
  constexpr std::size_t kIds = mesh_data::kCorners<Columns>;
  Columns columns;
  for (const auto& row : AnyRows<kIds>(random, ids, count)) {
    mesh_data::IdsOf(columns).insert(mesh_data::IdsOf(columns).end(), row.begin(), row.end());
    columns.owners.push_back(1 + random() % 3);
  }
  return columns;
}

}  // namespace internal

// Of few values and ids, so that two meshes share some.
inline LabelColumn AnyLabels(Random& random) {
  static const char* const kNames[] = {"", "a", "Inlet"};
  LabelColumn labels;
  for (FeatureId id = 1; id < 12; id += 1 + random() % 3) {
    const LabelOfFeature row = {
        id, {static_cast<std::int64_t>(random() % 3) - 1, kNames[random() % 3]}};
    if (!row.label.empty()) labels.push_back(row);
  }
  return labels;
}

// `count` vertices on a grid of some 1,600 positions (so that two meshes share some), twice as many
// simplices, half as many subsegments and, in 3D, subfacets; and labels.
inline Mesh MakeUpMesh(Random& random, int count, std::uint64_t revision, int dimension = 2) {
  Mesh mesh;
  mesh.dimension = dimension;
  mesh.revision = revision;
  const std::uint64_t side = dimension == 2 ? 40 : 12;
  std::set<std::vector<double>> places;
  while (static_cast<int>(places.size()) < count) {
    std::vector<double> place;
    for (int k = 0; k < dimension; ++k) place.push_back(static_cast<double>(random() % side));
    places.insert(place);
  }
  const auto free = static_cast<std::uint8_t>(dimension);
  for (const auto& place : places) {
    mesh.vertices.ids.push_back(VertexIdAt(place.data(), dimension));
    mesh.vertices.coordinates.insert(mesh.vertices.coordinates.end(), place.begin(), place.end());
    const auto containing = static_cast<std::uint8_t>(random() % (free + 1U));
    mesh.vertices.containing_dimensions.push_back(containing);
    mesh.vertices.owners.push_back(containing == free ? kNoFeature : 1 + random() % 3);
  }
  const std::vector<VertexId>& ids = mesh.vertices.ids;
  const auto n = static_cast<std::size_t>(count);
  mesh.simplices = dimension == 2 ? internal::AnySimplices<3>(random, ids, 2 * n)
                                  : internal::AnySimplices<4>(random, ids, 2 * n);
  mesh.subsegments = internal::AnyConstraints<SubsegmentColumns>(random, ids, n / 2);
  if (dimension == 3) {
    mesh.subfacets = internal::AnyConstraints<SubfacetColumns>(random, ids, n / 2);
  }
  mesh.labels = AnyLabels(random);
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

inline Mesh MakeUpLabelledMesh(Random& random, int count, std::uint64_t revision,
                               int dimension = 2) {
  Mesh mesh = MakeUpMesh(random, count, revision, dimension);
  Label(random, mesh);
  return mesh;
}

// Same rows in the same order, revision and hash.
inline bool Identical(const Mesh& a, const Mesh& b) {
  return a.dimension == b.dimension && a.revision == b.revision && a.vertices == b.vertices &&
         a.simplices == b.simplices && a.regions == b.regions && a.region_sets == b.region_sets &&
         a.subsegments == b.subsegments && a.subfacets == b.subfacets && a.labels == b.labels &&
         a.hash == b.hash;
}

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_MESH_DATA_MADE_UP_MESH_H_
