// The guarantees of DynamicMesh in 3D, tested from outside. tests/differential tests that it equals
// the mesh from scratch after every edit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "core/geometry/space_predicates.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "dynmesh/quality.h"
#include "tests/support/workload.h"

namespace dynmesh::space_mesh_test {
namespace {

using geometry::Point3;
using test::Distribution;

MeshOptions Space(double quality = kDefaultQuality3D) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = quality;
  return options;
}

std::map<VertexId, Point3> PlacesOf(const Mesh& mesh) {
  std::map<VertexId, Point3> places;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const double* c = &mesh.vertices.coordinates[3 * i];
    places[mesh.vertices.ids[i]] = {{c[0], c[1], c[2]}};
  }
  return places;
}

using Corners = std::array<Point3, 4>;
std::vector<Corners> TetrahedraOf(const Mesh& mesh) {
  const std::map<VertexId, Point3> places = PlacesOf(mesh);
  std::vector<Corners> all(mesh.simplex_count());
  for (std::size_t i = 0; i < mesh.simplices.size(); ++i) {
    all[i / 4][i % 4] = places.at(mesh.simplices[i]);
  }
  return all;
}

double LongestEdge(const Corners& t) {
  double longest2 = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      longest2 = std::max(longest2, geometry::SquaredDistance(t[i], t[j]));
    }
  }
  return std::sqrt(longest2);
}

// The options' least limit suffices for this, whatever the quality and the box.
TEST(SpaceMesh, OfTheBareBoxIsItsGridAndLittleElse) {
  for (const double rho : {1.2, 1.25, kDefaultQuality2D, 1.5, 1.9, 2.0, 3.0, 100.0}) {
    SCOPED_TRACE("rho " + std::to_string(rho));
    MeshOptions options = Space(rho);
    options.box = {{0.1, 0.2, -7}, {0.1 + rho, 0.3, -6}};
    const auto n = static_cast<std::uint64_t>(BorderVertices(options));
    const std::uint64_t border = n * n * n - (n - 2) * (n - 2) * (n - 2);
    options.limits.max_vertices = border * 3 / 2;
    const auto mesh = *DynamicMesh::Create(options);
    const MeshStats stats = mesh->Stats();
    EXPECT_GE(stats.vertices, border);
    EXPECT_LE(stats.vertices, options.limits.max_vertices);
    EXPECT_EQ(stats.features, 0u);
    EXPECT_EQ(stats.subsegments, 0u);
    EXPECT_EQ(stats.subfacets, 0u);
    const Mesh whole = mesh->Snapshot();
    EXPECT_EQ(whole.dimension, 3);
    EXPECT_EQ(stats.simplices, whole.simplex_count());
    const auto& owners = whole.vertices.owners;
    EXPECT_EQ(std::count(owners.begin(), owners.end(), kBoxFeature), border);
    const auto built = BuildMesh({}, options);
    ASSERT_TRUE(built.ok()) << built.status();
    EXPECT_EQ(built->hash, mesh->hash());
  }
}

class MeshOfSpace : public testing::TestWithParam<Distribution> {};

