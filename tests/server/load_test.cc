// LoadFeatures over loopback, with fake meshes: one batch out of many parts, and all the ways in
// which a load ends before.
#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <thread>

#include "dynmesh/error.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "tests/server/raw_upload.h"
#include "tests/server/server_fixture.h"
#include "tests/support/deadline.h"
#include "tests/support/raw_http2.h"

namespace dynmesh::server::load_test {
namespace {

using absl::StatusCode;
using client::LoadParams;
using client::LoadProgress;
using Response = v1::LoadFeaturesResponse;

std::vector<Feature> Points(FeatureId first, std::size_t count) {
  std::vector<Feature> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(AddPoint(first + i).feature);
  return points;
}

// Refused in its turn, whatever its content.
LoadParams AtRevision7() {
  LoadParams params;
  params.expected_revision = 7;
  return params;
}

class LoadTest : public ServerFixture {
 protected:
  static constexpr std::uint64_t kPending = 100;
  // With room for one load of 100 features.
  void StartSmall() {
    ServerConfig config;
    config.max_batch_edits = config.max_pending_edits = kPending;
    config.keepalive_interval = absl::Milliseconds(300);
    config.keepalive_timeout = absl::Milliseconds(500);
    StartWithMesh(config);
  }
  // Nothing has changed, and all reservations of the loads are released.
  void ExpectUntouched() {
    EXPECT_EQ(HeadOf().revision, 0u);
    for (int i = 0; i < 1000; ++i) {
      const auto loaded = client_->Load("m", Points(1, kPending));
      if (loaded.ok()) return;
      // On a machine that stands still a part of this load, too, may come late.
      const std::string reason = ReasonOf(loaded.status());
      ASSERT_TRUE(reason == codec::reason::kPendingLimit ||
                  reason == codec::reason::kBatchIncomplete)
          << Text(loaded.status());
      absl::SleepFor(absl::Milliseconds(10));
    }
    ADD_FAILURE() << "what the load held was not given back";
  }
};

TEST_F(LoadTest, ManyPartsAreOneRevisionAndTheSameAsABatch) {
  StartWithMesh();
  ASSERT_TRUE(client_->CreateMesh("n", MeshOptions()).ok());
  std::vector<Feature> features = Points(1, 50'000);
  for (FeatureId i = 0; i < 5000; ++i) {
    features.push_back(Feature::Segment(100'000 + i, 1 + i, 2 + i));
    features.push_back(AddPoint(200'000 + i).feature);  // behind what is no point
  }
  const auto loaded = client_->Load("m", features);
  ASSERT_TRUE(loaded.ok()) << Text(loaded.status());
  EXPECT_EQ(loaded->from_revision, 0u);
  EXPECT_EQ(loaded->to_revision, 1u);
  EXPECT_FALSE(loaded->replayed);
  EXPECT_EQ(loaded->hash, HeadOf().hash);
  const auto added = client_->AddFeatures("n", features);
  ASSERT_TRUE(added.ok());
  EXPECT_EQ(added->diff.hash, loaded->hash);
  EXPECT_EQ(client_->GetSnapshot("m")->vertices, client_->GetSnapshot("n")->vertices);
  // From a source, a few at a time; and nothing at all.
  std::size_t next = 0;
  const auto some = Points(300'000, 10);
  const auto again = client_->Load("m", [&] {
    const std::size_t from = std::exchange(next, std::min<std::size_t>(next + 3, some.size()));
    return std::span(some).subspan(from, next - from);
  });
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->to_revision, 2u);
  EXPECT_EQ(Host()->stats().features, 60'010u);
  const auto nothing = client_->Load("m", std::span<const Feature>());
  ASSERT_TRUE(nothing.ok());
  EXPECT_EQ(nothing->to_revision, 2u);
}

TEST_F(LoadTest, ARetryIsAnsweredAndNotRepeated) {
  StartWithMesh();
  LoadParams params;
  params.request_id = "load-1";
  params.expected_revision = 0;
  const auto first = client_->Load("m", Points(1, 1000), params);
  ASSERT_TRUE(first.ok());
  const auto second = client_->Load("m", Points(1, 1000), params);
  ASSERT_TRUE(second.ok());
  EXPECT_TRUE(second->replayed);
  EXPECT_EQ(second->to_revision, 1u);
  EXPECT_EQ(second->hash, first->hash);
  EXPECT_EQ(ReasonOf(client_->Load("m", Points(1, 999), params).status()),
            codec::reason::kRequestIdReused);
  params.request_id = "load-2";
  const auto late = client_->Load("m", Points(5000, 10), params);
  EXPECT_EQ(ReasonOf(late.status()), codec::reason::kRevisionMismatch);
  params.request_id = std::string(200, 'x');
  EXPECT_EQ(ReasonOf(client_->Load("m", Points(5000, 10), params).status()),
            codec::reason::kBadRequestId);
  EXPECT_EQ(HeadOf().revision, 1u);
}

TEST_F(LoadTest, TellsHowFarItIsInOrder) {
  StartWithMesh();
  gate_->Hold();
  RawLoad load(*stub_);
  load.Add(AddPoint(1).feature);
  ASSERT_TRUE(load.Send());
  const auto receiving = load.WaitUntilReceived();
  ASSERT_TRUE(receiving.has_value());
  EXPECT_EQ(receiving->stage(), Response::RECEIVING);
  EXPECT_EQ(receiving->done(), 1u);
  EXPECT_EQ(receiving->total(), 0u);
  load.Add(AddPoint(2).feature);
  load.message().set_last(true);
  ASSERT_TRUE(load.Send());
  gate_->WaitForArrivals(1);
  absl::SleepFor(absl::Milliseconds(600));
  gate_->Release();
  ASSERT_TRUE(load.Finish().ok());
  const auto& told = load.responses();
  ASSERT_GE(told.size(), 2u);
  EXPECT_EQ(told.back().result().to_revision(), 1u);
  for (std::size_t i = 0; i + 1 < told.size(); ++i) {
    EXPECT_FALSE(told[i].has_result());
    EXPECT_TRUE(i == 0 || told[i - 1].stage() <= told[i].stage());
  }
  // What comes half a second after the one before.
  EXPECT_EQ(told[told.size() - 2].stage(), Response::REFINING);
  EXPECT_EQ(told[told.size() - 2].total(), 4u);
}

TEST_F(LoadTest, WithoutTheLastPartNothingIsApplied) {
  StartSmall();
  {
    RawLoad load(*stub_);
    for (const Feature& f : Points(1, 90)) load.Add(f);
    ASSERT_TRUE(load.Send());
    load.HalfClose();
    EXPECT_EQ(ReasonOf(load.Finish()), codec::reason::kBatchIncomplete);
  }
  {
    RawLoad load(*stub_);
    load.HalfClose();
    EXPECT_EQ(ReasonOf(load.Finish()), codec::reason::kBatchIncomplete);
  }
  ExpectUntouched();
}

TEST_F(LoadTest, ABadFeatureInTheMiddleIsNamedAndNothingChanges) {
  StartSmall();
  std::vector<Feature> points = Points(1, 60);
  points[30].position = {7, 0.5, 0};
  const absl::Status outside = client_->Load("m", points).status();
  EXPECT_EQ(ReasonOf(outside), reason::kOutsideBox);
  EXPECT_EQ(codec::GetServiceError(outside)->Features(), std::vector<FeatureId>{31});
  {
    RawLoad load(*stub_);  // known to be bad before the rest is there
    load.Add(AddPoint(1).feature);
    ASSERT_TRUE(load.Send());
    load.message().add_features()->set_id(77);
    ASSERT_TRUE(load.Send());
    const absl::Status bare = load.Finish();
    EXPECT_EQ(ReasonOf(bare), reason::kWrongKind);
    EXPECT_EQ(codec::GetServiceError(bare)->Features(), std::vector<FeatureId>{77});
    EXPECT_EQ(codec::GetServiceError(bare)->field, "features[0]");
    EXPECT_EQ(codec::GetServiceError(bare)->metadata.at("message"), "1");
  }
  {
    RawLoad load(*stub_);
    load.message().mutable_points()->add_ids(1);
    for (int i = 0; i < 3; ++i) load.message().mutable_points()->add_coordinates(0.5);
    EXPECT_EQ(ReasonOf(load.SendLastAndFinish()), codec::reason::kWrongDimension);
  }
  {
    RawLoad load(*stub_);
    load.message().mutable_points()->add_ids(1);
    load.message().mutable_points()->add_coordinates(0.5);
    EXPECT_EQ(ReasonOf(load.SendLastAndFinish()), codec::reason::kBadRequest);
  }
  ExpectUntouched();
}

// Faults found by validation, by their position in the message.
TEST_F(LoadTest, ErrorsNameTheColumnAndTheMessage) {
  StartSmall();
  for (const bool in_columns : {true, false}) {
    RawLoad load(*stub_);
    ASSERT_TRUE(load.Send());  // nothing but the mesh
    for (int message = 1; message < 4; ++message) {
      for (int row = 0; row < 5; ++row) {
        const FeatureId id = static_cast<FeatureId>(10 * message + row);
        const bool bad = in_columns && message == 2 && row == 3;
        load.message().mutable_points()->add_ids(id);
        load.message().mutable_points()->add_coordinates(bad ? 7 : 1.0 / static_cast<double>(id));
        load.message().mutable_points()->add_coordinates(0.5);
      }
      for (int row = 0; row < 3; ++row) {
        Feature point = AddPoint(static_cast<FeatureId>(10 * message + 5 + row)).feature;
        if (!in_columns && message == 3 && row == 2) point.position[0] = 7;
        load.Add(point);
      }
      if (message < 3) {
        ASSERT_TRUE(load.Send());
      }
    }
    const absl::Status outside = load.SendLastAndFinish();
    EXPECT_EQ(ReasonOf(outside), reason::kOutsideBox);
    const auto error = codec::GetServiceError(outside);
    EXPECT_EQ(error->field, in_columns ? "points.ids[3]" : "features[2]");
    EXPECT_EQ(error->metadata.at("message"), in_columns ? "2" : "3");
    EXPECT_EQ(error->Features(), std::vector<FeatureId>{in_columns ? 23u : 37u});
  }
  ExpectUntouched();
}

TEST_F(LoadTest, NamesOneMeshThatExists) {
  StartSmall();
  RawLoad none(*stub_, "meshes/none");
  EXPECT_EQ(ReasonOf(none.SendLastAndFinish()), codec::reason::kMeshNotFound);
  RawLoad unnamed(*stub_, "");
  EXPECT_EQ(ReasonOf(unnamed.SendLastAndFinish()), codec::reason::kBadName);
  RawLoad two(*stub_);
  ASSERT_TRUE(two.Send());
  two.message().set_mesh("meshes/n");
  EXPECT_EQ(ReasonOf(two.SendLastAndFinish()), codec::reason::kBadRequest);
  ExpectUntouched();
}

TEST_F(LoadTest, IsHeldToTheLimitsOfBatches) {
  ServerConfig config;
  config.max_batch_edits = 100;
  config.max_pending_edits = 150;
  config.max_features = 120;
  config.max_edit_streams = 2;
  StartWithMesh(config);
  EXPECT_EQ(ReasonOf(client_->Load("m", Points(1, 101)).status()), codec::reason::kBatchTooLarge);
  {
    RawLoad first(*stub_);
    for (const Feature& f : Points(1, 90)) first.Add(f);
    ASSERT_TRUE(first.Send());
    RawLoad second(*stub_);
    absl::Status status;
    // The first may not have arrived yet.
    test::WaitUntil("the first load's arrival", [&] {
      status = client_->Load("m", Points(1, 90), AtRevision7()).status();
      return ReasonOf(status) != codec::reason::kRevisionMismatch;
    });
    // One too many at a time, or too much at a time.
    EXPECT_TRUE(ReasonOf(status) == codec::reason::kStreamLimit ||
                ReasonOf(status) == codec::reason::kPendingLimit)
        << Text(status);
    EXPECT_TRUE(codec::GetServiceError(status)->retry_after.has_value());
    first.context().TryCancel();
    second.context().TryCancel();
    EXPECT_EQ(first.Finish().code(), StatusCode::kCancelled);
    second.Finish().IgnoreError();
  }
  absl::Status loaded;
  test::WaitUntil("the end of the loads", [&] {
    loaded = client_->Load("m", Points(1, 100)).status();
    return loaded.code() != StatusCode::kResourceExhausted;
  });
  EXPECT_TRUE(loaded.ok()) << Text(loaded);
  EXPECT_EQ(ReasonOf(client_->Load("m", Points(1000, 50)).status()), codec::reason::kFeatureLimit);
  EXPECT_EQ(HeadOf().revision, 1u);
}

TEST_F(LoadTest, CancelledInTheMiddleOrWhileItRunsChangesNothing) {
  StartSmall();
  {
    RawLoad load(*stub_);
    for (const Feature& f : Points(1, 90)) load.Add(f);
    ASSERT_TRUE(load.Send());
    load.context().TryCancel();
    EXPECT_EQ(load.Finish().code(), StatusCode::kCancelled);
  }
  gate_->Hold();
  {
    RawLoad load(*stub_);
    load.Add(AddPoint(1).feature);
    load.message().set_last(true);
    ASSERT_TRUE(load.Send());
    gate_->WaitForArrivals(1);
    load.context().TryCancel();
    EXPECT_EQ(load.Finish().code(), StatusCode::kCancelled);
  }
  // The client cannot see when the server handles the cancellation. After that the load ends while
  // the gate is still closed, and Locate runs.
  Mailbox<int> turn;
  ASSERT_TRUE(Host()->Locate({}, nullptr, [&](auto) { turn.Put(0); }).ok());
  turn.Take();
  gate_->Release();
  ExpectUntouched();
}

TEST_F(LoadTest, TheClientLibraryCancels) {
  StartWithMesh();
  std::atomic<bool> cancelled{false};
  LoadParams params;
  params.cancelled = &cancelled;
  const auto points = Points(1, 50);
  int asked = 0;
  const auto source = [&]() -> std::span<const Feature> {
    cancelled = ++asked > 3;
    return asked > 10 ? std::span<const Feature>() : std::span(points).subspan(0, 1);
  };
  EXPECT_EQ(client_->Load("m", source, params).status().code(), StatusCode::kCancelled);
  EXPECT_EQ(HeadOf().revision, 0u);
}

TEST_F(LoadTest, AMeshDeletedMeanwhileEndsTheLoad) {
  StartSmall();
  RawLoad load(*stub_);
  load.Add(AddPoint(1).feature);
  ASSERT_TRUE(load.Send());
  ASSERT_TRUE(load.WaitUntilReceived().has_value());
  ASSERT_TRUE(client_->DeleteMesh("m").ok());
  load.Add(AddPoint(2).feature);
  const absl::Status status = load.SendLastAndFinish();
  EXPECT_EQ(ReasonOf(status), codec::reason::kMeshDeleted) << Text(status);
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  ExpectUntouched();
}

TEST_F(LoadTest, AHalfOpenLoadHoldsNothingForLong) {
  StartSmall();
  v1::LoadFeaturesRequest part;
  part.set_mesh("meshes/m");
  for (const Feature& f : Points(1, 90)) codec::EncodePointRow(f, 2, part.mutable_points());
  // The test's own query reserves edits, too: a load that arrives meanwhile is refused.
  std::optional<test::RawConnection> half_open;
  ASSERT_TRUE(Eventually([&] {
    if (client_->Load("m", Points(1, 90), AtRevision7()).status().code() ==
        StatusCode::kResourceExhausted) {
      return true;
    }
    half_open.emplace(server_->port());
    EXPECT_TRUE(half_open->Greet() && half_open->Call(1, "LoadFeatures") &&
                half_open->Message(1, part.SerializeAsString(), /*end=*/false));
    return false;
  }));
  // It answers no ping from here on.
  ExpectUntouched();
}

TEST_F(LoadTest, ALoadLeftUnfinishedIsGivenUp) {
  ServerConfig config;
  config.batch_timeout = absl::Milliseconds(200);
  config.max_batch_edits = config.max_pending_edits = kPending;
  StartWithMesh(config);
  RawLoad load(*stub_);
  for (const Feature& f : Points(1, 90)) load.Add(f);
  ASSERT_TRUE(load.Send());
  const absl::Status status = load.Finish();
  EXPECT_EQ(status.code(), StatusCode::kDeadlineExceeded);
  EXPECT_EQ(ReasonOf(status), codec::reason::kBatchIncomplete);
  ExpectUntouched();
}

TEST_F(LoadTest, ABrokenConnectionIsNoEndOfALoad) {
  StartSmall();
  v1::LoadFeaturesRequest part;
  part.set_mesh("meshes/m");
  codec::EncodePointRow(AddPoint(1).feature, 2, part.mutable_points());
  for (int i = 0; i < 50; ++i) {
    test::RawConnection connection(server_->port());
    ASSERT_TRUE(connection.Greet());
    ASSERT_TRUE(connection.Call(1, "LoadFeatures"));
    ASSERT_TRUE(connection.Message(1, part.SerializeAsString(), /*end=*/i % 2 == 0));
  }
  ExpectUntouched();
}

TEST_F(LoadTest, ADrainEndsWhatIsBeingSentAndWaitsForWhatRuns) {
  StartWithMesh();
  ASSERT_TRUE(client_->CreateMesh("n", MeshOptions()).ok());
  RawLoad half(*stub_, "meshes/n");
  half.Add(AddPoint(1).feature);
  ASSERT_TRUE(half.Send());
  ASSERT_TRUE(half.WaitUntilReceived().has_value());
  gate_->Hold();
  RawLoad whole(*stub_);
  whole.Add(AddPoint(1).feature);
  whole.message().set_last(true);
  ASSERT_TRUE(whole.Send());
  gate_->WaitForArrivals(1);
  const auto host = Host(), other = Host("meshes/n");
  Mailbox<bool> drained;
  std::thread drainer([&] { drained.Put(server_->Drain(kLong)); });
  EXPECT_EQ(ReasonOf(half.Finish()), codec::reason::kDraining);
  gate_->Release();
  EXPECT_TRUE(whole.Finish().ok());
  EXPECT_TRUE(drained.Take());
  EXPECT_EQ(host->head().revision, 1u);
  EXPECT_EQ(other->head().revision, 0u);
  drainer.join();
}

// Mostly of use under a sanitizer.
TEST_F(LoadTest, LoadsMayBeCancelledAtAnyMoment) {
  StartWithMesh();
  const auto points = Points(1, 20'000);
  const auto load_and_cancel = [&](int offset) {
    for (int round = 0; round < 40; ++round) {
      std::atomic<bool> cancelled{false};
      RawLoad load(*stub_);
      std::thread canceller([&] {
        absl::SleepFor(absl::Microseconds(300 * round + offset));
        load.context().TryCancel();
      });
      for (std::size_t i = 0; i < points.size(); ++i) {
        codec::EncodePointRow(points[i], 2, load.message().mutable_points());
        if (i % 1000 == 999 && !load.Send()) break;
      }
      const absl::Status status = load.SendLastAndFinish();
      canceller.join();
      if (status.ok()) {
        EXPECT_TRUE(load.responses().back().has_result());
        EditBatch all;
        for (const Feature& f : points) all.push_back(Edit::Remove(f.id));
        EXPECT_TRUE(client_->Apply("m", all).ok());
      }
    }
  };
  load_and_cancel(0);
  EXPECT_EQ(Host()->stats().features % points.size(), 0u);
}

}  // namespace
}  // namespace dynmesh::server::load_test
