// Tokens over real connections: authentication, roles, shares, and new files without a restart.
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <thread>

#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/token_hash.h"
#include "tests/server/raw_upload.h"
#include "tests/server/server_fixture.h"
#include "tests/support/certificates.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server::security_test {
namespace {

using absl::StatusCode;

class TokenTest : public ServerFixture {
 protected:
  void Tokens(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    test::WriteAtOnce(folder_.path() + "/tokens", text);
  }
  static std::string Line(const std::string& token, const std::string& grants) {
    return token + " " + codec::ToHex(codec::HashToken(token)) + " " + grants;
  }
  void StartWithTokens(const std::vector<std::string>& lines, ServerConfig config = {}) {
    Tokens(lines);
    config.tokens_file = folder_.path() + "/tokens";
    StartServer(config);
  }
  std::unique_ptr<client::MeshClient> As(const std::string& token) const {
    client::ClientOptions options;
    options.token = token;
    return client::MeshClient::Connect(server_->address(), options);
  }
  test::TempFolder folder_;
};

// Needs its role on some mesh, whichever.
constexpr char kOfNoMesh[] = "BuildMesh";

// A call of one method, about the mesh "crack-1" where it is about one.
struct Row {
  std::string role;  // that it needs; "any": a token
  std::function<grpc::Status(v1::MeshService::Stub&, grpc::ClientContext&)> call;
  std::string reason = {};  // of the error for an authorized caller: the server has no journal
};

template <typename Response, typename Reader>
grpc::Status ReadOne(grpc::ClientContext& context, Reader reader) {
  Response response;
  if (reader->Read(&response)) context.TryCancel();
  const grpc::Status status = reader->Finish();
  return status.error_code() == grpc::StatusCode::CANCELLED ? grpc::Status::OK : status;
}

template <typename Request>
Request About(const char* mesh = "meshes/crack-1") {
  Request request;
  request.set_mesh(mesh);
  return request;
}

std::map<std::string, Row> Methods() {
  using Stub = v1::MeshService::Stub;
  using Context = grpc::ClientContext;
  std::map<std::string, Row> rows;
  rows["CreateMesh"] = {"admin", [](Stub& stub, Context& c) {
                          v1::CreateMeshRequest request;
                          request.set_mesh_id("crack-2");
                          codec::EncodeOptions({}, request.mutable_options());
                          request.mutable_options()->clear_max_vertices();  // the server's
                          v1::Mesh mesh;
                          return stub.CreateMesh(&c, request, &mesh);
                        }};
  rows["GetMesh"] = {"read", [](Stub& stub, Context& c) {
                       v1::Mesh mesh;
                       return stub.GetMesh(&c, About<v1::GetMeshRequest>(), &mesh);
                     }};
  rows["ListMeshes"] = {"any", [](Stub& stub, Context& c) {
                          v1::ListMeshesResponse response;
                          return stub.ListMeshes(&c, {}, &response);
                        }};
  rows["DeleteMesh"] = {"admin", [](Stub& stub, Context& c) {
                          v1::DeleteMeshResponse response;
                          return stub.DeleteMesh(&c, About<v1::DeleteMeshRequest>("meshes/crack-2"),
                                                 &response);
                        }};
  rows["AddFeatures"] = {"edit", [](Stub& stub, Context& c) {
                           return ReadOne<v1::MeshDiff>(
                               c, stub.AddFeatures(&c, About<v1::AddFeaturesRequest>()));
                         }};
  rows["RemoveFeatures"] = {"edit", [](Stub& stub, Context& c) {
                              return ReadOne<v1::MeshDiff>(
                                  c, stub.RemoveFeatures(&c, About<v1::RemoveFeaturesRequest>()));
                            }};
  rows["ApplyEdits"] = {"edit", [](Stub& stub, Context& c) {
                          return ReadOne<v1::MeshDiff>(
                              c, stub.ApplyEdits(&c, About<v1::ApplyEditsRequest>()));
                        }};
  rows["EditStream"] = {"edit", [](Stub& stub, Context& c) {
                          auto stream = stub.EditStream(&c);
                          stream->Write(About<v1::EditBatch>());
                          return ReadOne<v1::MeshDiff>(c, std::move(stream));
                        }};
  rows["LoadFeatures"] = {"edit", [](Stub& stub, Context& c) {
                            auto stream = stub.LoadFeatures(&c);
                            v1::LoadFeaturesRequest request = About<v1::LoadFeaturesRequest>();
                            request.set_last(true);
                            stream->Write(request);
                            return ReadOne<v1::LoadFeaturesResponse>(c, std::move(stream));
                          }};
  rows[kOfNoMesh] = {"edit", [](Stub& stub, Context& c) {
                       auto stream = stub.BuildMesh(&c);
                       v1::BuildMeshRequest request;
                       codec::EncodeOptions(MeshOptions(), request.mutable_options());
                       request.mutable_options()->clear_max_vertices();
                       request.set_last(true);
                       stream->Write(request);
                       return ReadOne<v1::BuildMeshResponse>(c, std::move(stream));
                     }};
  rows["Watch"] = {"read", [](Stub& stub, Context& c) {
                     return ReadOne<v1::WatchEvent>(c, stub.Watch(&c, About<v1::WatchRequest>()));
                   }};
  rows["GetSnapshot"] = {"read", [](Stub& stub, Context& c) {
                           return ReadOne<v1::SnapshotChunk>(
                               c, stub.GetSnapshot(&c, About<v1::GetSnapshotRequest>()));
                         }};
  rows["GetStats"] = {"read", [](Stub& stub, Context& c) {
                        v1::GetStatsResponse response;
                        return stub.GetStats(&c, About<v1::GetStatsRequest>(), &response);
                      }};
  rows["LocatePoints"] = {"read", [](Stub& stub, Context& c) {
                            v1::LocatePointsResponse response;
                            return stub.LocatePoints(&c, About<v1::LocatePointsRequest>(),
                                                     &response);
                          }};
  rows["GetFeatures"] = {"read", [](Stub& stub, Context& c) {
                           return ReadOne<v1::FeaturesChunk>(
                               c, stub.GetFeatures(&c, About<v1::GetFeaturesRequest>()));
                         }};
  rows["RevertTo"] = {"edit",
                      [](Stub& stub, Context& c) {
                        return ReadOne<v1::MeshDiff>(
                            c, stub.RevertTo(&c, About<v1::RevertToRequest>()));
                      },
                      codec::reason::kNoHistory};
  return rows;
}

// "" if it is allowed.
std::string ExpectedReason(const std::string& token, const std::string& method,
                           const std::string& role) {
  if (token.empty()) return codec::reason::kTokenMissing;
  if (token == "wrong") return codec::reason::kTokenUnknown;
  if (token == "elsewhere" && method == kOfNoMesh) return "";
  const std::map<std::string, int> order = {{"any", 0}, {"read", 1}, {"edit", 2}, {"admin", 3}};
  const int has = order.contains(token) ? order.at(token) : 0;  // others: of other meshes
  return has >= order.at(role) ? "" : codec::reason::kRoleMissing;
}

TEST_F(TokenTest, EveryMethodAsksForItsRole) {
  const std::map<std::string, Row> rows = Methods();
  const auto* service = google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(
      "dynmesh.v1.MeshService");
  ASSERT_NE(service, nullptr);
  for (int i = 0; i < service->method_count(); ++i) {
    EXPECT_TRUE(rows.contains(service->method(i)->name())) << service->method(i)->name();
  }
  StartWithTokens({Line("read", "read=crack-*"), Line("edit", "edit=crack-*"),
                   Line("admin", "admin=crack-*"), Line("elsewhere", "admin=plate-*")});
  ASSERT_TRUE(As("admin")->CreateMesh("crack-1", {}).ok());
  for (const auto& [name, row] : rows) {
    for (const std::string token : {"", "wrong", "elsewhere", "read", "edit", "admin"}) {
      grpc::ClientContext context;
      if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
      const absl::Status status = codec::FromGrpcStatus(row.call(*stub_, context));
      const std::string refused = ExpectedReason(token, name, row.role);
      const std::string expected = refused.empty() ? row.reason : refused;
      EXPECT_EQ(ReasonOf(status), expected) << name << " as '" << token << "' " << Text(status);
      if (expected.empty()) {
        EXPECT_TRUE(status.ok()) << name << " " << token << Text(status);
      } else if (refused.empty()) {
        EXPECT_EQ(status.code(), StatusCode::kFailedPrecondition) << name;
      } else if (expected == codec::reason::kRoleMissing) {
        const auto error = codec::GetServiceError(status);
        EXPECT_EQ(status.code(), StatusCode::kPermissionDenied);
        EXPECT_EQ(error->metadata.at("role"), row.role) << name;
        const char* const mesh = name == kOfNoMesh ? "meshes/*" : "meshes/crack-";
        EXPECT_EQ(error->metadata.at("mesh").rfind(mesh, 0), 0u) << name;
      } else {
        EXPECT_EQ(status.code(), StatusCode::kUnauthenticated);
      }
    }
  }
  EXPECT_EQ(Health(""), 1);  // open to all
}

TEST_F(TokenTest, ListsShowWhatTheTokenMayRead) {
  StartWithTokens({Line("root", "admin=*"), Line("lab", "read=crack-*")});
  for (const char* id : {"a", "crack-1", "crack-2", "m", "z"}) {
    ASSERT_TRUE(As("root")->CreateMesh(id, {}).ok());
  }
  EXPECT_EQ(As("root")->ListMeshes()->size(), 5u);
  const auto listed = As("lab")->ListMeshes();
  ASSERT_EQ(listed->size(), 2u);
  EXPECT_EQ((*listed)[1].id, "crack-2");
  // In pages as well, and meshes of others do not make pages short.
  grpc::ClientContext context;
  context.AddMetadata("authorization", "Bearer lab");
  v1::ListMeshesRequest request;
  request.set_page_size(2);
  v1::ListMeshesResponse response;
  ASSERT_TRUE(stub_->ListMeshes(&context, request, &response).ok());
  EXPECT_EQ(response.meshes_size(), 2);
  EXPECT_EQ(response.next_page_token(), "");
  // A caller without the right to read a mesh does not learn whether it exists.
  EXPECT_EQ(Text(As("lab")->GetMesh("m").status()).find("not exist"), std::string::npos);
  EXPECT_EQ(ReasonOf(As("lab")->GetMesh("none").status()), codec::reason::kRoleMissing);
}

TEST_F(TokenTest, OnlyWhoMayMakeAnyMeshLetsTheServerChooseItsId) {
  StartWithTokens({Line("root", "admin=*"), Line("lab", "admin=crack-*")});
  EXPECT_TRUE(As("root")->CreateMesh("", {}).ok());
  EXPECT_EQ(ReasonOf(As("lab")->CreateMesh("", {}).status()), codec::reason::kRoleMissing);
}

// Ids of requests are a client's own, and a mesh with a name is another content than one without.
TEST_F(TokenTest, ARequestIdFindsNoMeshThatAnotherClientMade) {
  StartWithTokens({Line("one", "admin=*"), Line("two", "admin=*")});
  const auto make = [this](const char* token, const char* id) {
    return As(token)->CreateMesh(id, {}, "r1");
  };
  const auto named = make("one", "plate");
  ASSERT_TRUE(named.ok()) << Text(named.status());
  EXPECT_EQ(make("one", "plate")->id, "plate");  // a retry
  const auto fresh = make("one", "");
  ASSERT_TRUE(fresh.ok()) << Text(fresh.status());
  EXPECT_NE(fresh->id, "plate");
  EXPECT_EQ(make("one", "")->id, fresh->id);
  const auto other = make("two", "");
  ASSERT_TRUE(other.ok()) << Text(other.status());
  EXPECT_NE(other->id, "plate");
  EXPECT_NE(other->id, fresh->id);
  EXPECT_EQ(make("two", "")->id, other->id);
  EXPECT_EQ(ReasonOf(make("two", "plate").status()), codec::reason::kMeshExists);
}

// What one client takes of a limit that all share leaves the others a half.
class ShareTest : public TokenTest {
 protected:
  void Start(const std::vector<std::string>& tokens) {
    ServerConfig config;
    config.max_snapshot_streams = 4;
    config.max_builds = 4;
    config.max_batch_edits = 10;
    config.max_pending_edits = 40;
    config.max_waiting_edits = 4;
    std::vector<std::string> lines;
    for (const std::string& token : tokens) lines.push_back(Line(token, "admin=*"));
    StartWithTokens(lines, config);
    ASSERT_TRUE(As(tokens.front())->CreateMesh("m", {}).ok());
  }