TEST_P(MeshOfSpace, KeepsItsPromises) {
  const std::uint64_t seed = 3;
  const std::vector<Feature> features = test::MakeFeatures(GetParam(), 150, seed);
  const MeshOptions options = Space();
  const auto built = BuildMesh(features, options);
  ASSERT_TRUE(built.ok()) << built.status();
  const QualityReport quality = MeasureQuality(*built, options);
  EXPECT_EQ(quality.over_rho, 0u);
  EXPECT_LE(quality.worst_radius_edge, 2 * (1 + 1e-6));
  // Positively oriented, and they fill the domain.
  const Box domain = DomainBox(options);
  double volume = 0;
  for (const Corners& t : TetrahedraOf(*built)) {
    ASSERT_GT(geometry::Orientation(t[0], t[1], t[2], t[3]), 0);
    volume += geometry::internal::Volume({t[0], t[1]}, {t[0], t[2]}, {t[0], t[3]}).det / 6;
  }
  EXPECT_NEAR(volume, std::pow(domain.hi[0] - domain.lo[0], 3), 1e-8 * volume);
  // Every point a vertex; what owns a subsegment is a chain of edges from end to end.
  std::map<Point3, FeatureId> owners;
  for (std::size_t i = 0; i < built->vertices.size(); ++i) {
    const double* c = &built->vertices.coordinates[3 * i];
    if (built->vertices.containing_dimensions[i] == 0) {
      owners[{{c[0], c[1], c[2]}}] = built->vertices.owners[i];
    }
  }
  std::map<FeatureId, Point3> points;
  for (const Feature& f : features) {
    if (f.kind != FeatureKind::kPoint) continue;
    points[f.id] = {{f.position[0], f.position[1], f.position[2]}};
    EXPECT_EQ(owners[points[f.id]], f.id);
  }
  std::set<std::pair<VertexId, VertexId>> edges;
  for (std::size_t t = 0; t < built->simplex_count(); ++t) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        edges.insert(std::minmax(built->simplices[4 * t + i], built->simplices[4 * t + j]));
      }
    }
  }
  const std::map<VertexId, Point3> places = PlacesOf(*built);
  std::map<FeatureId, double> lengths;
  for (std::size_t s = 0; s < built->subsegments.size(); ++s) {
    const VertexId a = built->subsegments.ends[2 * s], b = built->subsegments.ends[2 * s + 1];
    EXPECT_TRUE(edges.contains({a, b}));
    lengths[built->subsegments.owners[s]] +=
        std::sqrt(geometry::SquaredDistance(places.at(a), places.at(b)));
  }
  std::size_t segments = 0;
  for (const Feature& f : features) {
    if (f.kind != FeatureKind::kSegment) continue;
    ++segments;
    const double length =
        std::sqrt(geometry::SquaredDistance(points.at(f.ends[0]), points.at(f.ends[1])));
    EXPECT_NEAR(lengths[f.id], length, 1e-12);
  }
  EXPECT_EQ(lengths.size(), segments);
  EXPECT_EQ(segments > 0, test::HasSegments(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(All, MeshOfSpace, testing::ValuesIn(test::kSpaceDistributions),
                         [](const auto& given) { return NameOf(given.param); });

bool Holds(const Corners& t, const Point3& p) {
  for (std::size_t i = 0; i < 4; ++i) {
    Corners with = t;
    with[i] = p;
    if (geometry::Orientation(with[0], with[1], with[2], with[3]) < 0) return false;
  }
  return true;
}

TEST(SpaceMesh, LocatesPoints) {
  const std::uint64_t seed = 8;
  SCOPED_TRACE("seed " + std::to_string(seed));
  const auto mesh = *DynamicMesh::Create(Space());
  ASSERT_TRUE(mesh->Apply(AddAll(test::MakeFeatures(Distribution::kSpaceUniform, 50, seed))).ok());
  Mesh whole = mesh->Snapshot();
  const std::map<VertexId, Point3> places = PlacesOf(whole);
  std::set<std::array<VertexId, 4>> simplices;
  for (std::size_t t = 0; t < whole.simplex_count(); ++t) {
    const VertexId* v = &whole.simplices[4 * t];
    simplices.insert({v[0], v[1], v[2], v[3]});
  }
  test::Random random(seed);
  const Box domain = DomainBox(mesh->options());
  std::vector<double> points;
  for (int i = 0; i < 900; ++i) points.push_back(random.Unit() * 4 - 1);
  for (const double far : {domain.hi[0] + 1, domain.lo[0] - 1e-9}) {
    points.insert(points.end(), {0.5, 0.5, far});
  }
  for (const Feature& f : mesh->Features()) {
    points.insert(points.end(), f.position.begin(), f.position.end());
  }
  points.insert(points.end(), domain.hi.begin(), domain.hi.end());
  const SimplexColumn found = mesh->Locate(points);
  ASSERT_EQ(found.size() / 4, points.size() / 3);
  for (std::size_t i = 0; i < found.size() / 4; ++i) {
    const std::array<VertexId, 4> ids = {found[4 * i], found[4 * i + 1], found[4 * i + 2],
                                         found[4 * i + 3]};
    const bool outside = i == 300 || i == 301;
    ASSERT_EQ(ids == (std::array<VertexId, 4>{}), outside) << i;
    if (outside) continue;
    ASSERT_TRUE(simplices.contains(ids)) << i;
    const Corners t = {places.at(ids[0]), places.at(ids[1]), places.at(ids[2]), places.at(ids[3])};
    ASSERT_TRUE(Holds(t, {{points[3 * i], points[3 * i + 1], points[3 * i + 2]}})) << i;
  }
}

// No tetrahedron that meets the box has an edge longer than that. It meets the box if a corner is
// inside.
class MaxEdge : public testing::TestWithParam<double> {};

TEST_P(MaxEdge, HoldsInTheBox) {
  MeshOptions options = Space();
  options.max_edge = 0.2;
  options.min_dihedral = GetParam();
  const auto mesh = *DynamicMesh::Create(options);
  ASSERT_TRUE(mesh->Apply({Edit::Add(Feature::Point(1, 0.3, 0.4, 0.5))}).ok());
  const Mesh whole = mesh->Snapshot();
  EXPECT_EQ(MeasureQuality(whole, options).over_rho, 0u);
  std::size_t inside = 0;
  for (const Corners& t : TetrahedraOf(whole)) {
    const bool meets = std::any_of(t.begin(), t.end(), [](const Point3& p) {
      return *std::min_element(p.c.begin(), p.c.end()) >= 0 &&
             *std::max_element(p.c.begin(), p.c.end()) <= 1;
    });
    if (!meets) continue;
    ++inside;
    ASSERT_LE(LongestEdge(t), 0.2 * std::sqrt(2) * (1 + 1e-9));
  }
  EXPECT_GT(inside, 100u);
  EXPECT_EQ(BuildMesh(mesh->Features(), options)->hash, mesh->hash());
}

INSTANTIATE_TEST_SUITE_P(WithoutCuresAndWithThem, MaxEdge, testing::Values(0.0, 10.0));

TEST(SpaceMesh, IsFinerInSizingFeaturesAndAsBeforeWithoutThem) {
  const auto mesh = *DynamicMesh::Create(Space());
  ASSERT_TRUE(mesh->Apply(AddAll(test::MakeFeatures(Distribution::kSpaceUniform, 20, 5))).ok());
  const MeshHash before = mesh->hash();
  const Sizing ball = {SizeShape::kDisc, 0.1, 0.15, {}};
  const Sizing box = {SizeShape::kBox, 0.12, 0, {0.9, 0.9, 0.9}};
  const Sizing point = {SizeShape::kPoint, 0.01, 0, {}};
  const auto near = [](const Point3& p, const Point3& q) {
    return std::sqrt(geometry::SquaredDistance(p, q));
  };
  ASSERT_TRUE(mesh->Apply({Edit::Add(Feature::Size(101, {0.2, 0.2, 0.2}, ball)),
                           Edit::Add(Feature::Size(102, {0.7, 0.7, 0.6}, box)),
                           Edit::Add(Feature::Size(103, {0.2, 0.8, 0.8}, point))})
                  .ok());
  std::array<std::size_t, 3> met = {};
  for (const Corners& t : TetrahedraOf(mesh->Snapshot())) {
    double most = INFINITY;
    for (const Point3& p : t) {
      if (near(p, {{0.2, 0.2, 0.2}}) <= 0.15) ++met[0], most = std::min(most, 0.1);
      const bool in_box =
          p[0] >= 0.7 && p[0] <= 0.9 && p[1] >= 0.7 && p[1] <= 0.9 && p[2] >= 0.6 && p[2] <= 0.9;
      if (in_box) ++met[1], most = std::min(most, 0.12);
    }
    if (Holds(t, {{0.2, 0.8, 0.8}})) ++met[2], most = std::min(most, 0.01);
    ASSERT_LE(LongestEdge(t), most * std::sqrt(2) * (1 + 1e-9));
  }
  EXPECT_GT(met[0], 50u);
  EXPECT_GT(met[1], 50u);
  EXPECT_GT(met[2], 0u);
  ASSERT_TRUE(mesh->Apply({Edit::Remove(101), Edit::Remove(102), Edit::Remove(103)}).ok());
  EXPECT_EQ(mesh->hash(), before);
}

// Where exponents and mantissas end: the largest and the least boxes, and one far out.
TEST(SpaceMesh, OfTheMostExtremeBoxesIsGood) {
  struct Extreme {
    double origin, size;
  };
  const std::uint64_t seed = 6;
  for (const auto& [origin, size] :
       {Extreme{0, 0x1p150}, Extreme{-0x1p150, 0x1p150}, Extreme{0, 0x1p-110},
        Extreme{0x1p-95, 0x1p-110}, Extreme{1, 0x1p-30}, Extreme{0x1p149, 0x1p120}}) {
    SCOPED_TRACE(std::to_string(std::ilogb(size)) + " at " + std::to_string(origin));
    MeshOptions options = Space();
    for (std::size_t k = 0; k < 3; ++k) {
      options.box.lo[k] = origin;
      options.box.hi[k] = origin + size;
    }
    ASSERT_EQ(ValidateOptions(options), absl::OkStatus());
    std::vector<Feature> features = test::MakeFeatures(Distribution::kTurnedGridEdges, 27, seed);
    for (Feature& f : features) {
      for (double& c : f.position) c = origin + size * c;
    }
    const auto mesh = *DynamicMesh::Create(options);
    const auto diff = mesh->Apply(AddAll(features));
    ASSERT_TRUE(diff.ok()) << diff.status();
    EXPECT_EQ(MeasureQuality(mesh->Snapshot(), options).over_rho, 0u);
    EXPECT_EQ(mesh->Audit().problems, std::vector<std::string>());
    const FeatureId last = features.back().id;
    ASSERT_TRUE(mesh->Apply({Edit::Remove(last)}).ok());
    ASSERT_TRUE(mesh->Apply({Edit::Add(features.back())}).ok());
    EXPECT_EQ(mesh->hash(), diff->hash);
    EXPECT_EQ(BuildMesh(features, options)->hash, diff->hash);
  }
}

}  // namespace
}  // namespace dynmesh::space_mesh_test
