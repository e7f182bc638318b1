// BuildMesh over loopback, with fake meshes: how a build is received, how it ends, and its limits.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "absl/strings/match.h"
#include "dynmesh/error.h"
#include "tests/server/raw_upload.h"
#include "tests/server/server_fixture.h"
#include "tests/support/deadline.h"

namespace dynmesh::server::build_test {
namespace {

using absl::StatusCode;
using client::BuildParams;
using client::LoadProgress;

std::vector<Feature> Points(FeatureId first, std::size_t count) {
  std::vector<Feature> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(AddPoint(first + i).feature);
  return points;
}

class BuildTest : public ServerFixture {
 protected:
  // With a place for one build.
  void StartSmall(ServerConfig config = {}) {
    config.max_builds = 1;
    StartServer(std::move(config));
  }
  // Soon, as a build's place is free a moment after its answer.
  void ExpectFreePlace() {
    absl::Status status;
    test::WaitUntil("a free place", [&] {
      status = client_->BuildMesh(Points(1, 3), MeshOptions()).status();
      return ReasonOf(status) != codec::reason::kStreamLimit;
    });
    EXPECT_TRUE(status.ok()) << Text(status);
  }
  // The same while the gate is held: no build waits there.
  void ExpectFreePlaceWhileHeld() {
    test::WaitUntil("a free place", [&] {
      RawBuild without_options(*stub_);
      return ReasonOf(without_options.SendLastAndFinish()) == codec::reason::kBadRequest;
    });
    build_gate_->Release();
    ExpectFreePlace();
  }
  // A build that has reached the gate, which is held.
  std::unique_ptr<RawBuild> StartHeld(int arrivals = 1) {
    build_gate_->Hold();
    auto build = std::make_unique<RawBuild>(*stub_, MeshOptions());
    build->Add(AddPoint(1).feature);
    EXPECT_TRUE(build->SendLast());
    build_gate_->WaitForArrivals(arrivals);
    return build;
  }
  absl::Status TryMaxTime(int seconds) {
    RawBuild build(*stub_, MeshOptions());
    build.message().mutable_max_time()->set_seconds(seconds);
    return build.SendLastAndFinish();
  }
};

TEST_F(BuildTest, TheMeshIsThatOfAllParts) {
  StartSmall();
  RawBuild build(*stub_, MeshOptions());
  build.message().mutable_points()->add_ids(7);
  for (const double x : {0.25, 0.5}) build.message().mutable_points()->add_coordinates(x);
  build.Add(Feature::Segment(20, 7, 8));  // before its end
  ASSERT_TRUE(build.Send());
  ASSERT_TRUE(build.Send());  // empty
  build.Add(Feature::Point(8, 0.75, 0.5));
  ASSERT_TRUE(build.SendLastAndFinish().ok());
  const auto mesh = build.ReceivedMesh();
  ASSERT_TRUE(mesh.has_value());
  EXPECT_EQ(mesh->revision, 1u);
  EXPECT_EQ(mesh->vertices.owners, (std::vector<FeatureId>{7, 8}));
  EXPECT_EQ(mesh->subsegments.owners, std::vector<FeatureId>{20});
  EXPECT_EQ(ComputeHash(*mesh), mesh->hash);
  EXPECT_EQ(server_->registry().size(), 0u);
}

TEST_F(BuildTest, TheFirstMessageHasTheOptionsAndNoOther) {
  StartServer();
  {
    RawBuild build(*stub_);
    build.Add(AddPoint(1).feature);
    const absl::Status status = build.SendLastAndFinish();
    EXPECT_EQ(ReasonOf(status), codec::reason::kBadRequest);
    EXPECT_EQ(codec::GetServiceError(status)->field, "options");
  }
  const auto later = [&](auto set) {
    RawBuild build(*stub_, MeshOptions());
    EXPECT_TRUE(build.Send());
    set(build.message());
    const absl::Status status = build.SendLastAndFinish();
    EXPECT_EQ(ReasonOf(status), codec::reason::kBadRequest) << Text(status);
    return codec::GetServiceError(status)->field;
  };
  EXPECT_EQ(later([](auto& m) { m.mutable_options(); }), "options");
  EXPECT_EQ(later([](auto& m) { m.set_engine(v1::BUILD_ENGINE_SVR); }), "engine");
  EXPECT_EQ(later([](auto& m) { m.set_only_inside(true); }), "only_inside");
  EXPECT_EQ(later([](auto& m) { m.mutable_max_time(); }), "max_time");
  ExpectFreePlace();
}

TEST_F(BuildTest, BadOptionsAreRefusedByName) {
  ServerConfig config;
  config.max_build_time = absl::Seconds(10);
  config.max_builds = 100;
  StartServer(config);
  {
    RawBuild build(*stub_, MeshOptions());
    build.message().set_engine(static_cast<v1::BuildEngine>(7));
    EXPECT_EQ(codec::GetServiceError(build.SendLastAndFinish())->field, "engine");
  }
  for (const int seconds : {-1, 11}) {
    const absl::Status status = TryMaxTime(seconds);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_EQ(codec::GetServiceError(status)->field, "max_time");
  }
  EXPECT_TRUE(TryMaxTime(10).ok());
  MeshOptions options;
  options.quality = 1000;
  EXPECT_EQ(ReasonOf(client_->BuildMesh(Points(1, 3), options).status()), reason::kBadOption);
  options = {};
  options.box.hi = options.box.lo;
  EXPECT_EQ(ReasonOf(client_->BuildMesh(Points(1, 3), options).status()), reason::kBadOption);
  options.dimension = 4;
  EXPECT_EQ(client_->BuildMesh(Points(1, 3), options).status().code(),
            StatusCode::kInvalidArgument);
  ExpectFreePlace();
}

TEST_F(BuildTest, WithoutTheLastPartNothingIsBuilt) {
  StartServer();
  for (const bool sends : {false, true}) {
    RawBuild build(*stub_, MeshOptions());
    if (sends) {
      ASSERT_TRUE(build.Send());
    }
    build.HalfClose();
    const absl::Status status = build.Finish();
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_EQ(ReasonOf(status), codec::reason::kBatchIncomplete);
    EXPECT_TRUE(build.responses().empty());
  }
  ExpectFreePlace();
}

TEST_F(BuildTest, AfterTheLastPartNothingIsRead) {
  StartSmall();
  auto build = StartHeld();
  build->Add(AddPoint(2).feature);
  build->SendLast();
  build_gate_->Release();
  ASSERT_TRUE(build->Finish().ok());
  EXPECT_EQ(build->ReceivedMesh()->hash, HashOfFake({1}));
}

TEST_F(BuildTest, ARefusedFeatureIsNamedWithItsMessage) {
  StartServer();
  {
    RawBuild build(*stub_, MeshOptions());
    ASSERT_TRUE(build.Send());
    for (const Feature& f : Points(1, 5)) build.Add(f);
    Feature outside = AddPoint(6).feature;
    outside.position[0] = 7;
    build.Add(outside);
    const absl::Status status = build.SendLastAndFinish();
    EXPECT_EQ(ReasonOf(status), reason::kOutsideBox);
    EXPECT_EQ(codec::GetServiceError(status)->Features(), std::vector<FeatureId>{6});
    EXPECT_EQ(codec::GetServiceError(status)->field, "features[5]");
    EXPECT_EQ(codec::GetServiceError(status)->metadata.at("message"), "1");
  }
  {
    RawBuild build(*stub_, MeshOptions());  // known to be bad before the rest is there
    build.message().add_features()->set_id(77);
    ASSERT_TRUE(build.Send());
    const absl::Status status = build.Finish();
    EXPECT_EQ(ReasonOf(status), reason::kWrongKind);
    EXPECT_EQ(codec::GetServiceError(status)->Features(), std::vector<FeatureId>{77});
  }
  ExpectFreePlace();
}

TEST_F(BuildTest, IsHeldToTheLimitsOfBatches) {
  ServerConfig config;
  config.max_batch_edits = config.max_pending_edits = 100;
  config.max_features = 90;
  config.max_batch_operations = 80;
  StartServer(config);
  const auto reason_of = [&](std::size_t points) {
    return ReasonOf(client_->BuildMesh(Points(1, points), MeshOptions()).status());
  };
  EXPECT_EQ(reason_of(101), codec::reason::kBatchTooLarge);
  EXPECT_EQ(reason_of(91), codec::reason::kFeatureLimit);
  EXPECT_EQ(reason_of(81), reason::kWorkLimit);
  EXPECT_EQ(reason_of(80), "");
  build_gate_->Hold();
  RawBuild first(*stub_, MeshOptions());
  for (const Feature& f : Points(1, 80)) first.Add(f);
  ASSERT_TRUE(first.SendLast());
  build_gate_->WaitForArrivals(2);
  const absl::Status second = client_->BuildMesh(Points(1, 80), MeshOptions()).status();
  EXPECT_EQ(ReasonOf(second), codec::reason::kPendingLimit);
  EXPECT_TRUE(codec::GetServiceError(second)->retry_after.has_value());
  build_gate_->Release();
  ASSERT_TRUE(first.Finish().ok());
  EXPECT_EQ(reason_of(80), "");
}

TEST_F(BuildTest, VerticesHaveALimitOfTheirOwn) {
  ServerConfig config;
  config.max_build_vertices = 50;
  StartServer(config);
  EXPECT_EQ(ReasonOf(client_->BuildMesh(Points(1, 51), MeshOptions()).status()),
            reason::kVertexLimit);
  EXPECT_TRUE(client_->BuildMesh(Points(1, 50), MeshOptions()).ok());
  MeshOptions options;
  options.limits.max_vertices = 51;
  EXPECT_EQ(ReasonOf(client_->BuildMesh(Points(1, 3), options).status()), reason::kBadOption);
  options.limits.max_vertices = 40;
  EXPECT_EQ(ReasonOf(client_->BuildMesh(Points(1, 41), options).status()), reason::kVertexLimit);
}

TEST_F(BuildTest, ABuildTooManyIsRefusedWithATimeToRetry) {
  StartSmall();
  const auto held = StartHeld();
  const absl::Status status = client_->BuildMesh(Points(1, 3), MeshOptions()).status();
  EXPECT_EQ(status.code(), StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(status), codec::reason::kStreamLimit);
  EXPECT_TRUE(codec::GetServiceError(status)->retry_after.has_value());
  build_gate_->Release();
  EXPECT_TRUE(held->Finish().ok());
  ExpectFreePlace();
}

TEST_F(BuildTest, AServerMayAllowNone) {
  ServerConfig config;
  config.max_builds = 0;
  StartServer(config);
  EXPECT_EQ(ReasonOf(client_->BuildMesh(Points(1, 3), MeshOptions()).status()),
            codec::reason::kStreamLimit);
  builder_ = nullptr;
  StartServer();
  EXPECT_EQ(client_->BuildMesh(Points(1, 3), MeshOptions()).status().code(),
            StatusCode::kUnimplemented);
}

TEST_F(BuildTest, EditsGoOnWhileBuildsRun) {
  ServerConfig config;
  config.writer_threads = config.reader_threads = 1;
  config.max_builds = 3;
  StartWithMesh(config);
  std::vector<std::unique_ptr<RawBuild>> builds;
  for (int i = 1; i <= 3; ++i) builds.push_back(StartHeld(i));
  EXPECT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
  EXPECT_TRUE(client_->GetSnapshot("m").ok());
  build_gate_->Release();
  for (const auto& build : builds) EXPECT_TRUE(build->Finish().ok());
}

TEST_F(BuildTest, ACancelledBuildEndsAndFreesItsPlace) {
  StartSmall();
  const auto held = StartHeld();
  held->context().TryCancel();
  EXPECT_EQ(held->Finish().code(), StatusCode::kCancelled);
  ExpectFreePlaceWhileHeld();
}

TEST_F(BuildTest, ADeadlineEndsIt) {
  StartSmall();
  build_gate_->Hold();
  client::ClientOptions options;
  options.timeout = absl::Milliseconds(300);
  const auto hurried = client::MeshClient::Connect(server_->address(), options);
  EXPECT_EQ(hurried->BuildMesh(Points(1, 3), MeshOptions()).status().code(),
            StatusCode::kDeadlineExceeded);
  ExpectFreePlaceWhileHeld();
}

TEST_F(BuildTest, TheClientLibraryTellsProgressAndCancels) {
  StartSmall();
  build_gate_->Hold();
  std::atomic<bool> cancelled{false};
  std::vector<LoadProgress> told;
  BuildParams params;
  params.cancelled = &cancelled;
  params.progress = [&](const LoadProgress& p) {
    told.push_back(p);
    cancelled = true;
  };
  // A fake tells nothing while it is held: begin half a second after the report before.
  RawBuild slow(*stub_, MeshOptions());
  ASSERT_TRUE(slow.Send());
  ASSERT_TRUE(slow.WaitUntilReceived().has_value());
  absl::SleepFor(absl::Milliseconds(600));
  slow.Add(AddPoint(1).feature);
  ASSERT_TRUE(slow.SendLast());
  const auto first = slow.Receive();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->progress().stage(), v1::LoadFeaturesResponse::VALIDATING);
  EXPECT_EQ(first->progress().total(), 2u);
  build_gate_->Release();
  ASSERT_TRUE(slow.Finish().ok());
  builder_ = [](auto, const auto&, const BuildOptions& build) -> absl::StatusOr<Mesh> {
    for (std::uint64_t i = 0; !build.interrupted(); ++i) {
      build.progress({ApplyProgress::Stage::kRefine, i, 0});
      absl::SleepFor(absl::Milliseconds(1));
    }
    return absl::CancelledError("interrupted");
  };
  StartSmall();
  EXPECT_EQ(client_->BuildMesh(Points(1, 3), MeshOptions(), params).status().code(),
            StatusCode::kCancelled);
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told.front().stage, LoadProgress::Stage::kRefine);
}