  // A build that has sent its first message and no more.
  std::unique_ptr<RawBuild> BeginBuild(const std::string& token, int features) {
    auto build = std::make_unique<RawBuild>(*stub_, MeshOptions(), token);
    for (int i = 0; i < features; ++i) {
      build->Add(Feature::Point(static_cast<FeatureId>(i) + 1, 0.1 + 0.05 * i, 0.1 + 0.05 * i));
    }
    build->Send();
    return build;
  }
  // Adds such builds that have their places.
  void HoldBuilds(const std::string& token, int count, int features,
                  std::vector<std::unique_ptr<RawBuild>>& builds) {
    const std::size_t before = builds.size();
    for (int i = 0; i < count; ++i) builds.push_back(BeginBuild(token, features));
    for (std::size_t i = before; i < builds.size(); ++i) {
      ASSERT_TRUE(builds[i]->WaitUntilReceived().has_value()) << i;
    }
  }
  static void Cancel(const std::vector<std::unique_ptr<RawBuild>>& builds) {
    for (const auto& build : builds) build->context().TryCancel();
    for (const auto& build : builds) EXPECT_FALSE(build->Finish().ok());
  }
};

TEST_F(ShareTest, OfBuildsOneClientGetsHalfAndTheLogNamesTheHolders) {
  Start({"greedy", "other"});
  std::vector<std::unique_ptr<RawBuild>> builds;
  EXPECT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  HoldBuilds("greedy", 2, 1, builds);
  const auto third = BeginBuild("greedy", 1);
  third->HalfClose();
  absl::Status refused = third->Finish();
  ASSERT_EQ(ReasonOf(refused), codec::reason::kClientStreamLimit) << refused;
  const auto error = codec::GetServiceError(refused);
  EXPECT_EQ(error->metadata.at("client"), "token greedy");
  EXPECT_EQ(error->metadata.at("limit"), "concurrent builds");
  EXPECT_NE(Text(refused).find("2 of 4"), std::string::npos) << Text(refused);
  HoldBuilds("other", 2, 1, builds);
  const auto fifth = BeginBuild("other", 1);
  fifth->HalfClose();
  refused = fifth->Finish();
  ASSERT_EQ(ReasonOf(refused), codec::reason::kStreamLimit) << refused;
  // Names of others are for the log.
  EXPECT_EQ(Text(refused).find("greedy"), std::string::npos) << Text(refused);
  const auto of_all = codec::GetServiceError(refused);
  for (const auto& [key, value] : of_all->metadata) {
    EXPECT_EQ(value.find("greedy"), std::string::npos) << key;
  }
  EXPECT_TRUE(SetLogLevel("error").ok());
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("holders=\"token other 2, token greedy 2\""), std::string::npos) << log;
  Cancel(builds);
}

