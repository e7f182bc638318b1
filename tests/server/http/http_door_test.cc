// The service over HTTP: the same answers, rights and limits as by gRPC.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "proto/codec/token_hash.h"
#include "server/http/connect_protocol.h"
#include "tests/server/http/http_get.h"
#include "tests/server/server_fixture.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server::http_door_test {
namespace {

using nlohmann::json;
using Answer = HttpAnswer;

// The bytes of an answer in chunks.
std::string Unchunked(std::string_view body) {
  std::string whole;
  while (true) {
    const std::size_t line = body.find("\r\n");
    if (line == std::string_view::npos) return whole;
    const std::size_t size = std::stoul(std::string(body.substr(0, line)), nullptr, 16);
    if (size == 0 || body.size() < line + 2 + size) return whole;
    whole += body.substr(line + 2, size);
    body.remove_prefix(line + 2 + size + 2);
  }
}

struct Message {
  int flags = 0;
  std::string bytes;
};
std::vector<Message> MessagesOf(std::string_view body) {
  std::vector<Message> messages;
  while (body.size() >= connectrpc::kPrefixBytes) {
    std::size_t size = 0;
    for (int i = 1; i < 5; ++i) size = size << 8 | static_cast<unsigned char>(body[i]);
    if (body.size() < 5 + size) break;
    messages.push_back({body[0], std::string(body.substr(5, size))});
    body.remove_prefix(5 + size);
  }
  return messages;
}

class HttpDoorTest : public ServerFixture {
 protected:
  void Start(ServerConfig config = {}) {
    config.http = "127.0.0.1:0";
    StartServer(std::move(config));
  }
  Answer Post(const std::string& method, const std::string& type, const std::string& body,
              const std::string& more = "") const {
    return ParseHttp(SendHttp(server_->http_address(), Request(method, type, body, more)));
  }
  static std::string Request(const std::string& method, const std::string& type,
                             const std::string& body, const std::string& more = "") {
    return absl::StrCat("POST /dynmesh.v1.MeshService/", method, " HTTP/1.1\r\nHost: 127.0.0.1\r\n",
                        "Connection: close\r\nContent-Type: ", type, "\r\n", more,
                        "Content-Length: ", body.size(), "\r\n\r\n", body);
  }
  Answer Get(const std::string& path, const std::string& more = "") const {
    return ParseHttp(SendHttp(
        server_->http_address(),
        absl::StrCat("GET ", path, " HTTP/1.1\r\nHost: x\r\nConnection: close\r\n", more, "\r\n")));
  }
  Answer Json(const std::string& method, const json& body, const std::string& more = "") const {
    return Post(method, "application/json", body.dump(), more);
  }
  std::vector<Message> Stream(const std::string& method, const json& body,
                              const std::string& more = "") const {
    const Answer answer =
        Post(method, "application/connect+json", connectrpc::Envelope(0, body.dump()), more);
    EXPECT_EQ(answer.status, 200) << answer.body;
    return MessagesOf(Unchunked(answer.body));
  }
  static json Box() { return {{"lo", {{"x", 0}, {"y", 0}}}, {"hi", {{"x", 1}, {"y", 1}}}}; }
};

TEST_F(HttpDoorTest, AMeshIsMadeEditedAndReadAsJson) {
  Start();
  const Answer made = Json("CreateMesh", {{"meshId", "m"}, {"options", {{"box", Box()}}}});
  ASSERT_EQ(made.status, 200) << made.body;
  EXPECT_EQ(json::parse(made.body)["name"], "meshes/m");
  EXPECT_TRUE(absl::StrContains(made.headers, "X-Request-Id: "));

  const auto diffs =
      Stream("AddFeatures", {{"mesh", "meshes/m"},
                             {"requestId", "r"},
                             {"features", {{{"id", "1"}, {"point", {{"x", 0.25}, {"y", 0.5}}}}}}});
  ASSERT_GE(diffs.size(), 2u);
  EXPECT_EQ(diffs.back().flags, connectrpc::kEndOfStream);
  EXPECT_EQ(diffs.back().bytes, "{}");
  EXPECT_EQ(json::parse(diffs[0].bytes)["toRevision"], "1") << diffs[0].bytes;

  const auto mesh = client_->GetMesh("meshes/m");
  ASSERT_TRUE(mesh.ok());
  EXPECT_EQ(mesh->revision, 1u);
}

TEST_F(HttpDoorTest, ProtobufIsAnsweredAsProtobuf) {
  Start();
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  v1::GetMeshRequest request;
  request.set_mesh("meshes/m");
  const Answer answer = Post("GetMesh", "application/proto", request.SerializeAsString());
  ASSERT_EQ(answer.status, 200) << answer.body;
  v1::Mesh mesh;
  ASSERT_TRUE(mesh.ParseFromString(answer.body));
  EXPECT_EQ(mesh.name(), "meshes/m");
}

TEST_F(HttpDoorTest, ErrorsAreThoseOfTheService) {
  Start();
  const Answer unary = Json("GetMesh", {{"mesh", "meshes/x"}});
  EXPECT_EQ(unary.status, 404);
  const json error = json::parse(unary.body);
  EXPECT_EQ(error["code"], "not_found");
  EXPECT_EQ(error["details"][0]["debug"]["reason"], "MESH_NOT_FOUND");

  const auto stream = Stream("GetSnapshot", {{"mesh", "meshes/x"}});
  ASSERT_EQ(stream.size(), 1u);
  EXPECT_EQ(stream[0].flags, connectrpc::kEndOfStream);
  EXPECT_EQ(json::parse(stream[0].bytes)["error"]["code"], "not_found");

  EXPECT_EQ(Json("GetMesh", {{"mesch", "x"}}).status, 400);
  EXPECT_EQ(Json("NoMethod", json::object()).status, 501);
  EXPECT_EQ(Post("GetMesh", "text/plain", "{}").status, 415);
  EXPECT_EQ(Post("GetMesh", "application/connect+json", "{}").status, 415);
  EXPECT_EQ(Post("Watch", "application/json", "{}").status, 415);
  const Answer bidi = Post("EditStream", "application/connect+json", connectrpc::Envelope(0, "{}"));
  EXPECT_EQ(bidi.status, 501);
  EXPECT_TRUE(absl::StrContains(bidi.body, "unimplemented")) << bidi.body;
  EXPECT_EQ(Json("LoadFeatures", json::object()).status, 501);
  EXPECT_EQ(ParseHttp(SendHttp(server_->http_address(),
                               "GET /nothing HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"))
                .status,
            404);
}

TEST_F(HttpDoorTest, TheTimeOfACallIsBounded) {
  Start();
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  const auto events = Stream("Watch", {{"mesh", "meshes/m"}}, "Connect-Timeout-Ms: 200\r\n");
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(json::parse(events.back().bytes)["error"]["code"], "deadline_exceeded");
  EXPECT_EQ(Json("GetMesh", {{"mesh", "meshes/m"}}, "Connect-Timeout-Ms: soon\r\n").status, 400);
}

TEST_F(HttpDoorTest, AWatchThatItsClientLeavesEnds) {
  Start();
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  const int socket = ConnectHttp(server_->http_address());
  const std::string request = Request("Watch", "application/connect+json",
                                      connectrpc::Envelope(0, R"({"mesh":"meshes/m"})"));
  send(socket, request.data(), request.size(), MSG_NOSIGNAL);
  ASSERT_TRUE(Eventually([&] { return server_->http_counts().open == 1; }));
  close(socket);
  EXPECT_TRUE(Eventually([&] { return server_->http_counts().open == 0; }));
}

TEST_F(HttpDoorTest, WatchesEndWithTheServer) {
  Start();
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  std::vector<Message> events;
  std::thread watcher([&] { events = Stream("Watch", {{"mesh", "meshes/m"}}); });
  ASSERT_TRUE(Eventually([&] { return server_->http_counts().open == 1; }));
  absl::SleepFor(absl::Milliseconds(200));
  EXPECT_TRUE(server_->Drain(absl::Seconds(20)));
  watcher.join();
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back().flags, connectrpc::kEndOfStream);
  EXPECT_EQ(json::parse(events.back().bytes)["error"]["code"], "unavailable");
}

