// 3D meshes through the service: the library's mesh after every edit; bad input is named and
// changes nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <random>

#include "dynmesh/error.h"
#include "proto/codec/status_codec.h"
#include "tests/e2e/e2e_fixture.h"
#include "tests/support/same_diff.h"

namespace dynmesh::space_test {
namespace {

MeshOptions InSpace() {
  MeshOptions options;
  options.dimension = 3;
  options.quality = kDefaultQuality3D;
  return options;
}

client::EditParams Params() {
  client::EditParams params;
  params.dimension = 3;
  return params;
}

using Place = std::array<double, 3>;

// Corners first, ..., first + 7 and faces first + 10, ..., first + 15 of a box.
std::vector<Feature> BoxFeatures(FeatureId first, const Place& lo, double side) {
  std::vector<Feature> features;
  for (FeatureId k = 0; k < 8; ++k) {
    features.push_back(Feature::Point(first + k, lo[0] + (k & 1 ? side : 0),
                                      lo[1] + (k & 2 ? side : 0), lo[2] + (k & 4 ? side : 0)));
  }
  constexpr FeatureId kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                      {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (FeatureId f = 0; f < 6; ++f) {
    std::vector<FeatureId> ring;
    for (const FeatureId k : kFaces[f]) ring.push_back(first + k);
    features.push_back(Feature::Polygon(first + 10 + f, {ring}));
  }
  return features;
}

using test::Sorted;

void ExpectSame(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.hash, b.hash);
  test::ExpectSameRows(a, b);
  EXPECT_EQ(ComputeHash(a), a.hash);
}

class SpaceEndToEnd : public EndToEndTest {
 protected:
  SpaceEndToEnd() { EXPECT_TRUE(client_->CreateMesh("s", InSpace()).ok()); }
  server::Head Now() const { return (*server_->registry().Find("meshes/s"))->head(); }
};

// The features of a mesh, and random batches that change them: an inner box that moves, a face
// of it that comes and goes, points, a segment, sizes.
class Scene {
 public:
  explicit Scene(std::uint64_t seed) : random_(seed) {
    for (const Feature& f : BoxFeatures(100, {0.1, 0.1, 0.1}, 0.8)) features_[f.id] = f;
    for (const Feature& f : BoxFeatures(200, {0.4, 0.4, 0.4}, 0.2)) features_[f.id] = f;
  }
  std::vector<Feature> Features() const {
    std::vector<Feature> all;
    for (const auto& [id, feature] : features_) all.push_back(feature);
    return all;
  }
  EditBatch Next(int round) {
    const double a = Unit(), b = Unit(), c = Unit();
    switch (round % 5) {
      case 0: {  // all corners of the inner box move
        EditBatch batch;
        const Place lo = {0.3 + 0.2 * a, 0.3 + 0.2 * b, 0.3 + 0.2 * c};
        for (const Feature& f : BoxFeatures(200, lo, 0.2)) {
          if (f.kind == FeatureKind::kPoint) {
            batch.push_back(Edit::Move(f.id, f.position[0], f.position[1], f.position[2]));
          }
        }
        return batch;
      }
      case 1: {
        const FeatureId face = 210 + random_() % 6;
        if (features_.contains(face)) return {Edit::Remove(face)};
        const auto box = BoxFeatures(200, {}, 1);
        return {Edit::Add(box[8 + face - 210])};
      }
      case 2: {
        const Sizing box = {SizeShape::kBox, 0.05 + 0.1 * a, 0, {0.3, 0.3, 0.2 + 0.1 * b}};
        const Edit edit = Edit::Add(Feature::Size(1, {0.2, 0.2, 0.1 + 0.1 * b}, box));
        return {features_.contains(1) ? Edit::Remove(1) : edit};
      }
      case 3: {
        EditBatch batch;
        if (features_.contains(3)) return {Edit::Remove(5), Edit::Remove(4), Edit::Remove(3)};
        return {Edit::Add(Feature::Segment(5, 3, 4)),
                Edit::Add(Feature::Point(3, 0.15, 0.2 + 0.6 * a, 0.15)),
                Edit::Add(Feature::Point(4, 0.2, 0.2 + 0.6 * b, 0.8))};
      }
      default:
        return {Edit::Add(Feature::Point(1000 + static_cast<FeatureId>(round), a, b, c))};
    }
  }
  void Keep(const EditBatch& batch) {
    for (const Edit& e : batch) {
      if (e.action == Edit::Action::kRemove) {
        features_.erase(e.feature.id);
      } else {
        features_[e.feature.id] = e.feature;
      }
    }
  }