TEST_F(ShareTest, EditsThatWaitCountFromTheFirstPartOfABatch) {
  Start({"greedy", "other"});
  std::vector<std::unique_ptr<RawBuild>> builds;
  HoldBuilds("greedy", 2, 10, builds);
  const absl::Status refused = As("greedy")->Apply("m", {AddPoint(1)}).status();
  EXPECT_EQ(ReasonOf(refused), codec::reason::kPendingLimit);
  EXPECT_EQ(codec::GetServiceError(refused)->metadata.at("client"), "token greedy");
  EXPECT_NE(Text(refused).find("20 of 40"), std::string::npos) << Text(refused);
  EXPECT_TRUE(As("other")->Apply("m", {AddPoint(2), AddPoint(3)}).ok());
  Cancel(builds);
  test::WaitUntil("the places", [&] { return As("greedy")->Apply("m", {AddPoint(1)}).ok(); });
}

TEST_F(ShareTest, OfThePlacesBehindAnEditOneClientGetsHalf) {
  Start({"greedy", "other"});
  gate_->Hold();
  std::vector<std::thread> editors;
  std::atomic<int> done = 0;
  const auto edit = [&](const std::string& token, FeatureId id) {
    editors.emplace_back([this, token, id, &done] {
      EXPECT_TRUE(As(token)->Apply("m", {AddPoint(id)}).ok());
      ++done;
    });
  };
  const auto host = Host();
  edit("greedy", 1);
  gate_->WaitForArrivals(1);
  edit("greedy", 2);
  edit("greedy", 3);
  test::WaitUntil("two that wait", [&] { return host->waiting() == 2; });
  const absl::Status refused = As("greedy")->Apply("m", {AddPoint(4)}).status();
  EXPECT_EQ(ReasonOf(refused), codec::reason::kQueueFull) << refused;
  EXPECT_EQ(codec::GetServiceError(refused)->metadata.at("client"), "token greedy");
  EXPECT_NE(Text(refused).find("2 of 4"), std::string::npos) << Text(refused);
  const std::vector<double> point = {0.5, 0.5};
  const absl::Status query = As("greedy")->Locate("m", 2, point).status();
  EXPECT_EQ(ReasonOf(query), codec::reason::kQueueFull) << query;
  edit("other", 5);
  edit("other", 6);
  test::WaitUntil("four that wait", [&] { return host->waiting() == 4; });
  const absl::Status of_all = As("other")->Apply("m", {AddPoint(7)}).status();
  EXPECT_EQ(ReasonOf(of_all), codec::reason::kQueueFull) << of_all;
  EXPECT_EQ(done, 0);
  gate_->Release();
  for (std::thread& editor : editors) editor.join();
  EXPECT_TRUE(As("greedy")->Apply("m", {AddPoint(4)}).ok());
}