TEST_F(HttpDoorTest, TokensAndRolesAreThoseOfTheService) {
  const test::TempFolder folder;
  test::WriteAtOnce(folder.path() + "/tokens",
                    absl::StrCat("lab ", codec::ToHex(codec::HashToken("secret")), " read=*\n"));
  ServerConfig config;
  config.tokens_file = folder.path() + "/tokens";
  Start(config);
  const std::string token = "Authorization: Bearer secret\r\n";
  EXPECT_EQ(Json("ListMeshes", json::object()).status, 401);
  EXPECT_EQ(Json("ListMeshes", json::object(), "Authorization: Bearer wrong\r\n").status, 401);
  // gRPC ends a process that sends such bytes.
  for (const char* const bytes : {"\xff", "\x80secret", "a\tb"}) {
    EXPECT_EQ(
        Json("ListMeshes", json::object(), absl::StrCat("Authorization: Bearer ", bytes, "\r\n"))
            .status,
        401);
  }
  EXPECT_EQ(Json("ListMeshes", json::object(), "Authorization: Bearer %0A\r\n").status, 401);
  EXPECT_EQ(Json("ListMeshes", json::object(), token).status, 200);
  EXPECT_EQ(Json("CreateMesh", {{"meshId", "m"}, {"options", {{"box", Box()}}}}, token).status,
            403);
  // A page of another site has no token of this one.
  const std::string origin = "Origin: http://evil.example\r\n";
  EXPECT_EQ(Json("ListMeshes", json::object(), origin).status, 403);
  EXPECT_EQ(Json("ListMeshes", json::object(), origin + token).status, 200);
}

