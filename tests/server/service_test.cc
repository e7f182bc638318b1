// The RPCs over loopback, with fake meshes: answers and refusals.
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "dynmesh/error.h"
#include "dynmesh/version.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "tests/server/server_fixture.h"
#include "tests/support/deadline.h"

namespace dynmesh::server::service_test {
namespace {

using ServiceTest = ServerFixture;
using absl::StatusCode;

TEST_F(ServiceTest, MeshesAreCreatedListedAndDeleted) {
  StartServer();
  MeshOptions options;
  options.box.hi = {3, 2, 1};
  options.quality = 1.5;
  const auto made = client_->CreateMesh("plate", options);
  ASSERT_TRUE(made.ok()) << Text(made.status());
  EXPECT_EQ(made->id, "plate");
  EXPECT_EQ(made->revision, 0u);
  EXPECT_EQ(made->options.quality, 1.5);
  EXPECT_EQ(made->options.box.hi[0], 3);
  const auto chosen = client_->CreateMesh("", options);
  ASSERT_TRUE(chosen.ok());
  EXPECT_TRUE(IsMeshId(chosen->id)) << chosen->id;
  const auto listed = client_->ListMeshes();
  ASSERT_TRUE(listed.ok());
  EXPECT_EQ(listed->size(), 2u);
  EXPECT_EQ(client_->GetMesh("meshes/plate")->hash, made->hash);
  EXPECT_TRUE(client_->DeleteMesh("plate").ok());
  EXPECT_EQ(ReasonOf(client_->DeleteMesh("plate")), codec::reason::kMeshNotFound);
  EXPECT_EQ(client_->GetMesh("plate").status().code(), StatusCode::kNotFound);
  EXPECT_EQ(client_->ListMeshes()->size(), 1u);
}

TEST_F(ServiceTest, NamesThatAreNoneAreRefused) {
  StartServer();
  EXPECT_EQ(ReasonOf(client_->CreateMesh("Plate", {}).status()), codec::reason::kBadName);
  EXPECT_EQ(ReasonOf(client_->GetMesh("no/such").status()), codec::reason::kBadName);
  EXPECT_EQ(ReasonOf(client_->GetMesh("").status()), codec::reason::kBadName);
  EXPECT_EQ(ReasonOf(client_->Apply("none", {AddPoint(1)}).status()), codec::reason::kMeshNotFound);
  EXPECT_EQ(ReasonOf(client_->GetSnapshot("none").status()), codec::reason::kMeshNotFound);
  EXPECT_EQ(ReasonOf(client_->GetStats("none").status()), codec::reason::kMeshNotFound);
}

TEST_F(ServiceTest, CreateIsIdempotentByRequestIdOnly) {
  StartServer();
  const auto first = client_->CreateMesh("", {}, "c1");
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(client_->CreateMesh("", {}, "c1")->id, first->id);
  EXPECT_EQ(client_->ListMeshes()->size(), 1u);
  MeshOptions other;
  other.quality = 3;
  EXPECT_EQ(ReasonOf(client_->CreateMesh("", other, "c1").status()),
            codec::reason::kRequestIdReused);
  EXPECT_EQ(ReasonOf(client_->CreateMesh(first->id, {}).status()), codec::reason::kMeshExists);
  // Deleting the mesh also forgets the request.
  ASSERT_TRUE(client_->DeleteMesh(first->id).ok());
  EXPECT_TRUE(client_->CreateMesh("", other, "c1").ok());
}

// Another client may have made its mesh with the same request_id: this client does not get that
// one.
TEST_F(ServiceTest, ARequestIdIsOfTheMeshThatItNames) {
  StartServer();
  ASSERT_TRUE(client_->CreateMesh("secret", {}, "create-1").ok());
  const auto mine = client_->CreateMesh("mine", {}, "create-1");
  ASSERT_TRUE(mine.ok()) << mine.status();
  EXPECT_EQ(mine->id, "mine");
  EXPECT_EQ(client_->CreateMesh("mine", {}, "create-1")->id, "mine");
  MeshOptions other;
  other.quality = 3;
  const absl::Status reused = client_->CreateMesh("mine", other, "create-1").status();
  EXPECT_EQ(ReasonOf(reused), codec::reason::kRequestIdReused);
  EXPECT_EQ(std::string(reused.message()).find("secret"), std::string::npos) << reused;
  ASSERT_TRUE(client_->DeleteMesh("secret").ok());
  EXPECT_EQ(client_->CreateMesh("mine", {}, "create-1")->id, "mine");
}

TEST_F(ServiceTest, BadOptionsAreNamed) {
  StartServer();
  MeshOptions bad;
  bad.quality = 0.5;
  EXPECT_EQ(client_->CreateMesh("m", bad).status().code(), StatusCode::kInvalidArgument);
  bad = MeshOptions();
  bad.box.hi[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(client_->CreateMesh("m", bad).status().code(), StatusCode::kInvalidArgument);
  bad = MeshOptions();
  bad.limits.max_vertices = ~std::uint64_t{0};
  const absl::Status status = client_->CreateMesh("m", bad).status();
  EXPECT_EQ(codec::GetServiceError(status)->field, "options.max_vertices");
  // A box without corners; a line may be intended.
  bad = MeshOptions();
  bad.box.hi = bad.box.lo;
  const absl::Status nowhere = client_->CreateMesh("m", bad).status();
  EXPECT_EQ(nowhere.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(codec::GetServiceError(nowhere)->field, "options.box");
  EXPECT_EQ(client_->ListMeshes()->size(), 0u);
  bad.box.hi[0] += 1;
  EXPECT_TRUE(client_->CreateMesh("m", bad).ok());
}

TEST_F(ServiceTest, ListsComeInPages) {
  StartServer();
  std::set<std::string> made, listed;
  for (int i = 0; i < 7; ++i) made.insert(MeshName(client_->CreateMesh("", {})->id));
  v1::ListMeshesRequest request;
  request.set_page_size(3);
  int pages = 0;
  do {
    grpc::ClientContext context;
    v1::ListMeshesResponse response;
    ASSERT_TRUE(stub_->ListMeshes(&context, request, &response).ok());
    EXPECT_LE(response.meshes_size(), 3);
    for (const auto& mesh : response.meshes()) EXPECT_TRUE(listed.insert(mesh.name()).second);
    request.set_page_token(response.next_page_token());
    ++pages;
  } while (!request.page_token().empty());
  EXPECT_EQ(pages, 3);
  EXPECT_EQ(listed, made);
  request.set_page_size(-1);
  grpc::ClientContext context;
  v1::ListMeshesResponse response;
  EXPECT_EQ(stub_->ListMeshes(&context, request, &response).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(ServiceTest, EveryWayOfEditingStreamsItsDiff) {
  StartWithMesh();
  const std::vector<Feature> features = {AddPoint(1).feature, AddPoint(2).feature,
                                         Feature::Segment(3, 1, 2)};
  const auto added = client_->AddFeatures("m", features);
  ASSERT_TRUE(added.ok()) << Text(added.status());
  EXPECT_EQ(added->diff.added_vertices.size(), 2u);
  EXPECT_EQ(added->diff.added_subsegments.owners, std::vector<FeatureId>{3});
  const std::vector<FeatureId> ids = {3};
  const auto removed = client_->RemoveFeatures("m", ids);
  ASSERT_TRUE(removed.ok());
  EXPECT_EQ(removed->diff.removed_subsegments.owners, std::vector<FeatureId>{3});
  const auto applied =
      client_->Apply("m", {Edit::Remove(1), Edit::Set(Feature::Point(2, 0.25, 0.25)), AddPoint(5)});
  ASSERT_TRUE(applied.ok());
  EXPECT_EQ(applied->diff.from_revision, 2u);
  EXPECT_EQ(applied->diff.to_revision, 3u);
  EXPECT_EQ(applied->diff.hash, HeadOf().hash);
  EXPECT_EQ(applied->diff.work.executed, 3u);
  client::EditParams params;
  params.omit_columns = true;
  const auto bare = client_->Apply("m", {AddPoint(6)}, params);
  ASSERT_TRUE(bare.ok());
  EXPECT_TRUE(bare->columns_omitted);
  EXPECT_EQ(bare->diff.added_vertices.size(), 0u);
  EXPECT_EQ(bare->diff.hash, HeadOf().hash);
}

TEST_F(ServiceTest, BadEditsNameTheFeatureAndChangeNothing) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
  const Head before = HeadOf();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  struct Case {
    Edit edit;
    const char* reason;
    FeatureId feature;
  };
  for (const Case& c :
       {Case{Edit::Add(Feature::Point(7, nan, 0)), reason::kNotFinite, 7},
        Case{Edit::Add(Feature::Point(7, 0, -inf)), reason::kNotFinite, 7},
        Case{Edit::Add(Feature::Point(7, 9, 9)), reason::kOutsideBox, 7},
        Case{AddPoint(1), reason::kIdInUse, 1}, Case{Edit::Remove(99), reason::kUnknownFeature, 99},
        Case{Edit::Add(Feature::Segment(8, 1, 98)), reason::kUnknownEnd, 8}}) {
    const absl::Status status = client_->Apply("m", {AddPoint(50), c.edit}).status();
    const auto error = codec::GetServiceError(status);
    ASSERT_TRUE(error.has_value()) << Text(status);
    EXPECT_EQ(error->reason, c.reason);
    EXPECT_EQ(error->Features().at(0), c.feature);
    EXPECT_EQ(HeadOf().revision, before.revision);
    EXPECT_EQ(HeadOf().hash, before.hash);
  }
  const std::vector<Feature> features = {AddPoint(60).feature, Feature::Point(61, nan, 0)};
  EXPECT_EQ(codec::GetServiceError(client_->AddFeatures("m", features).status())->field,
            "features[1]");
  const std::vector<FeatureId> ids = {1, 62};
  EXPECT_EQ(codec::GetServiceError(client_->RemoveFeatures("m", ids).status())->field, "ids[1]");
  EXPECT_EQ(HeadOf().hash, before.hash);
}

TEST_F(ServiceTest, RetriesAndStaleRevisionsOverTheWire) {
  StartWithMesh();
  client::EditParams params;
  params.request_id = "r1";
  params.expected_revision = 0;
  ASSERT_FALSE(client_->Apply("m", {AddPoint(1)}, params)->replayed);
  const auto again = client_->Apply("m", {AddPoint(1)}, params);
  ASSERT_TRUE(again.ok());
  EXPECT_TRUE(again->replayed);
  EXPECT_EQ(again->diff.to_revision, 1u);
  EXPECT_EQ(again->diff.added_vertices.size(), 1u);
  // The way of editing does not matter, the edits do.
  const std::vector<Feature> features = {AddPoint(1).feature};
  EXPECT_TRUE(client_->AddFeatures("m", features, params)->replayed);
  params.request_id = "r2";
  EXPECT_EQ(ReasonOf(client_->Apply("m", {AddPoint(2)}, params).status()),
            codec::reason::kRevisionMismatch);
  params.request_id = std::string(129, 'x');
  params.expected_revision.reset();
  EXPECT_EQ(ReasonOf(client_->Apply("m", {AddPoint(2)}, params).status()),
            codec::reason::kBadRequestId);
  EXPECT_EQ(HeadOf().revision, 1u);
}

TEST_F(ServiceTest, ABatchTooLargeForAMessageIsAppliedWhole) {
  StartWithMesh();
  const EditBatch batch = ManyPoints(1, 50'000);
  const auto result = client_->Apply("m", batch);
  ASSERT_TRUE(result.ok()) << Text(result.status());
  EXPECT_EQ(result->diff.to_revision, 1u);
  EXPECT_EQ(result->diff.added_vertices.size(), batch.size());
  const auto mesh = client_->GetSnapshot("m");
  ASSERT_TRUE(mesh.ok()) << Text(mesh.status());
  EXPECT_EQ(mesh->hash, result->diff.hash);
  EXPECT_EQ(mesh->revision, 1u);
}

TEST_F(ServiceTest, PolygonsTooLargeForAMessageTogetherGoInParts) {
  StartWithMesh();
  constexpr FeatureId kPoint = FeatureId{1} << 62;
  std::vector<Feature> features = {AddPoint(kPoint).feature};
  for (FeatureId id = 1; id <= 12; ++id) {
    features.push_back(Feature::Polygon(id, {std::vector<FeatureId>(50'000, kPoint)}));
  }
  const auto added = client_->AddFeatures("m", features);
  ASSERT_TRUE(added.ok()) << Text(added.status());
  EXPECT_EQ(added->diff.to_revision, 1u);
  EditBatch edits;
  for (FeatureId id = 1; id <= 12; ++id) edits.push_back(Edit::Set(features[id]));
  EXPECT_TRUE(client_->Apply("m", edits).ok());
  EXPECT_EQ(client_->GetStats("m")->mesh->stats.features, 13u);
}

TEST_F(ServiceTest, OneBadEditInALargeBatchIsFoundAndNothingChanges) {
  StartWithMesh();
  const Head before = HeadOf();
  EditBatch batch = ManyPoints(1, 50'000);
  batch[40'000].feature.position[1] = std::numeric_limits<double>::quiet_NaN();
  const auto error = codec::GetServiceError(client_->Apply("m", batch).status());
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->reason, reason::kNotFinite);
  EXPECT_EQ(error->field, "edits[40000]");
  EXPECT_EQ(error->Features().at(0), 40'001u);
  EXPECT_EQ(HeadOf().revision, 0u);
  EXPECT_EQ(HeadOf().hash, before.hash);
  EXPECT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
}

TEST_F(ServiceTest, SnapshotsAndDiffsStayBelowOneMegabyteAMessage) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", ManyPoints(1, 60'000)).ok());
  v1::GetSnapshotRequest request;
  request.set_mesh("meshes/m");
  grpc::ClientContext context;
  const auto reader = stub_->GetSnapshot(&context, request);
  v1::SnapshotChunk chunk;
  std::size_t chunks = 0, largest = 0;
  while (reader->Read(&chunk)) {
    ++chunks;
    largest = std::max(largest, chunk.ByteSizeLong());
  }
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_GT(chunks, 3u);
  EXPECT_LT(largest, std::size_t{1'000'000});

  v1::RemoveFeaturesRequest remove;
  remove.set_mesh("meshes/m");
  for (FeatureId id = 1; id <= 60'000; ++id) remove.add_ids(id);
  grpc::ClientContext remove_context;
  const auto diffs = stub_->RemoveFeatures(&remove_context, remove);
  v1::MeshDiff fragment;
  largest = 0;
  bool more = true;
  while (diffs->Read(&fragment)) {
    EXPECT_TRUE(more);
    more = fragment.more();
    largest = std::max(largest, fragment.ByteSizeLong());
  }
  EXPECT_TRUE(diffs->Finish().ok());
  EXPECT_FALSE(more);
  EXPECT_LT(largest, std::size_t{1'000'000});
}

TEST_F(ServiceTest, LocateAsksOnlyForFiniteWholePoints) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2), AddPoint(3)}).ok());
  const std::vector<double> points = {0.5, 0.5, 5, 5};
  const auto located = client_->Locate("m", 2, points);
  ASSERT_TRUE(located.ok()) << Text(located.status());
  EXPECT_EQ(located->revision, 1u);
  ASSERT_EQ(located->simplices.size(), 6u);
  EXPECT_NE(located->simplices[0], 0u);
  EXPECT_EQ(located->simplices[5], 0u);
  const std::vector<double> odd = {0.5, 0.5, 5};
  EXPECT_EQ(client_->Locate("m", 2, odd).status().code(), StatusCode::kInvalidArgument);
  const std::vector<double> nan = {0.5, std::numeric_limits<double>::quiet_NaN()};
  const auto error = codec::GetServiceError(client_->Locate("m", 2, nan).status());
  EXPECT_EQ(error->reason, reason::kNotFinite);
  EXPECT_EQ(error->field, "coordinates[1]");
  // More than one request holds.
  const std::vector<double> many(2 * 70'000, 0.5);
  EXPECT_EQ(client_->Locate("m", 2, many)->simplices.size(), 3u * 70'000);
}

TEST_F(ServiceTest, StatsTellOfServerAndMesh) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2), AddPoint(3)}).ok());
  const auto stats = client_->GetStats("m");
  ASSERT_TRUE(stats.ok());
  EXPECT_EQ(stats->version, kVersion);
  EXPECT_EQ(stats->meshes, 1u);
  ASSERT_TRUE(stats->mesh.has_value());
  EXPECT_EQ(stats->mesh->stats.revision, 1u);
  EXPECT_EQ(stats->mesh->stats.features, 3u);
  EXPECT_EQ(stats->mesh->stats.simplices, 1u);
  EXPECT_EQ(stats->mesh->hash, HeadOf().hash);
  EXPECT_FALSE(client_->GetStats()->mesh.has_value());
}

TEST_F(ServiceTest, HealthAndReflectionAnswer) {
  StartServer();
  EXPECT_EQ(Health(""), 1);
  EXPECT_EQ(Health("dynmesh.v1.MeshService"), 1);
  grpc::Status status;
  // list_services, field 7 of ServerReflectionRequest.
  const std::string reply = CallBytes(
      "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", "\x3a\x01*", &status);
  EXPECT_NE(reply.find("dynmesh.v1.MeshService"), std::string::npos);
  EXPECT_NE(reply.find("grpc.health.v1.Health"), std::string::npos);
}

// Invalid request bytes are reported as the caller's fault.
TEST_F(ServiceTest, MessagesThatCannotBeReadAreRefusedWithAText) {
  StartWithMesh();
  const auto* service = v1::GetMeshRequest::descriptor()->file()->FindServiceByName("MeshService");
  ASSERT_GT(service->method_count(), 10);
  for (int i = 0; i < service->method_count(); ++i) {
    using google::protobuf::FieldDescriptor;
    const std::string path = "/dynmesh.v1.MeshService/" + service->method(i)->name();
    const auto* first = service->method(i)->input_type()->FindFieldByNumber(1);
    const bool begins_with_text = first->type() == FieldDescriptor::TYPE_STRING;
    for (const std::string bytes : {"\xff\xff\xff", "\x0a\x03\xff\xfe\xfd", "\x0a\x7fm"}) {
      // Of another type the field is one that the server does not know.
      if (bytes[0] == '\x0a' && !begins_with_text) continue;
      grpc::Status status;
      CallBytes(path, bytes, &status);
      EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << path;
      EXPECT_NE(status.error_message().find(service->method(i)->input_type()->full_name()),
                std::string::npos)
          << path << ": " << status.error_message();
      EXPECT_EQ(ReasonOf(codec::FromGrpcStatus(status)), codec::reason::kBadRequest) << path;
    }
  }
  grpc::Status status;
  // Unknown fields of a newer client are not a fault.
  CallBytes("/dynmesh.v1.MeshService/GetMesh",
            "\x0a\x08meshes/m\x9a\x06\x01"
            "a",
            &status);
  EXPECT_TRUE(status.ok()) << status.error_message();
  CallBytes("/dynmesh.v1.MeshService/Bend", "", &status);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED);
  EXPECT_NE(status.error_message().find("/dynmesh.v1.MeshService/Bend"), std::string::npos)
      << status.error_message();
  EXPECT_EQ(HeadOf().revision, 0u);
}

// gRPC takes it for the end of the stream; the server distinguishes both.
TEST_F(ServiceTest, AMessageThatCannotBeReadEndsAStreamWithAnError) {
  StartWithMesh();
  grpc::GenericStub generic(Channel());
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  const auto call = generic.PrepareCall(&context, "/dynmesh.v1.MeshService/EditStream", &queue);
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    EXPECT_TRUE(queue.Next(&tag, &ok));
    return ok;
  };
  const auto send = [&](const std::string& bytes) {
    grpc::Slice slice(bytes);
    call->Write(grpc::ByteBuffer(&slice, 1), nullptr);
    EXPECT_TRUE(wait());
  };
  call->StartCall(nullptr);
  ASSERT_TRUE(wait());
  v1::EditBatch batch;
  batch.set_mesh("meshes/m");
  codec::EncodeEdit(AddPoint(1), 2, batch.add_edits());
  send(batch.SerializeAsString());
  send("\xff\xff\xff");
  grpc::ByteBuffer answer;
  call->Read(&answer, nullptr);
  EXPECT_TRUE(wait());  // earlier batches are answered
  call->Read(&answer, nullptr);
  EXPECT_FALSE(wait());
  grpc::Status status;
  call->Finish(&status, nullptr);
  EXPECT_TRUE(wait());
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_NE(status.error_message().find("EditBatch"), std::string::npos) << status.error_message();
  EXPECT_EQ(HeadOf().revision, 1u);
}

TEST_F(ServiceTest, TwoServersDoNotShareAPort) {
  StartServer();
  ServerConfig config;
  config.listen = server_->address();
  const auto second =
      Server::Start(config, [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o); });
  EXPECT_EQ(second.status().code(), StatusCode::kUnavailable);
}

}  // namespace
}  // namespace dynmesh::server::service_test
