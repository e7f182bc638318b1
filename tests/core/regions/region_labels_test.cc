// The polygons of each triangle, against testing every polygon, and the cost of edits of polygons.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/slot_mesh.h"
#include "tests/support/workload.h"

namespace dynmesh::region_labels_test {
namespace {

using Place = std::array<double, 2>;

// True if p is inside an odd number of the rings. In doubles: p must not be near an edge.
bool NaiveIsInside(const Place& p, const Rings& rings, const std::map<FeatureId, Place>& points) {
  bool inside = false;
  for (const auto& ring : rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Place& a = points.at(ring[i]);
      const Place& b = points.at(ring[(i + 1) % ring.size()]);
      if ((a[1] > p[1]) == (b[1] > p[1])) continue;
      if (a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) > p[0]) inside = !inside;
    }
  }
  return inside;
}

// The first triangle with another region than its middle has, or nothing.
std::string FindWrongRegion(const Mesh& mesh, const std::vector<Feature>& features) {
  std::map<FeatureId, Place> points;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) points[f.id] = {f.position[0], f.position[1]};
  }
  std::map<VertexId, Place> vertices;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const double* c = &mesh.vertices.coordinates[2 * i];
    vertices[mesh.vertices.ids[i]] = {c[0], c[1]};
  }
  for (std::size_t t = 0; t < mesh.simplex_count(); ++t) {
    Place middle = {0, 0};
    for (int k = 0; k < 3; ++k) {
      const Place& v = vertices.at(mesh.simplices[3 * t + static_cast<std::size_t>(k)]);
      middle[0] += v[0] / 3, middle[1] += v[1] / 3;
    }
    std::vector<FeatureId> inside;
    for (const Feature& f : features) {
      if (f.kind == FeatureKind::kPolygon && NaiveIsInside(middle, f.rings, points)) {
        inside.push_back(f.id);
      }
    }
    if (PolygonsOf(mesh.region(t), mesh.region_sets) != inside) {
      return "triangle at " + std::to_string(middle[0]) + ", " + std::to_string(middle[1]);
    }
  }
  return "";
}

TEST(RegionLabels, AreThoseOfEveryPlaceAfterEveryRevision) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int n = seed % 2 == 0 ? 16 : 60;
    test::ScriptGenerator script(test::Distribution::kPolygons, n, seed);
    const auto mesh = *DynamicMesh::Create({});
    auto replica = *SlotMesh::FromMesh(mesh->Snapshot());
    for (int revision = 0; revision < 40; ++revision) {
      const auto diff = mesh->Apply(script.Next(mesh->Features()));
      if (!diff.ok()) continue;
      Mesh whole = mesh->Snapshot();
      ASSERT_EQ(FindWrongRegion(whole, mesh->Features()), "");
      ASSERT_EQ(replica.Apply(*diff), absl::OkStatus());
      Mesh copy = replica.ToMesh();
      Canonicalize(whole);
      Canonicalize(copy);
      ASSERT_EQ(copy.simplices, whole.simplices);
      ASSERT_EQ(copy.regions, whole.regions);
      ASSERT_EQ(copy.region_sets, whole.region_sets);
    }
  }
}

// A square of a hundred or so triangles inside a larger mesh, made of segment features.
std::vector<Feature> SquareAmongPoints() {
  std::vector<Feature> features = test::MakeFeatures(test::Distribution::kUniform, 400, 3);
  std::erase_if(features, [](const Feature& f) {
    const double x = f.position[0], y = f.position[1];
    const auto on = [](double a) { return std::abs(a - 0.3) < 0.01 || std::abs(a - 0.7) < 0.01; };
    return on(x) || on(y);
  });
  for (int i = 0; i < 4; ++i) {
    const FeatureId id = 1001 + static_cast<FeatureId>(i);
    features.push_back(Feature::Point(id, i == 1 || i == 2 ? 0.7 : 0.3, i >= 2 ? 0.7 : 0.3));
    features.push_back(Feature::Segment(id + 10, id, i == 3 ? 1001 : id + 1));
  }
  return features;
}

std::size_t CountIn(const Mesh& mesh, FeatureId polygon) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.simplex_count(); ++t) count += mesh.region(t) == polygon;
  return count;
}

TEST(RegionLabels, APolygonOverSegmentsChangesLabelsInsideAndNothingElse) {
  const auto mesh = *DynamicMesh::Create({});
  ASSERT_TRUE(mesh->Apply(AddAll(SquareAmongPoints())).ok());
  const Mesh before = mesh->Snapshot();
  const auto added = mesh->Apply({Edit::Add(Feature::Polygon(2000, {{1001, 1002, 1003, 1004}}))});
  ASSERT_TRUE(added.ok()) << added.status();
  const Mesh with = mesh->Snapshot();
  const std::size_t inside = CountIn(with, 2000);
  EXPECT_GT(inside, 100u);
  EXPECT_EQ(added->added_simplices, added->removed_simplices);
  EXPECT_EQ(added->added_simplex_count(), inside);
  EXPECT_TRUE(added->removed_regions.empty());
  EXPECT_EQ(added->added_regions, RegionColumn(inside, 2000));
  EXPECT_TRUE(added->added_vertices.ids.empty());
  EXPECT_TRUE(added->added_subsegments.owners.empty());  // still owned by the segment features
  const auto removed = mesh->Apply({Edit::Remove(2000)});
  ASSERT_TRUE(removed.ok());
  EXPECT_EQ(mesh->hash(), before.hash);
  EXPECT_EQ(removed->removed_simplex_count(), inside);
}

