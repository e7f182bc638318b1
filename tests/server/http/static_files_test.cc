#include "server/http/static_files.h"

#include <gtest/gtest.h>

#include "absl/strings/match.h"

namespace dynmesh::server::static_files_test {
namespace {

constexpr StaticFile kFiles[] = {{"/index.html", "text/html", "aa", "<p>"},
                                 {"/assets/x-1.js", "text/javascript", "bb", "1;"}};

std::optional<HttpReply> Ask(const std::string& method, const std::string& path,
                             HttpHeaders headers = {}) {
  HttpRequest request;
  request.method = method;
  request.path = path;
  request.headers = std::move(headers);
  return AnswerWithFile(kFiles, request);
}

std::string HeaderOf(const HttpReply& reply, const std::string& name) {
  for (const auto& [known, value] : reply.headers) {
    if (known == name) return value;
  }
  return "";
}

TEST(StaticFiles, TheRootIsTheIndex) {
  const auto reply = Ask("GET", "/");
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 200);
  EXPECT_EQ(reply->type, "text/html");
  EXPECT_EQ(reply->body, "<p>");
  EXPECT_EQ(HeaderOf(*reply, "Cache-Control"), "no-cache");
  EXPECT_EQ(HeaderOf(*reply, "ETag"), "\"aa\"");
}

TEST(StaticFiles, ThePageLoadsFromItsServerAlone) {
  const std::string policy = HeaderOf(*Ask("GET", "/"), "Content-Security-Policy");
  EXPECT_TRUE(absl::StrContains(policy, "default-src 'none'")) << policy;
  EXPECT_TRUE(absl::StrContains(policy, "frame-ancestors 'none'")) << policy;
  EXPECT_FALSE(absl::StrContains(policy, "unsafe")) << policy;
  EXPECT_FALSE(absl::StrContains(policy, "*")) << policy;
  EXPECT_FALSE(absl::StrContains(policy, "http")) << policy;
}

TEST(StaticFiles, WhatTheBrowserHasIsNotSentAgain) {
  for (const char* known : {"\"aa\"", "\"cc\", W/\"aa\"", "*"}) {
    const auto reply = Ask("GET", "/index.html", {{"If-None-Match", known}});
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, 304) << known;
    EXPECT_EQ(reply->body, "") << known;
    const std::string head = HttpReplyHead(*reply, false, false);
    EXPECT_FALSE(absl::StrContains(head, "Content-Length")) << head;
    EXPECT_FALSE(absl::StrContains(head, "Content-Type")) << head;
  }
  for (const char* other : {"\"bb\"", "aa", "\"a\"", ""}) {
    EXPECT_EQ(Ask("GET", "/index.html", {{"If-None-Match", other}})->status, 200) << other;
  }
}

TEST(StaticFiles, FilesAreReadAlone) {
  EXPECT_EQ(Ask("HEAD", "/")->status, 200);
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "get"}) {
    const auto reply = Ask(method, "/");
    ASSERT_TRUE(reply) << method;
    EXPECT_EQ(reply->status, 405) << method;
    EXPECT_EQ(HeaderOf(*reply, "Allow"), "GET, HEAD");
  }
}

TEST(StaticFiles, OtherPathsAreNotFiles) {
  for (const char* path : {"", "/index", "/INDEX.HTML", "//index.html", "/assets/",
                           "/assets/../index.html", "/%69ndex.html", "index.html"}) {
    EXPECT_FALSE(Ask("GET", path)) << path;
  }
}

}  // namespace
}  // namespace dynmesh::server::static_files_test
