// Columns of labels: changes and differences against maps, and bad columns.
#include "core/mesh_data/labels.h"

#include <gtest/gtest.h>

#include <map>

#include "dynmesh/slot_mesh.h"
#include "tests/core/mesh_data/made_up_mesh.h"

namespace dynmesh::mesh_data {
namespace {

using testing::MakeRandom;

TEST(LabelColumns, ADifferenceLeadsFromOneToTheOther) {
  auto random = MakeRandom();
  for (int round = 0; round < 300; ++round) {
    const LabelColumn from = testing::AnyLabels(random), to = testing::AnyLabels(random);
    const LabelColumn diff = DiffLabels(from, to);
    EXPECT_TRUE(AreLabelsOfMesh(from));
    EXPECT_TRUE(AreLabels(diff));
    EXPECT_EQ(ChangedLabels(from, diff), to);
    std::map<FeatureId, FeatureLabel> a, b;
    for (const auto& [id, label] : from) a[id] = label;
    for (const auto& [id, label] : to) b[id] = label;
    std::size_t changes = 0;
    for (FeatureId id = 0; id < 100; ++id) changes += a[id] != b[id];
    EXPECT_EQ(diff.size(), changes);
    EXPECT_EQ(diff.empty(), from == to);
  }
}

TEST(LabelColumns, OutOfOrderOrEmptyOnesAreRefused) {
  auto random = MakeRandom();
  Mesh mesh = testing::MakeUpMesh(random, 10, 1);
  mesh.labels = {{3, {1, ""}}, {5, {0, "a"}}};
  ASSERT_TRUE(SlotMesh::FromMesh(mesh).ok());
  MeshDiff diff;
  diff.from_revision = 1, diff.to_revision = 2, diff.hash = mesh.hash;
  for (const LabelColumn& bad :
       {LabelColumn{{5, {1, ""}}, {3, {1, ""}}}, LabelColumn{{3, {1, ""}}, {3, {2, ""}}},
        LabelColumn{{0, {1, ""}}}}) {
    SlotMesh store = *SlotMesh::FromMesh(mesh);
    diff.labels = bad;
    EXPECT_EQ(store.Apply(diff).code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(store.labels(), mesh.labels);
    Mesh other = mesh;
    EXPECT_FALSE(ApplyDiff(other, diff).ok());
    other.labels = bad;
    EXPECT_FALSE(SlotMesh::FromMesh(other).ok());
  }
  Mesh other = mesh;
  other.labels[0].label = {};
  EXPECT_FALSE(SlotMesh::FromMesh(other).ok());
  diff.labels = {{3, {}}, {4, {0, "b"}}, {9, {}}};
  SlotMesh store = *SlotMesh::FromMesh(mesh);
  const SlotMesh copy = store;
  ASSERT_TRUE(store.Apply(diff).ok());
  EXPECT_EQ(store.labels(), (LabelColumn{{4, {0, "b"}}, {5, {0, "a"}}}));
  EXPECT_EQ(store.FindLabel(3), FeatureLabel());
  EXPECT_EQ(copy.labels(), mesh.labels);
  EXPECT_GT(ByteSize(store.labels()), 2 * sizeof(LabelOfFeature));
}

}  // namespace
}  // namespace dynmesh::mesh_data
