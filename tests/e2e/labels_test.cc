// Labels over the network: watchers, whole, of regions and lagging ones, end with the labels of the
// features; answers, retries and snapshots tell them.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "dynmesh/error.h"
#include "proto/codec/status_codec.h"
#include "tests/e2e/e2e_fixture.h"
#include "tests/support/label_script.h"
#include "tests/support/seed.h"
#include "tests/support/workload.h"

namespace dynmesh::labels_test {
namespace {

LabelColumn LabelsOf(const std::vector<Feature>& features) {
  LabelColumn labels;
  for (const Feature& f : features) {
    if (f.label) labels.push_back({f.id, *f.label});
  }
  return labels;
}

LabelColumn LabelsOf(const client::WatchSession& watch) {
  LabelColumn labels;
  watch.Read([&](const client::MeshReplica& r) { labels = r.mesh().labels(); });
  return labels;
}

TEST_F(EndToEndTest, WatchersFollowLabels) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  test::LabelledScript script(test::ScriptGenerator(test::Distribution::kPolygons, 30, seed),
                              seed + 1);
  auto local = *DynamicMesh::Create(MeshOptions());
  client::WatchOptions of_region;
  of_region.regions = {999};
  const auto whole = client_->Watch("m", {}, nullptr),
             part = client_->Watch("m", of_region, nullptr);
  const auto session = client_->OpenEdits("m");  // pipelined, so that watchers lag
  std::vector<MeshDiff> diffs;
  for (int step = 0; step < 80; ++step) {
    const EditBatch batch = script.Next(local->Features());
    const auto expected = local->Apply(batch);
    if (!expected.ok()) continue;
    ASSERT_TRUE(session->Send(batch).ok());
    if (expected->from_revision != expected->to_revision) diffs.push_back(*expected);
  }
  ASSERT_TRUE(session->DoneSending().ok());
  std::size_t at = 0;
  while (const auto answer = session->Receive()) {
    ASSERT_TRUE(answer->result.ok()) << answer->result.status();
    const MeshDiff& diff = answer->result->diff;
    if (diff.from_revision == diff.to_revision) continue;
    EXPECT_EQ(diff.labels, diffs[at++].labels);
  }
  ASSERT_EQ(at, diffs.size());
  ASSERT_TRUE(session->Finish().ok());
  const LabelColumn labels = LabelsOf(local->Features());
  // At the end there may be none: all features with one may be gone.
  ASSERT_TRUE(std::ranges::any_of(diffs, [](const MeshDiff& d) { return !d.labels.empty(); }));
  for (const auto* watch : {&whole, &part}) {
    ASSERT_TRUE((*watch)->WaitForRevision(local->revision(), kLong));
    EXPECT_EQ(LabelsOf(**watch), labels);
  }
  EXPECT_EQ(LabelsOf(client_->GetFeatures("m")->features), labels);
  EXPECT_EQ(client_->GetSnapshot("m")->labels, labels);
  EXPECT_EQ(client_->GetSnapshot("m", std::vector<FeatureId>{999})->labels, labels);
  const auto late = client_->Watch("m", {}, nullptr);
  ASSERT_TRUE(late->WaitForRevision(local->revision(), kLong));
  EXPECT_EQ(LabelsOf(*late), labels);
}

TEST_F(EndToEndTest, AnEditOfLabelsIsAnsweredAndRepeatedAsOthersAre) {
  Feature point = Feature::Point(1, 0.5, 0.5);
  point.label = {7, "Inlet"};
  std::vector<Feature> features = {point, Feature::Point(2, 0.25, 0.5)};
  const auto loaded = client_->Load("m", features, {});
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_EQ(client_->GetFeatures("m")->features, features);

  client::EditParams params;
  params.request_id = "r";
  const EditBatch batch = {Edit::SetLabel(1, {}), Edit::SetLabel(2, {0, "W\xc3\xa4nde"})};
  for (const bool again : {false, true}) {
    const auto result = client_->Apply("m", batch, params);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->replayed, again);
    EXPECT_EQ(result->diff.labels, (LabelColumn{{1, {}}, {2, {0, "W\xc3\xa4nde"}}}));
    EXPECT_EQ(result->diff.added_simplices.size() + result->diff.removed_simplices.size(), 0u);
    EXPECT_EQ(result->diff.hash, loaded->hash);
    EXPECT_EQ(result->diff.to_revision, 2u);
  }
  const auto other =
      client_->Apply("m", {Edit::SetLabel(1, {}), Edit::SetLabel(2, {0, "W"})}, params);
  EXPECT_EQ(codec::GetServiceError(other.status())->reason, codec::reason::kRequestIdReused);
  params = {};
  params.omit_columns = true;
  const auto omitted = client_->Apply("m", {Edit::SetLabel(2, {1, ""})}, params);
  ASSERT_TRUE(omitted.ok() && omitted->columns_omitted);
  EXPECT_TRUE(omitted->diff.labels.empty());

  const auto bad = client_->Apply("m", {Edit::SetLabel(1, {}), Edit::SetLabel(2, {0, "a\tb"})});
  const auto error = codec::GetServiceError(bad.status());
  ASSERT_TRUE(error.has_value()) << bad.status();
  EXPECT_EQ(error->reason, reason::kBadLabel);
  EXPECT_EQ(error->Features(), std::vector<FeatureId>{2});
  EXPECT_EQ(error->metadata.at("edit"), "1");
  EXPECT_EQ(bad.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(client_->GetMesh("m")->revision, 3u);
}

}  // namespace
}  // namespace dynmesh::labels_test
