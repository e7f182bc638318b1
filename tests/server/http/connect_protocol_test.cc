// The Connect protocol and JSON of messages, without connections; whose requests are refused.
#include "server/http/connect_protocol.h"

#include <gtest/gtest.h>

#include "dynmesh/v1/mesh_service.pb.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/status_codec.h"
#include "server/http/cross_site.h"
#include "server/http/message_json.h"

namespace dynmesh::server::connect_protocol_test {
namespace {

using absl::StatusCode;

TEST(ConnectProtocol, TypesOfContentNameTheCodec) {
  for (const char* const type : {"application/json", "application/proto",
                                 "application/connect+json", "application/connect+proto"}) {
    const auto codec = connectrpc::CodecOf(type);
    ASSERT_TRUE(codec.has_value()) << type;
    EXPECT_STREQ(connectrpc::TypeOf(*codec), type);
  }
  EXPECT_TRUE(connectrpc::CodecOf("Application/JSON; charset=utf-8")->is_json);
  EXPECT_FALSE(connectrpc::CodecOf("application/proto")->is_json);
  EXPECT_TRUE(connectrpc::CodecOf("application/connect+proto")->is_stream);
  for (const char* const type : {"", "text/plain", "application/jsonp", "application/grpc-web"}) {
    EXPECT_FALSE(connectrpc::CodecOf(type).has_value()) << type;
  }
}

TEST(ConnectProtocol, CodesHaveNamesAndStatuses) {
  EXPECT_STREQ(connectrpc::NameOf(grpc::StatusCode::NOT_FOUND), "not_found");
  EXPECT_STREQ(connectrpc::NameOf(grpc::StatusCode::CANCELLED), "canceled");
  EXPECT_STREQ(connectrpc::NameOf(static_cast<grpc::StatusCode>(77)), "unknown");
  EXPECT_EQ(connectrpc::HttpStatusOf(grpc::StatusCode::UNAUTHENTICATED), 401);
  EXPECT_EQ(connectrpc::HttpStatusOf(grpc::StatusCode::RESOURCE_EXHAUSTED), 429);
  EXPECT_EQ(connectrpc::HttpStatusOf(static_cast<grpc::StatusCode>(-1)), 500);
}

TEST(ConnectProtocol, ErrorsHaveTheirDetailsAsBytesAndReadable) {
  codec::ServiceError error;
  error.reason = "MESH_NOT_FOUND";
  error.metadata["mesh"] = "meshes/m";
  const grpc::Status status =
      codec::ToGrpcStatus(codec::MakeServiceError(StatusCode::kNotFound, "none", error), "");
  const std::string json = connectrpc::ErrorJson(status);
  EXPECT_NE(json.find("\"code\":\"not_found\""), std::string::npos) << json;
  EXPECT_NE(json.find("\"message\":\"none\""), std::string::npos) << json;
  EXPECT_NE(json.find("\"type\":\"google.rpc.ErrorInfo\""), std::string::npos) << json;
  EXPECT_NE(json.find("\"reason\":\"MESH_NOT_FOUND\""), std::string::npos) << json;
  EXPECT_EQ(json.find('='), std::string::npos) << "base64 is padded: " << json;
  EXPECT_EQ(connectrpc::ErrorJson({grpc::StatusCode::INTERNAL, ""}), "{\"code\":\"internal\"}");
  // Not UTF-8, and details that are none.
  EXPECT_NE(
      connectrpc::ErrorJson({grpc::StatusCode::INTERNAL, "a\xff", "\xff\xff"}).find("internal"),
      std::string::npos);
}

TEST(ConnectProtocol, TimeoutsAreOfAtMostTenDigits) {
  EXPECT_EQ(connectrpc::ParseTimeout("1500")->count(), 1500);
  EXPECT_EQ(connectrpc::ParseTimeout("9999999999")->count(), 9'999'999'999);
  for (const char* const text : {"", "-1", "1.5", " 1", "+1", "10000000000", "1s"}) {
    EXPECT_EQ(connectrpc::ParseTimeout(text).status().code(), StatusCode::kInvalidArgument) << text;
  }
}

TEST(ConnectProtocol, EnvelopesAreOpenedAsTheyWereClosed) {
  for (const std::size_t size : {0u, 1u, 255u, 256u, 70'000u}) {
    const std::string message(size, 'x');
    const std::string envelope = connectrpc::Envelope(0, message);
    ASSERT_EQ(envelope.size(), size + connectrpc::kPrefixBytes);
    const auto opened = connectrpc::OpenEnvelope(envelope);
    ASSERT_TRUE(opened.ok()) << opened.status();
    EXPECT_EQ(*opened, message);
    EXPECT_FALSE(connectrpc::OpenEnvelope(envelope + "y").ok());
    EXPECT_FALSE(connectrpc::OpenEnvelope(envelope.substr(0, envelope.size() - 1)).ok());
  }
  EXPECT_FALSE(connectrpc::OpenEnvelope(connectrpc::Envelope(connectrpc::kCompressed, "x")).ok());
  EXPECT_EQ(connectrpc::EndOfStream(grpc::Status::OK),
            connectrpc::Envelope(connectrpc::kEndOfStream, "{}"));
}

TEST(MessageJson, GoesToBytesAndBack) {
  v1::CreateMeshRequest request;
  request.set_mesh_id("m");
  request.mutable_options()->mutable_box()->mutable_lo()->set_x(-1.5);
  const auto& type = *v1::CreateMeshRequest::descriptor();
  const auto json = BytesToJson(type, request.SerializeAsString());
  ASSERT_TRUE(json.ok()) << json.status();
  EXPECT_EQ(*json, R"({"meshId":"m","options":{"box":{"lo":{"x":-1.5}}}})");
  const auto bytes = JsonToBytes(type, *json);
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  EXPECT_EQ(*bytes, request.SerializeAsString());
  EXPECT_EQ(*JsonToBytes(type, " \n"), "");
}

TEST(MessageJson, WhatIsNoJsonOfTheTypeIsNamed) {
  const auto& type = *v1::GetMeshRequest::descriptor();
  for (const char* const text : {"{\"mesch\":\"m\"}", "{", "[]", "{\"mesh\":{}}", "null null"}) {
    const absl::Status status = JsonToBytes(type, text).status();
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << text;
  }
  EXPECT_NE(JsonToBytes(type, "{\"mesch\":\"m\"}").status().message().find("mesch"),
            absl::string_view::npos);
  EXPECT_EQ(BytesToJson(type, "\xff").status().code(), StatusCode::kInternal);
  // Deeper than any message, as an attack on the stack would be.
  EXPECT_FALSE(JsonToBytes(type, std::string(100'000, '[')).ok());
}

struct Page {
  const char* host;
  const char* origin;
  const char* site;
  bool is_refused;
};

TEST(CrossSite, PagesOfOtherSitesAreRefused) {
  const Page pages[] = {
      {"127.0.0.1:80", nullptr, nullptr, false},  // no browser
      {"any.example", nullptr, nullptr, false},
      {"127.0.0.1:80", "http://127.0.0.1:80", "same-origin", false},
      {"127.0.0.1:80", nullptr, "none", false},  // typed by the user
      {"localhost:80", "http://localhost:80", nullptr, false},
      {"[::1]:80", "http://[::1]:80", "same-origin", false},
      {"mesh.example:80", "http://mesh.example:80", "same-origin", false},
      {"mesh.example", "https://MESH.example", nullptr, false},
      {"127.0.0.1:80", "https://mesh.example", "same-origin", false},  // by a proxy
      {"127.0.0.1:80", "https://mesh.example.evil", "same-origin", true},
      {"127.0.0.1:80", "http://evil.example", "cross-site", true},
      {"127.0.0.1:80", "http://evil.example", nullptr, true},
      {"127.0.0.1:80", "http://127.0.0.1:81", "same-site", true},
      {"127.0.0.1:80", "http://127.0.0.1:81", nullptr, true},
      {"127.0.0.1:80", "null", nullptr, true},
      {"127.0.0.1:80", nullptr, "cross-site", true},
      {"evil.example:80", "http://evil.example:80", "same-origin", true},  // DNS rebinding
      {"127.0.0.1.evil.example", nullptr, "same-origin", true},
      {"", "http://", "same-origin", true},
  };
  for (const Page& page : pages) {
    HttpRequest request;
    request.headers.emplace_back("host", page.host);
    if (page.origin != nullptr) request.headers.emplace_back("ORIGIN", page.origin);
    if (page.site != nullptr) request.headers.emplace_back("Sec-Fetch-Site", page.site);
    EXPECT_EQ(!WhyCrossSite(request, "mesh.example").empty(), page.is_refused)
        << page.host << " " << (page.origin != nullptr ? page.origin : "") << " "
        << (page.site != nullptr ? page.site : "");
  }
}

}  // namespace
}  // namespace dynmesh::server::connect_protocol_test
