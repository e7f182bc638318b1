// Facets in 3D diffs: changes of input made by hand go to refinement and result in subfacets. A
// replica follows the diffs, and everything is as from scratch; every facet is covered by its
// subfacets.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/dynamic_mesh/diff_builder.h"
#include "core/dynamic_mesh/feature_table.h"
#include "core/meshing/refinement.h"
#include "dynmesh/slot_mesh.h"
#include "tests/support/workload.h"

namespace dynmesh::facet_diffs_test {
namespace {

using Delta = plc::Delta<3>;
using geometry::Point3;

MeshOptions Options() {
  MeshOptions options;
  options.dimension = 3;
  options.quality = kDefaultQuality3D;
  return options;
}

// Squares of a grid on three planes through the box, two of them sharing edges, and points. Each
// possible feature has its id.
class Input {
 public:
  static constexpr int kSide = 2, kPlanes = 3;  // squares along a side
  static constexpr double kStep = 0.3;

  std::map<FeatureId, Point3> points;
  std::map<FeatureId, std::vector<FeatureId>> facets;  // one ring each

  // A corner of the grid of a plane; plane 1 stands on the first column of plane 0.
  static Point3 Corner(int plane, int i, int j) {
    const double x = 0.2 + i * kStep, y = 0.2 + j * kStep;
    if (plane == 0) return {{x, y, 0.25}};
    if (plane == 1) return {{0.2, y, 0.25 + i * kStep}};
    return {{0.9, 0.1 + i * kStep, 0.2 + j * kStep}};
  }
  static FeatureId CornerId(int plane, int i, int j) {
    if (plane == 1 && i == 0) plane = 0;  // shared
    return static_cast<FeatureId>(100 + 20 * plane + 4 * i + j);
  }
  void ToggleSquare(int plane, int i, int j) {
    const auto id = static_cast<FeatureId>(1000 + 20 * plane + 4 * i + j);
    if (facets.erase(id) > 0) return;
    facets[id] = {CornerId(plane, i, j), CornerId(plane, i + 1, j), CornerId(plane, i + 1, j + 1),
                  CornerId(plane, i, j + 1)};
    for (int k = 0; k < 4; ++k) {
      const int di = k == 1 || k == 2, dj = k >= 2;
      points[CornerId(plane, i + di, j + dj)] = Corner(plane, i + di, j + dj);
    }
  }

  // Edges of facets, with the facets that have them.
  std::map<plc::EdgeKey, std::vector<FeatureId>> Edges() const {
    std::map<plc::EdgeKey, std::vector<FeatureId>> edges;
    for (const auto& [id, ring] : facets) {
      for (std::size_t k = 0; k < ring.size(); ++k) {
        edges[plc::KeyOf(ring[k], ring[(k + 1) % ring.size()])].push_back(id);
      }
    }
    return edges;
  }
  plc::FacetFeature FacetOf(FeatureId id) const {
    plc::FacetFeature facet = {id, {facets.at(id)}, {{}}};
    for (const FeatureId corner : facets.at(id)) facet.positions[0].push_back(points.at(corner));
    return facet;
  }
};

// The changes from one input to another.
Delta Between(const Input& from, const Input& to) {
  Delta delta;
  for (const auto& [id, p] : from.points) {
    if (!to.points.contains(id)) delta.removed_points.push_back({id, p});
  }
  for (const auto& [id, p] : to.points) {
    if (!from.points.contains(id)) delta.added_points.push_back({id, p});
  }
  const auto segments = [](const Input& input) {
    std::vector<plc::SegmentFeature<3>> all;
    for (const auto& [key, polygons] : input.Edges()) {
      all.push_back({polygons[0], key.first, key.second, input.points.at(key.first),
                     input.points.at(key.second), polygons});
    }
    return all;
  };
  const auto before = segments(from), after = segments(to);
  for (const auto& s : before) {
    if (std::find(after.begin(), after.end(), s) == after.end()) {
      delta.removed_segments.push_back(s);
    }
  }
  for (const auto& s : after) {
    if (std::find(before.begin(), before.end(), s) == before.end()) {
      delta.added_segments.push_back(s);
    }
  }
  for (const auto& [id, ring] : from.facets) {
    if (!to.facets.contains(id)) delta.removed_facets.push_back(from.FacetOf(id));
  }
  for (const auto& [id, ring] : to.facets) {
    if (!from.facets.contains(id)) delta.added_facets.push_back(to.FacetOf(id));
  }
  return delta;
}

struct State {
  DiffBuilder<3> diffs;
  FeatureTable<3> features;
  meshing::Refinement<3, sac::Engine> refinement{Options(), nullptr};