TEST_F(BuildTest, ATimeLimitIsNamed) {
  ServerConfig config;
  config.max_build_time = absl::Milliseconds(250);
  StartSmall(config);
  build_gate_->Hold();
  BuildParams params;
  for (const auto& [max_time, text] :
       {std::pair(absl::ZeroDuration(), "this server's limit of 250ms"),
        std::pair(absl::Milliseconds(100), "max_time, 100ms")}) {
    params.max_time = max_time;
    absl::Status status;
    test::WaitUntil("a free place", [&] {
      status = client_->BuildMesh(Points(1, 3), MeshOptions(), params).status();
      return ReasonOf(status) != codec::reason::kStreamLimit;
    });
    EXPECT_EQ(status.code(), StatusCode::kResourceExhausted);
    EXPECT_EQ(ReasonOf(status), codec::reason::kTimeLimit);
    EXPECT_TRUE(absl::StrContains(status.message(), text)) << Text(status);
  }
  build_gate_->Release();
  ExpectFreePlace();
}

TEST_F(BuildTest, AFullServerStopsIt) {
  static std::atomic<std::uint64_t> resident{0};
  resident = 0;
  ServerConfig config;
  config.max_memory_bytes = 1'000;
  config.resident_bytes = [] { return resident.load(); };
  StartSmall(config);
  auto held = StartHeld();
  resident = 2'000;
  EXPECT_EQ(ReasonOf(held->Finish()), codec::reason::kMemoryLimit);
  test::WaitUntil("a free place", [&] {
    const absl::Status status = client_->BuildMesh(Points(1, 3), MeshOptions()).status();
    return ReasonOf(status) == codec::reason::kMemoryLimit;
  });
}

