// Locate against a search of all simplices, at points that many simplices share.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "core/geometry/predicates.h"
#include "core/geometry/space_predicates.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::locate_test {
namespace {

template <int D>
using Ids = std::array<VertexId, D + 1>;

// The least row of `mesh.simplices` whose simplex contains p; zeros if none does.
template <int D>
Ids<D> LeastThatContains(const Mesh& mesh,
                         const std::map<VertexId, geometry::Point<D>>& position_of,
                         const geometry::Point<D>& p) {
  Ids<D> least = {};
  for (std::size_t t = 0; t < mesh.simplex_count(); ++t) {
    Ids<D> ids;
    std::copy_n(&mesh.simplices[t * (D + 1)], D + 1, ids.begin());
    std::array<geometry::Point<D>, D + 1> corners;
    std::ranges::transform(ids, corners.begin(), [&](VertexId v) { return position_of.at(v); });
    bool holds = true;
    for (std::size_t i = 0; i <= D && holds; ++i) {
      auto with = corners;
      with[i] = p;
      holds = std::apply([](const auto&... c) { return geometry::Orientation(c...); }, with) >= 0;
    }
    if (holds && (least == Ids<D>{} || ids < least)) least = ids;
  }
  return least;
}

// At all vertices, and at the points of a lattice, some of them outside the domain.
template <int D>
void ExpectLeast(const DynamicMesh& mesh, int lattice) {
  const Mesh whole = mesh.Snapshot();
  std::map<VertexId, geometry::Point<D>> position_of;
  std::vector<double> points = whole.vertices.coordinates;
  for (std::size_t i = 0; i < whole.vertices.size(); ++i) {
    std::copy_n(&points[D * i], D, position_of[whole.vertices.ids[i]].c.begin());
  }
  const Box domain = DomainBox(mesh.options());
  int count = 1;
  for (int k = 0; k < D; ++k) count *= lattice + 1;
  for (int i = 0; i < count; ++i) {
    for (int k = 0, rest = i; k < D; ++k, rest /= lattice + 1) {
      const auto axis = static_cast<std::size_t>(k);
      const double side = domain.hi[axis] - domain.lo[axis];
      points.push_back(domain.lo[axis] + side * (rest % (lattice + 1)) / (lattice - 1));
    }
  }
  const SimplexColumn found = mesh.Locate(points);
  ASSERT_EQ(found.size() / (D + 1), points.size() / D);
  std::size_t outside = 0;
  for (std::size_t i = 0; i < points.size() / D; ++i) {
    geometry::Point<D> p;
    std::copy_n(&points[D * i], D, p.c.begin());
    Ids<D> ids;
    std::copy_n(&found[i * (D + 1)], D + 1, ids.begin());
    ASSERT_EQ(ids, (LeastThatContains<D>(whole, position_of, p))) << i;
    outside += ids == Ids<D>{};
  }
  EXPECT_GT(outside, 0u);
}

EditBatch Grid(int dimension, int side) {
  EditBatch batch;
  const auto at = [&](int i) { return (i + 0.5) / side; };
  FeatureId id = 0;
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      if (dimension == 2) batch.push_back(Edit::Add(Feature::Point(++id, at(x), at(y))));
      for (int z = 0; z < side && dimension == 3; ++z) {
        batch.push_back(Edit::Add(Feature::Point(++id, at(x), at(y), at(z))));
      }
    }
  }
  return batch;
}

TEST(Locate, In2DFindsTheSimplexWhoseIdsAreTheLeast) {
  MeshOptions options;
  const auto mesh = *DynamicMesh::Create(options);
  ASSERT_TRUE(mesh->Apply(Grid(2, 4)).ok());
  ExpectLeast<2>(*mesh, 25);
  ASSERT_TRUE(mesh->Apply({Edit::Remove(6), Edit::Add(Feature::Point(100, 0.25, 0.5))}).ok());
  ExpectLeast<2>(*mesh, 25);
}

TEST(Locate, In3DFindsTheSimplexWhoseIdsAreTheLeast) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = 2;
  const auto mesh = *DynamicMesh::Create(options);
  ASSERT_TRUE(mesh->Apply(Grid(3, 2)).ok());
  ExpectLeast<3>(*mesh, 13);
  ASSERT_TRUE(mesh->Apply({Edit::Remove(3), Edit::Add(Feature::Point(100, 0.5, 0.5, 0.5))}).ok());
  ExpectLeast<3>(*mesh, 13);
}

}  // namespace
}  // namespace dynmesh::locate_test
