// Memory follows the present features: it is released when features are removed.
#include <gtest/gtest.h>
#include <malloc.h>

#include <memory>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "tests/support/workload.h"

namespace dynmesh::memory_test {
namespace {

constexpr int kPoints = 600;

MeshOptions Options(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  if (dimension == 3) options.quality = 2;
  options.box = {{0, 0, 0}, {1, 1, dimension == 3 ? 1.0 : 0.0}};
  return options;
}

std::vector<Feature> RandomPoints(int dimension, test::Random& random) {
  std::vector<Feature> points;
  for (int i = 0; i < kPoints; ++i) {
    const double x = random.Unit(), y = random.Unit();
    points.push_back(Feature::Point(static_cast<FeatureId>(i) + 1, x, y));
    if (dimension == 3) points.back().position[2] = random.Unit();
  }
  return points;
}

std::uint64_t BytesOf(const DynamicMesh& mesh) {
  const MeshStats stats = mesh.Stats();
  return stats.trace_bytes + stats.mesh_bytes;
}

class Memory : public testing::TestWithParam<int> {};

TEST_P(Memory, OfAMeshFromWhichAllIsRemovedIsThatOfAFreshOne) {
  test::Random random(GetParam());
  const auto fresh = *DynamicMesh::Create(Options(GetParam()));
  const auto mesh = *DynamicMesh::Create(Options(GetParam()));
  const std::vector<Feature> points = RandomPoints(GetParam(), random);
  for (const Feature& point : points) ASSERT_TRUE(mesh->Apply({Edit::Add(point)}).ok());
  const std::uint64_t most = BytesOf(*mesh);
  EXPECT_GT(most, 3 * BytesOf(*fresh));
  for (const Feature& point : points) ASSERT_TRUE(mesh->Apply({Edit::Remove(point.id)}).ok());
  EXPECT_EQ(mesh->hash(), fresh->hash());
  EXPECT_LE(mesh->Stats().trace_bytes, 2 * fresh->Stats().trace_bytes);
  EXPECT_LE(BytesOf(*mesh), 2 * BytesOf(*fresh));
}

// At every size while shrinking, too; and the trace stays that of a run from scratch.
TEST_P(Memory, FollowsWhatIsThereOnTheWayDown) {
  test::Random random(GetParam() + 10);
  const auto mesh = *DynamicMesh::Create(Options(GetParam()));
  std::vector<Feature> points = RandomPoints(GetParam(), random);
  for (const Feature& point : points) ASSERT_TRUE(mesh->Apply({Edit::Add(point)}).ok());
  while (points.size() > 8) {
    for (std::size_t left = points.size() / 2; points.size() > left; points.pop_back()) {
      ASSERT_TRUE(mesh->Apply({Edit::Remove(points.back().id)}).ok());
    }
    const auto scratch = *DynamicMesh::Create(Options(GetParam()));
    EditBatch all;
    for (const Feature& point : points) all.push_back(Edit::Add(point));
    ASSERT_TRUE(scratch->Apply(all).ok());
    EXPECT_EQ(mesh->hash(), scratch->hash());
    EXPECT_LE(BytesOf(*mesh), 5 * BytesOf(*scratch)) << points.size() << " points";
    const AuditReport audit = mesh->Audit();
    EXPECT_TRUE(audit.problems.empty()) << audit.problems.front();
    EXPECT_EQ(audit.trace, scratch->Audit().trace);
  }
}

// What undoing takes is held for the revisions that are not settled, and for no others.
TEST_P(Memory, ForUndoingIsReleasedWithWhatIsSettled) {
  if (mallinfo2().uordblks == 0) GTEST_SKIP() << "the allocator does not tell";
  test::Random random(GetParam() + 20);
  const auto mesh = *DynamicMesh::Create(Options(GetParam()));
  const std::vector<Feature> points = RandomPoints(GetParam(), random);
  EditBatch remove;
  for (const Feature& point : points) remove.push_back(Edit::Remove(point.id));
  ApplyOptions revocable;
  revocable.revocable = true;
  const auto apply = [&](int pairs) {
    for (int i = 0; i < pairs; ++i) {
      ASSERT_TRUE(mesh->Apply(AddAll(points), revocable).ok());
      ASSERT_TRUE(mesh->Apply(remove, revocable).ok());
    }
  };
  constexpr int kPairs = 20;
  apply(2);
  mesh->Settle();
  apply(kPairs);
  const std::size_t all = mallinfo2().uordblks;
  mesh->SettleAllBut(kPairs);
  const std::size_t half = mallinfo2().uordblks;
  mesh->SettleAllBut(kPairs);  // nothing
  EXPECT_EQ(mallinfo2().uordblks, half);
  mesh->Settle();
  const std::size_t none = mallinfo2().uordblks;
  constexpr std::size_t kLeast = std::size_t{kPairs} * kPoints * 2 * sizeof(double);
  EXPECT_GT(all - half, kLeast);
  EXPECT_GT(half - none, kLeast);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, Memory, testing::Values(2, 3));

}  // namespace
}  // namespace dynmesh::memory_test