TEST_F(BuildTest, ABuildLeftUnfinishedIsGivenUp) {
  ServerConfig config;
  config.batch_timeout = absl::Milliseconds(200);
  StartSmall(config);
  RawBuild silent(*stub_);
  RawBuild half(*stub_, MeshOptions());
  ASSERT_TRUE(half.Send());
  for (RawBuild* const build : {&silent, &half}) {
    const absl::Status status = build->Finish();
    EXPECT_EQ(status.code(), StatusCode::kDeadlineExceeded);
    EXPECT_EQ(ReasonOf(status), codec::reason::kBatchIncomplete);
  }
  ExpectFreePlace();
}

TEST_F(BuildTest, ADrainEndsIt) {
  StartServer();
  RawBuild half(*stub_, MeshOptions());
  ASSERT_TRUE(half.Send());
  const auto held = StartHeld();
  EXPECT_TRUE(server_->Drain(kLong));
  for (RawBuild* const build : {&half, held.get()}) {
    const absl::Status status = build->Finish();
    EXPECT_EQ(status.code(), StatusCode::kUnavailable);
    EXPECT_EQ(ReasonOf(status), codec::reason::kDraining);
  }
}

// Its chunks wait for the client: far more than gRPC's buffers of a call.
TEST_F(BuildTest, AMeshThatIsNotReadGivesUpItsPlace) {
  ServerConfig config;
  config.send_timeout = absl::Milliseconds(300);
  StartSmall(config);
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  const auto stub = v1::MeshService::NewStub(
      grpc::CreateCustomChannel(server_->address(), grpc::InsecureChannelCredentials(), arguments));
  RawBuild build(*stub, MeshOptions());
  for (FeatureId id = 1; id <= 100'000; ++id) {
    codec::EncodePointRow(AddPoint(id).feature, 2, build.message().mutable_points());
    if (id % 10'000 == 0) {
      ASSERT_TRUE(build.Send());
    }
  }
  ASSERT_TRUE(build.SendLast());
  build_gate_->WaitForArrivals(1);
  ExpectFreePlace();
  const absl::Status status = build.Finish();
  EXPECT_EQ(status.code(), StatusCode::kDeadlineExceeded);
  EXPECT_TRUE(absl::StartsWith(status.message(), "SLOW_RECEIVER")) << Text(status);
  EXPECT_FALSE(build.ReceivedMesh().has_value());
}