TEST_F(ShareTest, ASingleTokenMayHaveAll) {
  Start({"only"});
  std::vector<std::unique_ptr<RawBuild>> builds;
  HoldBuilds("only", 4, 10, builds);
  const absl::Status refused = As("only")->Apply("m", {AddPoint(1)}).status();
  EXPECT_EQ(ReasonOf(refused), codec::reason::kPendingLimit);
  EXPECT_FALSE(codec::GetServiceError(refused)->metadata.contains("client"));
  Cancel(builds);
}

TEST_F(TokenTest, TwoTokensAtOnceAreNone) {
  StartWithTokens({Line("root", "admin=*")});
  grpc::ClientContext context;
  context.AddMetadata("authorization", "Bearer wrong");
  context.AddMetadata("authorization", "Bearer root");
  v1::ListMeshesResponse response;
  EXPECT_EQ(stub_->ListMeshes(&context, {}, &response).error_code(),
            grpc::StatusCode::UNAUTHENTICATED);
}

TEST_F(TokenTest, TakingATokenOutEndsItsStreamsAndNoOthers) {
  StartWithTokens({Line("root", "admin=*"), Line("lab", "edit=m")});
  ASSERT_TRUE(As("root")->CreateMesh("m", {}).ok());
  const auto stays = As("root")->Watch("m", {}, nullptr);
  const auto lab = As("lab");
  const auto goes = lab->Watch("m", {}, nullptr);
  const auto edits = lab->OpenEdits("m");
  ASSERT_TRUE(edits->Send({AddPoint(1)}).ok());
  ASSERT_TRUE(edits->Receive().has_value());
  ASSERT_TRUE(goes->WaitForRevision(1, kLong));
  // As any client sees it.
  grpc::ClientContext context;
  context.AddMetadata("authorization", "Bearer lab");
  const auto raw = stub_->Watch(&context, About<v1::WatchRequest>("meshes/m"));
  Tokens({Line("root", "admin=*")});  // the ticker sees it
  EXPECT_FALSE(edits->Receive().has_value());
  EXPECT_EQ(edits->Finish().code(), StatusCode::kUnavailable);
  v1::WatchEvent event;
  while (raw->Read(&event)) {
  }
  const grpc::Status ended = raw->Finish();
  EXPECT_EQ(ended.error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(ended.error_message(), "TOKEN_UNKNOWN: the token lab was removed");
  EXPECT_EQ(ReasonOf(lab->OpenEdits("m")->Finish()), codec::reason::kTokenUnknown);
  goes->WaitFor([](const auto&) { return false; }, kLong);
  ASSERT_TRUE(goes->ended().has_value());
  EXPECT_EQ(ReasonOf(*goes->ended()), codec::reason::kTokenUnknown);
  ASSERT_TRUE(As("root")->Apply("m", {AddPoint(2)}).ok());
  EXPECT_TRUE(stays->WaitForRevision(2, kLong));
  EXPECT_EQ(stays->reconnects(), 0);
  EXPECT_EQ(HeadOf().revision, 2u);
}

}  // namespace
}  // namespace dynmesh::server::security_test