TEST(RegionLabels, AnEditElsewhereCostsTheSameWithPolygonsAndWithout) {
  const auto mesh = *DynamicMesh::Create({});
  ASSERT_TRUE(mesh->Apply(AddAll(SquareAmongPoints())).ok());
  const auto plain = mesh->Apply({Edit::Add(Feature::Point(3000, 0.511, 0.533))});
  ASSERT_TRUE(mesh->Apply({Edit::Remove(3000)}).ok());
  ASSERT_TRUE(mesh->Apply({Edit::Add(Feature::Polygon(2000, {{1001, 1002, 1003, 1004}}))}).ok());
  const auto inside = mesh->Apply({Edit::Add(Feature::Point(3000, 0.511, 0.533))});
  ASSERT_TRUE(plain.ok() && inside.ok());
  EXPECT_EQ(inside->added_simplices, plain->added_simplices);
  EXPECT_EQ(inside->removed_simplices, plain->removed_simplices);
  EXPECT_EQ(inside->work.executed, plain->work.executed);
  EXPECT_EQ(inside->added_regions, RegionColumn(inside->added_simplex_count(), 2000));
}

// A corner jumps over an unchanged part of the mesh: the part changes its region.
TEST(RegionLabels, FollowACornerThatJumpsFar) {
  const auto mesh = *DynamicMesh::Create({});
  std::vector<Feature> features;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      features.push_back(Feature::Point(static_cast<FeatureId>(1 + 20 * i + j), 0.3 + 0.02 * i,
                                        0.3 + 0.01 * j + 0.003 * (i % 3)));
    }
  }
  features.push_back(Feature::Point(1001, 0.05, 0.05));
  features.push_back(Feature::Point(1002, 0.95, 0.05));
  features.push_back(Feature::Point(1003, 0.5, 0.1));
  features.push_back(Feature::Polygon(2000, {{1001, 1002, 1003}}));
  ASSERT_TRUE(mesh->Apply(AddAll(features)).ok());
  for (const double y : {0.9, 0.1, 0.95, 0.01}) {
    const auto moved = mesh->Apply({Edit::Move(1003, 0.5, y)});
    ASSERT_TRUE(moved.ok()) << moved.status();
    ASSERT_EQ(FindWrongRegion(mesh->Snapshot(), mesh->Features()), "") << "at y " << y;
    // Some stay and change their region: they are in both lists.
    std::set<std::array<VertexId, 3>> gone;
    for (std::size_t t = 0; t < moved->removed_simplex_count(); ++t) {
      const VertexId* v = &moved->removed_simplices[3 * t];
      gone.insert({v[0], v[1], v[2]});
    }
    std::size_t both = 0;
    for (std::size_t t = 0; t < moved->added_simplex_count(); ++t) {
      const VertexId* v = &moved->added_simplices[3 * t];
      both += gone.contains({v[0], v[1], v[2]});
    }
    EXPECT_GT(both, y == 0.01 ? 0u : 300u) << "at y " << y;
  }
}

TEST(RegionLabels, OwnersOfSharedEdgesAreTheSegmentThenTheLeastPolygon) {
  const auto mesh = *DynamicMesh::Create({});
  std::vector<Feature> features = SquareAmongPoints();
  std::erase_if(features, [](const Feature& f) { return f.kind == FeatureKind::kSegment; });
  features.push_back(Feature::Polygon(500'001, {{1001, 1002, 1003, 1004}}));
  features.push_back(Feature::Polygon(500'000, {{1001, 1002, 1003}}));
  ASSERT_TRUE(mesh->Apply(AddAll(features)).ok());
  const auto owners = [&] {
    const Mesh whole = mesh->Snapshot();
    std::set<FeatureId> ids(whole.subsegments.owners.begin(), whole.subsegments.owners.end());
    ids.erase(kBoxFeature);
    return ids;
  };
  EXPECT_EQ(owners(), (std::set<FeatureId>{500'000, 500'001}));
  const MeshHash two = mesh->hash();
  ASSERT_TRUE(mesh->Apply({Edit::Add(Feature::Segment(600'000, 1002, 1001))}).ok());
  EXPECT_EQ(owners(), (std::set<FeatureId>{500'000, 500'001, 600'000}));
  ASSERT_TRUE(mesh->Apply({Edit::Remove(600'000)}).ok());
  EXPECT_EQ(mesh->hash(), two);
  ASSERT_TRUE(mesh->Apply({Edit::Remove(500'000)}).ok());
  EXPECT_EQ(owners(), (std::set<FeatureId>{500'001}));
}

}  // namespace
}  // namespace dynmesh::region_labels_test