TEST_F(BuildTest, ALargeMeshComesInChunksAtTheClientsPace) {
  StartServer();
  const auto points = Points(1, 60'000);
  const auto mesh = client_->BuildMesh(points, MeshOptions());
  ASSERT_TRUE(mesh.ok()) << Text(mesh.status());
  EXPECT_EQ(mesh->vertices.size(), 60'000u);
  RawBuild build(*stub_, MeshOptions());
  for (std::size_t i = 0; i < points.size(); ++i) {
    codec::EncodePointRow(points[i], 2, build.message().mutable_points());
    if (i % 10'000 == 0) {
      ASSERT_TRUE(build.Send());
    }
  }
  ASSERT_TRUE(build.SendLastAndFinish().ok());
  EXPECT_GT(build.responses().size(), 3u);
  EXPECT_EQ(build.ReceivedMesh()->hash, mesh->hash);
}

// Mostly of use under a sanitizer.
TEST_F(BuildTest, BuildsMayBeCancelledAtAnyMoment) {
  StartServer();
  const auto points = Points(1, 5'000);
  for (int round = 0; round < 60; ++round) {
    RawBuild build(*stub_, MeshOptions());
    std::thread canceller([&] {
      absl::SleepFor(absl::Microseconds(300 * round));
      build.context().TryCancel();
    });
    for (std::size_t i = 0; i < points.size(); ++i) {
      codec::EncodePointRow(points[i], 2, build.message().mutable_points());
      if (i % 1000 == 999 && !build.Send()) break;
    }
    const absl::Status status = build.SendLastAndFinish();
    canceller.join();
    EXPECT_TRUE(!status.ok() || build.ReceivedMesh().has_value());
  }
  ExpectFreePlace();
}

}  // namespace
}  // namespace dynmesh::server::build_test
