// The real mesher behind the real service: results equal the library's, bit for bit, and refused
// edits leave no trace.
#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <random>

#include "dynmesh/error.h"
#include "proto/codec/status_codec.h"
#include "tests/e2e/e2e_fixture.h"
#include "tests/support/same_diff.h"

namespace dynmesh::end_to_end_test {
namespace {

TEST_F(EndToEndTest, TheMeshOverTheWireIsTheLibrarysBitForBit) {
  constexpr std::uint64_t kSeed = 20240607;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  auto local = *DynamicMesh::Create(MeshOptions());
  const auto watch = client_->Watch("m", {}, nullptr);
  std::vector<FeatureId> present;
  FeatureId next = 1;
  for (int round = 0; round < 60; ++round) {
    EditBatch batch = RandomPoints(random, next, random() % 8 + 1);
    for (const Edit& e : batch) present.push_back(e.feature.id);
    next += batch.size();
    for (std::uint64_t k = random() % 3; k > 0 && present.size() > 10; --k) {
      std::swap(present[random() % present.size()], present.back());
      batch.push_back(Edit::Remove(present.back()));
      present.pop_back();
    }
    const auto expected = local->Apply(batch);
    ASSERT_TRUE(expected.ok()) << expected.status();
    const auto result = client_->Apply("m", batch);
    ASSERT_TRUE(result.ok()) << result.status();
    MeshDiff a = *expected, b = result->diff;
    Canonicalize(a);
    Canonicalize(b);
    ASSERT_EQ(a.hash, b.hash);
    test::ExpectSameRows(a, b);
  }
  Mesh expected = local->Snapshot();
  Canonicalize(expected);
  auto snapshot = client_->GetSnapshot("m");
  ASSERT_TRUE(snapshot.ok());
  ASSERT_TRUE(watch->WaitForRevision(expected.revision, kLong));
  Mesh replica;
  watch->Read([&](const client::MeshReplica& r) { replica = r.ToMesh(); });
  for (Mesh* mesh : {&*snapshot, &replica}) {
    Canonicalize(*mesh);
    EXPECT_EQ(mesh->revision, expected.revision);
    EXPECT_EQ(mesh->hash, expected.hash);
    EXPECT_EQ(ComputeHash(*mesh), expected.hash);
    EXPECT_EQ(mesh->vertices, expected.vertices);
    EXPECT_EQ(mesh->simplices, expected.simplices);
    EXPECT_EQ(mesh->subsegments, expected.subsegments);
  }
  // A mesh is a function of its features: all gone, and it is the bare box's again.
  EditBatch clear;
  for (const FeatureId id : present) clear.push_back(Edit::Remove(id));
  const auto cleared = client_->Apply("m", clear);
  ASSERT_TRUE(cleared.ok());
  EXPECT_EQ(cleared->diff.hash, (*DynamicMesh::Create(MeshOptions()))->hash());
}

TEST_F(EndToEndTest, BadInputIsNamedAndChangesNothing) {
  std::mt19937_64 random(7);
  ASSERT_TRUE(client_->Apply("m", RandomPoints(random, 1, 100)).ok());
  ASSERT_TRUE(client_->Apply("m", {Edit::Add(Feature::Segment(500, 1, 2))}).ok());
  const server::Head before = HeadOf();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const double huge = std::numeric_limits<double>::max();
  struct Case {
    Edit edit;
    const char* reason;
    FeatureId feature;
  };
  const std::vector<Case> cases = {
      {Edit::Add(Feature::Point(900, nan, 0.5)), reason::kNotFinite, 900},
      {Edit::Add(Feature::Point(900, 0.5, inf)), reason::kNotFinite, 900},
      {Edit::Add(Feature::Point(900, -inf, 0.5)), reason::kNotFinite, 900},
      {Edit::Add(Feature::Point(900, huge, 0.5)), reason::kOutsideBox, 900},
      {Edit::Add(Feature::Point(1, 0.5, 0.5)), reason::kIdInUse, 1},
      {Edit::Add(Feature::Point(0, 0.5, 0.5)), reason::kBadId, 0},
      {Edit::Add(Feature::Point(kBoxFeature, 0.5, 0.5)), reason::kBadId, kBoxFeature},
      {Edit::Remove(901), reason::kUnknownFeature, 901},
      {Edit::Move(902, 0.5, 0.5), reason::kUnknownFeature, 902},
      {Edit::Move(3, nan, 0.5), reason::kNotFinite, 3},
      {Edit::Move(500, 0.5, 0.5), reason::kWrongKind, 500},
      {Edit::Add(Feature::Segment(903, 3, 904)), reason::kUnknownEnd, 903},
      {Edit::Add(Feature::Segment(905, 3, 3)), reason::kDegenerateSegment, 905},
      {Edit::Remove(1), reason::kPointInUse, 1},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(testing::Message() << c.reason << " " << c.feature);
    EditBatch batch = RandomPoints(random, 10'000, 50);
    batch.insert(batch.begin() + 20, c.edit);
    const absl::Status status = client_->Apply("m", batch).status();
    const auto error = codec::GetServiceError(status);
    ASSERT_TRUE(error.has_value()) << status;
    EXPECT_EQ(error->reason, c.reason) << status;
    const auto features = error->Features();
    EXPECT_NE(std::find(features.begin(), features.end(), c.feature), features.end()) << status;
    EXPECT_EQ(HeadOf().revision, before.revision);
    EXPECT_EQ(HeadOf().hash, before.hash);
  }
  client::EditParams stale;
  stale.expected_revision = before.revision - 1;
  EXPECT_EQ(client_->Apply("m", RandomPoints(random, 10'000, 5), stale).status().code(),
            absl::StatusCode::kAborted);
  EXPECT_EQ(HeadOf().hash, before.hash);
  EXPECT_TRUE(client_->Apply("m", RandomPoints(random, 10'000, 5)).ok());
}

TEST_F(EndToEndTest, AnEditThatIsCutShortLeavesTheOldRevision) {
  std::mt19937_64 random(8);
  ASSERT_TRUE(client_->Apply("m", RandomPoints(random, 1, 50)).ok());
  const server::Head before = HeadOf();
  client::ClientOptions options;
  options.timeout = absl::Milliseconds(20);  // far less than so many points take
  const auto hurried = client::MeshClient::Connect(server_->address(), options);
  EXPECT_EQ(hurried->Apply("m", RandomPoints(random, 1000, 16'000)).status().code(),
            absl::StatusCode::kDeadlineExceeded);
  // Its turn comes after the edit was undone.
  client::EditParams check;
  check.expected_revision = before.revision;
  check.validate_only = true;
  const auto now = client_->Apply("m", {}, check);
  ASSERT_TRUE(now.ok()) << now.status();
  EXPECT_EQ(now->diff.hash, before.hash);
  EXPECT_EQ(ComputeHash(*client_->GetSnapshot("m")), before.hash);
  EXPECT_TRUE(client_->Apply("m", RandomPoints(random, 1000, 10)).ok());
}

TEST_F(EndToEndTest, LocatedSimplicesHoldTheirPoints) {
  std::mt19937_64 random(9);
  ASSERT_TRUE(client_->Apply("m", RandomPoints(random, 1, 200)).ok());
  const auto mesh = client_->GetSnapshot("m");
  ASSERT_TRUE(mesh.ok());
  std::map<VertexId, std::pair<double, double>> at;
  for (std::size_t i = 0; i < mesh->vertices.size(); ++i) {
    at[mesh->vertices.ids[i]] = {mesh->vertices.coordinates[2 * i],
                                 mesh->vertices.coordinates[2 * i + 1]};
  }
  std::vector<double> points;
  for (const Edit& e : RandomPoints(random, 1, 100)) {
    points.insert(points.end(), {e.feature.position[0], e.feature.position[1]});
  }
  points.insert(points.end(), {1e9, 1e9});
  const auto located = client_->Locate("m", 2, points);
  ASSERT_TRUE(located.ok()) << located.status();
  for (std::size_t i = 0; i < 100; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = at.at(located->simplices[3 * i + k]);
      const auto b = at.at(located->simplices[3 * i + (k + 1) % 3]);
      const double area = (b.first - a.first) * (points[2 * i + 1] - a.second) -
                          (b.second - a.second) * (points[2 * i] - a.first);
      EXPECT_GE(area, -1e-12) << "point " << i;
    }
  }
  EXPECT_EQ(located->simplices[300], 0u);
}

TEST_F(EndToEndTest, TwoHundredWatchersEndWithTheServersHash) {
  std::mt19937_64 random(10);
  ASSERT_TRUE(client_->Apply("m", RandomPoints(random, 1, 50)).ok());
  std::vector<std::unique_ptr<client::WatchSession>> watches;
  for (int i = 0; i < 200; ++i) watches.push_back(client_->Watch("m", {}, nullptr));
  const auto session = client_->OpenEdits("m");
  for (FeatureId id = 1000; id < 1050; ++id) {
    ASSERT_TRUE(session->Send(RandomPoints(random, id, 1)).ok());
  }
  ASSERT_TRUE(session->DoneSending().ok());
  while (const auto answer = session->Receive()) ASSERT_TRUE(answer->result.ok());
  ASSERT_TRUE(session->Finish().ok());
  for (const auto& watch : watches) {
    ASSERT_TRUE(watch->WaitForRevision(51, kLong));
    watch->Read([&](const client::MeshReplica& r) { EXPECT_EQ(r.hash(), HeadOf().hash); });
  }
}

}  // namespace
}  // namespace dynmesh::end_to_end_test