TEST_F(HttpDoorTest, PagesOfOtherSitesAreRefused) {
  Start();
  EXPECT_EQ(Json("ListMeshes", json::object(), "Sec-Fetch-Site: cross-site\r\n").status, 403);
  // Without tokens a word in the header proves nothing.
  EXPECT_EQ(Json("ListMeshes", json::object(),
                 "Origin: http://evil.example\r\nAuthorization: Bearer x\r\n")
                .status,
            403);
  EXPECT_EQ(Json("ListMeshes", json::object(), "Origin: http://127.0.0.1\r\n").status, 200);
}

TEST_F(HttpDoorTest, FilesOfThePageAreForAllPages) {
  static constexpr StaticFile kPage[] = {{"/index.html", "text/html", "1", "<p>page</p>"},
                                         {"/assets/a.js", "text/javascript", "2", "1"}};
  page_ = kPage;
  Start();
  for (const char* path : {"/", "/index.html", "/?mesh=m"}) {
    const Answer page = Get(path, "Sec-Fetch-Site: cross-site\r\n");
    EXPECT_EQ(page.status, 200) << path;
    EXPECT_EQ(page.body, "<p>page</p>") << path;
  }
  EXPECT_EQ(Get("/assets/a.js").body, "1");
  EXPECT_EQ(Get("/assets/b.js").status, 404);
  EXPECT_EQ(Get("/assets/../index.html").status, 404);
}

TEST_F(HttpDoorTest, AProgramWithoutAPageSaysSo) {
  Start();
  const Answer answer = Get("/");
  EXPECT_EQ(answer.status, 404);
  EXPECT_TRUE(absl::StrContains(answer.body, "without its page")) << answer.body;
}

TEST_F(HttpDoorTest, AProxysNameIsThatOfTheServersPages) {
  ServerConfig config;
  config.http_name = "mesh.example";
  Start(config);
  EXPECT_EQ(Json("ListMeshes", json::object(),
                 "Origin: https://mesh.example\r\nSec-Fetch-Site: same-origin\r\n")
                .status,
            200);
  EXPECT_EQ(Json("ListMeshes", json::object(), "Origin: https://evil.example\r\n").status, 403);
}

TEST_F(HttpDoorTest, TheClientsAddressIsItsOwn) {
  ServerConfig config;
  config.max_requests_per_second = 1;
  Start(config);
  for (int i = 0; i < 3; ++i) {
    const Answer answer = Json("ListMeshes", json::object());
    if (answer.status == 200) continue;
    EXPECT_EQ(answer.status, 429);
    EXPECT_TRUE(absl::StrContains(answer.body, "address ipv4:127.0.0.1")) << answer.body;
    return;
  }
  FAIL() << "no request was refused";
}

TEST_F(HttpDoorTest, WhatCannotBeListenedOnIsNamed) {
  ServerConfig config;
  config.listen = "127.0.0.1:0";
  config.http = "nonsense";
  const auto start = [&] {
    return Server::Start(config, [](const MeshOptions& o,
                                    const ApplyOptions&) { return MakeFake(o, nullptr); })
        .status();
  };
  EXPECT_EQ(start().code(), absl::StatusCode::kInvalidArgument);
  config.http = "0.0.0.0:0";
  EXPECT_EQ(start().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(absl::StrContains(start().message(), "--insecure-listen"));
  config.http = "0.0.0.0";
  EXPECT_EQ(start().code(), absl::StatusCode::kInvalidArgument);
  config.http = "";
  for (const char* const open : {"0.0.0.0", "host", "5"}) {
    config.listen = open;
    EXPECT_EQ(start().code(), absl::StatusCode::kInvalidArgument) << open;
  }
}

}  // namespace
}  // namespace dynmesh::server::http_door_test