  State() { refinement.complex().ResetToDomain(&diffs.triangulation()); }
  Mesh Begin(const Input& input) {
    features.Apply(Between({}, input), refinement);
    refinement.Propagate([] { return false; });
    Mesh mesh = diffs.Begin(refinement, features);
    features.Collect();
    Canonicalize(mesh);
    return mesh;
  }
  MeshDiff Apply(const Delta& delta) {
    features.Apply(delta, refinement);
    refinement.Propagate([] { return false; });
    MeshDiff diff = diffs.Update(refinement, features);
    features.Collect();
    return diff;
  }
};

double AreaOf(const Mesh& mesh, FeatureId facet) {
  std::map<VertexId, Point3> places;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const double* c = &mesh.vertices.coordinates[3 * i];
    places[mesh.vertices.ids[i]] = {{c[0], c[1], c[2]}};
  }
  double area = 0;
  for (std::size_t f = 0; f < mesh.subfacets.size(); ++f) {
    if (mesh.subfacets.owners[f] != facet) continue;
    const auto at = [&](std::size_t k) { return places.at(mesh.subfacets.corners[3 * f + k]); };
    const geometry::Vector3 u = geometry::Difference(at(1).c, at(0).c),
                            w = geometry::Difference(at(2).c, at(0).c),
                            normal = geometry::Cross(u, w);
    area += std::sqrt(geometry::Dot(normal, normal)) / 2;
  }
  return area;
}

TEST(FacetDiffs, AreFromScratchAndCoverFacetsAfterEveryChange) {
  constexpr std::uint64_t kSeed = 12;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  test::Random random(kSeed);
  Input input;
  State state;
  SlotMesh replica = *SlotMesh::FromMesh(state.Begin(input));
  std::size_t most = 0;
  for (int revision = 0; revision < 25; ++revision) {
    SCOPED_TRACE("revision " + std::to_string(revision));
    const Input before = input;
    for (int k = 1 + random.Below(2); k > 0; --k) {
      input.ToggleSquare(random.Below(Input::kPlanes), random.Below(Input::kSide),
                         random.Below(Input::kSide));
    }
    const auto id = static_cast<FeatureId>(1 + random.Below(20));
    if (input.points.erase(id) == 0) {
      const double x = 0.4 + 0.4 * random.Unit(), y = random.Unit();
      input.points[id] = {{x, y, 0.3 + 0.5 * random.Unit()}};
    }
    MeshDiff diff = state.Apply(Between(before, input));
    diff.from_revision = static_cast<std::uint64_t>(revision);
    diff.to_revision = diff.from_revision + 1;
    ASSERT_EQ(replica.Apply(diff), absl::OkStatus());
    Mesh copy = replica.ToMesh(), whole = state.diffs.Snapshot(state.refinement, state.features);
    Canonicalize(copy);
    Canonicalize(whole);
    State scratch;
    const Mesh fresh = scratch.Begin(input);
    for (const Mesh* other : std::array<const Mesh*, 2>{&copy, &fresh}) {
      ASSERT_EQ(other->vertices, whole.vertices);
      ASSERT_EQ(other->simplices, whole.simplices);
      ASSERT_EQ(other->subsegments, whole.subsegments);
      ASSERT_EQ(other->subfacets, whole.subfacets);
      ASSERT_EQ(other->hash, whole.hash);
    }
    ASSERT_EQ(state.diffs.subfacet_count(), whole.subfacets.size());
    for (const auto& [facet, ring] : input.facets) {
      ASSERT_NEAR(AreaOf(whole, facet), Input::kStep * Input::kStep, 1e-9);
    }
    if (input.facets.empty()) {
      ASSERT_EQ(whole.subfacets.size(), 0u);
    }
    // Undone and done again before the diff is taken: nothing has changed.
    const Delta there = Between(before, input);
    state.features.Apply(there.Inverse(), state.refinement);
    state.refinement.Propagate([] { return false; });
    const MeshDiff nothing = state.Apply(there);
    ASSERT_EQ(nothing.hash, whole.hash);
    ASSERT_TRUE(nothing.added_subfacets.owners.empty());
    ASSERT_TRUE(nothing.removed_subfacets.owners.empty());
    most = std::max(most, whole.subfacets.size());
  }
  EXPECT_GT(most, 20u);
}

}  // namespace
}  // namespace dynmesh::facet_diffs_test
