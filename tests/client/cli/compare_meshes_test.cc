#include "client/cli/compare_meshes.h"

#include <algorithm>
#include <vector>

#include "gtest/gtest.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/core/mesh_data/made_up_mesh.h"

namespace dynmesh::cli {
namespace {

using testing::SampleMesh;
using testing::SampleMeshWithRegions;

TEST(CompareMeshes, AMeshIsTheSameAsItself) {
  Mesh other = SampleMesh();
  Canonicalize(other);
  const MeshComparison c = CompareMeshes(SampleMesh(), other);
  EXPECT_TRUE(c.Same());
  EXPECT_EQ(c.vertices.shared, 9U);
  EXPECT_EQ(c.simplices.shared, 11U);
  EXPECT_EQ(c.subsegments.shared, 7U);
}

TEST(CompareMeshes, CountsWhatIsInOneOnly) {
  Mesh other = SampleMesh();
  other.simplices.resize(30);  // one triangle fewer
  MeshComparison c = CompareMeshes(SampleMesh(), other);
  EXPECT_FALSE(c.Same());
  EXPECT_EQ(c.simplices.shared, 10U);
  EXPECT_EQ(c.simplices.only_a, 1U);
  EXPECT_EQ(c.simplices.only_b, 0U);
  c = CompareMeshes(other, SampleMesh());
  EXPECT_EQ(c.simplices.only_b, 1U);

  other = SampleMesh();
  other.vertices.owners[5] = 11;  // input point 10 has become 11
  c = CompareMeshes(SampleMesh(), other);
  EXPECT_FALSE(c.Same());
  EXPECT_EQ(c.remarked_vertices, 1U);
  EXPECT_EQ(c.vertices.shared, 9U);

  other = SampleMesh();
  other.subsegments.owners[0] = 31;
  c = CompareMeshes(SampleMesh(), other);
  EXPECT_EQ(c.subsegments.only_a, 1U);
  EXPECT_EQ(c.subsegments.only_b, 1U);
}

TEST(CompareMeshes, CountsTrianglesThatLieInOtherPolygons) {
  const Mesh labelled = SampleMeshWithRegions();
  EXPECT_TRUE(CompareMeshes(labelled, labelled).Same());
  MeshComparison c = CompareMeshes(SampleMesh(), labelled);
  EXPECT_FALSE(c.Same());
  EXPECT_EQ(c.simplices.shared, 11U);
  EXPECT_EQ(c.simplices.only_a, 0U);
  EXPECT_EQ(c.simplices.only_b, 0U);
  EXPECT_EQ(c.relabelled_simplices, 7U);
  Mesh other = labelled;
  other.regions[2] = 40;
  EXPECT_EQ(CompareMeshes(other, labelled).relabelled_simplices, 1U);
}

TEST(CompareMeshes, CountsWhatIsRemarkedInAnyOrderOfRows) {
  Mesh other = SampleMesh();
  for (FeatureId& owner : other.vertices.owners) ++owner;
  for (const MeshComparison& c :
       {CompareMeshes(SampleMesh(), other), CompareMeshes(other, SampleMesh())}) {
    EXPECT_EQ(c.remarked_vertices, 9U);
    EXPECT_EQ(c.vertices.only_a, 0U);
    EXPECT_EQ(c.vertices.only_b, 0U);
  }
}

TEST(CompareMeshes, CountsWhatIsRelabelledInAMuchLargerMesh) {
  const Mesh small = SampleMeshWithRegions();
  Mesh large = small;
  for (RegionId& region : large.regions) region = 40;
  auto random = testing::MakeRandom();
  std::vector<VertexId> more(50);
  for (VertexId& id : more) {
    id = random();
    large.vertices.ids.push_back(id);
    large.vertices.coordinates.insert(large.vertices.coordinates.end(), {1, 1});
    large.vertices.containing_dimensions.push_back(2);
    large.vertices.owners.push_back(kNoFeature);
  }
  const SimplexColumn rows = testing::internal::AnySimplices<3>(random, more, 200);
  large.simplices.insert(large.simplices.end(), rows.begin(), rows.end());
  large.regions.resize(large.simplex_count(), 40);
  for (const bool forward : {true, false}) {
    const MeshComparison c = forward ? CompareMeshes(small, large) : CompareMeshes(large, small);
    EXPECT_EQ(c.relabelled_simplices, 11U - std::ranges::count(small.regions, 40U));
    EXPECT_EQ(c.simplices.shared, 11U);
    EXPECT_EQ(forward ? c.simplices.only_a : c.simplices.only_b, 0U);
    EXPECT_EQ(forward ? c.simplices.only_b : c.simplices.only_a, 200U);
  }
}

TEST(CompareMeshes, CountsTetrahedraAndSubfacets) {
  auto random = testing::MakeRandom();
  const Mesh mesh = testing::MakeUpLabelledMesh(random, 30, 1, 3);
  EXPECT_TRUE(CompareMeshes(mesh, mesh).Same());
  Mesh other = mesh;
  other.subfacets.owners[3] += 1;
  MeshComparison c = CompareMeshes(mesh, other);
  EXPECT_FALSE(c.Same());
  EXPECT_EQ(c.subfacets.shared, 14U);
  EXPECT_EQ(c.subfacets.only_a, 1U);
  EXPECT_EQ(c.subfacets.only_b, 1U);
  other = mesh;
  other.regions[5] = 999;
  other.regions[9] = 999;
  other.simplices.resize(4 * 59);
  other.regions.resize(59);
  c = CompareMeshes(mesh, other);
  EXPECT_EQ(c.simplices.shared, 59U);
  EXPECT_EQ(c.simplices.only_a, 1U);
  EXPECT_EQ(c.relabelled_simplices, 2U);
}

}  // namespace
}  // namespace dynmesh::cli