 private:
  double Unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  std::mt19937_64 random_;
  std::map<FeatureId, Feature> features_;
};

TEST_F(SpaceEndToEnd, AfterFiftyEditsTheReplicaIsTheMeshFromScratch) {
  constexpr std::uint64_t kSeed = 20261122;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Scene scene(kSeed);
  const auto watch = client_->Watch("s", {}, nullptr);
  ASSERT_TRUE(client_->AddFeatures("s", scene.Features(), Params()).ok());
  const auto session = client_->OpenEdits("s");
  int accepted = 0;
  for (int round = 0; round < 50; ++round) {
    const EditBatch batch = scene.Next(round);
    ASSERT_TRUE(session->Send(batch, Params()).ok());
    const auto answer = session->Receive();
    ASSERT_TRUE(answer.has_value());
    if (!answer->result.ok()) {  // too close to another feature, say
      EXPECT_TRUE(codec::GetServiceError(answer->result.status()).has_value());
      continue;
    }
    EXPECT_EQ(answer->result->diff.dimension, 3);
    scene.Keep(batch);
    ++accepted;
  }
  EXPECT_GT(accepted, 40);
  const absl::StatusOr<Mesh> built = BuildMesh(scene.Features(), InSpace());
  ASSERT_TRUE(built.ok()) << built.status();
  const Mesh expected = Sorted(*built);
  EXPECT_GT(expected.subfacets.size(), 12u);
  ASSERT_TRUE(watch->WaitForRevision(static_cast<std::uint64_t>(accepted) + 1, kLong));
  Mesh replica;
  watch->Read([&](const client::MeshReplica& r) { replica = r.ToMesh(); });
  ExpectSame(Sorted(replica), expected);
  const auto snapshot = client_->GetSnapshot("s");
  ASSERT_TRUE(snapshot.ok()) << snapshot.status();
  ExpectSame(Sorted(*snapshot), expected);
  EXPECT_EQ(watch->resyncs(), 0);
  const auto status = client_->GetStats("s");
  ASSERT_TRUE(status.ok() && status->mesh.has_value());
  EXPECT_EQ(status->mesh->dimension, 3);
  EXPECT_EQ(status->mesh->stats.subfacets, expected.subfacets.size());
  EXPECT_EQ(status->mesh->stats.simplices, expected.simplex_count());
}

struct Bad {
  EditBatch edits;
  const char* reason;
  FeatureId feature;
  absl::StatusCode code;
};

// Faults beside BoxFeatures(100, {0.2, 0.2, 0.2}, 0.5).
std::vector<Bad> BadBatches() {
  using Code = absl::StatusCode;
  const auto point = [](FeatureId id, double x, double y, double z) {
    return Edit::Add(Feature::Point(id, x, y, z));
  };
  const auto polygon = [](FeatureId id, Rings rings) {
    return Edit::Add(Feature::Polygon(id, std::move(rings)));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  // A long rectangle at z = 0.8 with steep diagonals, and a square upright through the box.
  const EditBatch flat = {point(301, 0.3, 0.3, 0.8), point(302, 0.4, 0.3, 0.8),
                          point(303, 0.4, 0.7, 0.8), point(304, 0.3, 0.7, 0.8)};
  const EditBatch upright = {point(301, 0.3, 0.4, 0.1), point(302, 0.6, 0.4, 0.1),
                             point(303, 0.6, 0.4, 0.9), point(304, 0.3, 0.4, 0.9)};
  const auto with = [](EditBatch batch, const Edit& edit) {
    batch.push_back(edit);
    return batch;
  };
  return {
      {{point(300, 0.5, 0.5, nan)}, reason::kNotFinite, 300, Code::kInvalidArgument},
      {{point(300, 0.5, 0.5, -inf)}, reason::kNotFinite, 300, Code::kInvalidArgument},
      {{point(300, 0.5, 0.5, 1.5)}, reason::kOutsideBox, 300, Code::kInvalidArgument},
      {{Edit::Move(107, 0.7, 0.7, nan)}, reason::kNotFinite, 107, Code::kInvalidArgument},
      {{Edit::Move(107, 0.7, 0.7, 0.75)}, reason::kNonPlanar, 111, Code::kFailedPrecondition},
      {{point(300, 0.4, 0.4, 0.2)}, reason::kPointOnPolygon, 300, Code::kFailedPrecondition},
      {{point(300, 0.2, 0.2, 0.2)}, reason::kDuplicatePoint, 300, Code::kFailedPrecondition},
      {{point(300, 0.45, 0.2, 0.2)}, reason::kPointOnSegment, 300, Code::kFailedPrecondition},
      {{point(300, 0.4, 0.4, 0.1), point(301, 0.4, 0.4, 0.4),
        Edit::Add(Feature::Segment(302, 300, 301))},
       reason::kSegmentMeetsPolygon,
       302,
       Code::kFailedPrecondition},
      {with(flat, polygon(310, {{301, 302, 304, 303}})), reason::kSegmentsCross, 310,
       Code::kFailedPrecondition},
      {with(flat, polygon(310, {{301, 302}})), reason::kBadPolygon, 310, Code::kInvalidArgument},
      {with(flat, polygon(310, {{301, 302, 303, 399}})), reason::kUnknownEnd, 310,
       Code::kFailedPrecondition},
      {with(upright, polygon(310, {{301, 302, 303, 304}})), reason::kSegmentMeetsPolygon, 310,
       Code::kFailedPrecondition},
      {{polygon(310, {{100, 101, 103, 102}})},
       reason::kDuplicatePolygon,
       310,
       Code::kFailedPrecondition},
      {{Edit::Remove(100)}, reason::kPointInUse, 100, Code::kFailedPrecondition},
      {{Edit::Remove(399)}, reason::kUnknownFeature, 399, Code::kNotFound},
      {{Edit::Add(
           Feature::Size(300, {0.1, 0.1, 0.1}, {SizeShape::kBox, 0.1, 0, {0.2, 0.2, 0.05}}))},
       reason::kBadSize,
       300,
       Code::kInvalidArgument},
      {{Edit::Add(Feature::Size(300, {0.1, 0.1, nan}, {SizeShape::kDisc, 0.1, 0.1, {}}))},
       reason::kNotFinite,
       300,
       Code::kInvalidArgument},
  };
}

TEST_F(SpaceEndToEnd, BadInputIsNamedAndChangesNothing) {
  const auto box = BoxFeatures(100, {0.2, 0.2, 0.2}, 0.5);
  ASSERT_TRUE(client_->AddFeatures("s", box, Params()).ok());
  const server::Head before = Now();
  for (const Bad& bad : BadBatches()) {
    SCOPED_TRACE(testing::Message() << bad.reason << " " << bad.feature);
    EditBatch batch = bad.edits;
    batch.push_back(Edit::Add(Feature::Point(900, 0.9, 0.9, 0.9)));  // good, but undone
    const absl::Status status = client_->Apply("s", batch, Params()).status();
    const auto error = codec::GetServiceError(status);
    EXPECT_TRUE(error.has_value()) << status;
    if (!error.has_value()) continue;
    EXPECT_EQ(error->reason, bad.reason) << status;
    EXPECT_EQ(status.code(), bad.code) << status;
    const auto features = error->Features();
    EXPECT_NE(std::find(features.begin(), features.end(), bad.feature), features.end()) << status;
    EXPECT_EQ(Now().revision, before.revision);
    EXPECT_EQ(Now().hash, before.hash);
  }
  EXPECT_TRUE(client_->Apply("s", {Edit::Add(Feature::Point(900, 0.9, 0.9, 0.9))}, Params()).ok());
}

TEST_F(SpaceEndToEnd, WhatIsOfAnotherDimensionIsRefused) {
  const EditBatch batch = {Edit::Add(Feature::Point(1, 0.5, 0.5, 0.5))};
  for (const auto& [mesh, params] : {std::pair("s", client::EditParams()), {"m", Params()}}) {
    const auto error = codec::GetServiceError(client_->Apply(mesh, batch, params).status());
    ASSERT_TRUE(error.has_value());
    EXPECT_EQ(error->reason, codec::reason::kWrongDimension);
  }
  client::EditParams none;
  none.dimension = 4;
  EXPECT_EQ(client_->Apply("s", batch, none).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(Now().revision, 0u);
  EXPECT_EQ(HeadOf().revision, 0u);
}

TEST_F(SpaceEndToEnd, LocatedTetrahedraHoldTheirPoints) {
  ASSERT_TRUE(client_->AddFeatures("s", BoxFeatures(100, {0.2, 0.2, 0.2}, 0.5), Params()).ok());
  const auto mesh = client_->GetSnapshot("s");
  ASSERT_TRUE(mesh.ok());
  std::map<VertexId, Place> at;
  for (std::size_t i = 0; i < mesh->vertices.size(); ++i) {
    const double* const c = &mesh->vertices.coordinates[3 * i];
    at[mesh->vertices.ids[i]] = {c[0], c[1], c[2]};
  }
  constexpr std::uint64_t kSeed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-0.5, 1.5);
  std::vector<double> points;
  for (int i = 0; i < 300; ++i) points.push_back(unit(random));
  points.insert(points.end(), {1e9, 0, 0});
  const auto located = client_->Locate("s", 3, points);
  ASSERT_TRUE(located.ok()) << located.status();
  ASSERT_EQ(located->simplices.size(), 4 * 101u);
  const auto volume = [](const Place& a, const Place& b, const Place& c, const Place& d) {
    double u[3], v[3], w[3];
    for (std::size_t k = 0; k < 3; ++k) u[k] = b[k] - a[k], v[k] = c[k] - a[k], w[k] = d[k] - a[k];
    return u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) +
           u[2] * (v[0] * w[1] - v[1] * w[0]);
  };
  for (std::size_t i = 0; i < 100; ++i) {
    const Place p = {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<Place, 4> corners;
      for (std::size_t c = 0; c < 4; ++c) corners[c] = at.at(located->simplices[4 * i + c]);
      corners[k] = p;
      EXPECT_GE(volume(corners[0], corners[1], corners[2], corners[3]), -1e-12) << "point " << i;
    }
  }
  EXPECT_EQ(located->simplices[400], 0u);
}

}  // namespace
}  // namespace dynmesh::space_test
