// Connections of HTTP: their limits, and clients that do not behave.
#include "server/http/http_server.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <random>
#include <thread>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "tests/server/http/http_get.h"
#include "tests/support/seed.h"

namespace dynmesh::server::http_server_test {
namespace {

using std::chrono::milliseconds;

constexpr char kClose[] = "Connection: close\r\n";

class HttpServerTest : public ::testing::Test {
 protected:
  void Listen(HttpServer::Limits limits = {}) {
    auto server = HttpServer::Listen("127.0.0.1", 0, limits,
                                     [this](const HttpRequest& request) { return Reply(request); });
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    address_ = absl::StrCat("127.0.0.1:", server_->port());
  }

  // What was asked; of /stream: pieces until the client goes; of /flood: as much as it takes.
  HttpReply Reply(const HttpRequest& request) {
    ++asked_;
    if (request.path == "/stream") {
      return {200, {}, "text/plain", "", [this](HttpSink& sink) {
                while (sink.Write("piece\n") && sink.IsOpen())
                  absl::SleepFor(absl::Milliseconds(5));
                ++streams_ended_;
              }};
    }
    if (request.path == "/flood") {
      return {200, {}, "text/plain", "", [this](HttpSink& sink) {
                const std::string piece(1 << 20, 'x');
                while (sink.Write(piece)) {
                }
                ++streams_ended_;
              }};
    }
    return {200,
            {{"X-Peer", request.peer}},
            "text/plain",
            absl::StrCat(request.method, " ", request.path, " ", request.body),
            nullptr};
  }

  static std::string Post(const std::string& body, const std::string& more = "") {
    return absl::StrCat("POST /p HTTP/1.1\r\nHost: x\r\n", more, "Content-Length: ", body.size(),
                        "\r\n\r\n", body);
  }
  ::dynmesh::server::HttpAnswer Send(const std::string& bytes) const {
    return ParseHttp(SendHttp(address_, bytes));
  }
  template <typename Condition>
  static bool Eventually(const Condition& condition) {
    for (int i = 0; i < 1000 && !condition(); ++i) absl::SleepFor(absl::Milliseconds(20));
    return condition();
  }

  std::atomic<int> asked_{0}, streams_ended_{0};
  std::unique_ptr<HttpServer> server_;
  std::string address_;
};

TEST_F(HttpServerTest, RequestsOfOneConnectionAreAnsweredInTheirOrder) {
  Listen();
  const int socket = ConnectHttp(address_);
  const std::string all =
      Post("one") + "GET /two HTTP/1.1\r\nHost: x\r\n\r\n" + Post("three", kClose);
  ASSERT_EQ(send(socket, all.data(), all.size(), MSG_NOSIGNAL), static_cast<ssize_t>(all.size()));
  const std::string said = ReceiveAll(socket);
  const std::size_t one = said.find("POST /p one"), two = said.find("GET /two"),
                    three = said.find("POST /p three");
  ASSERT_NE(three, std::string::npos) << said;
  EXPECT_LT(one, two);
  EXPECT_LT(two, three);
  EXPECT_TRUE(absl::StrContains(said, "X-Peer: ipv4:127.0.0.1:"));
}

TEST_F(HttpServerTest, WhatIsRefusedIsNoRequestBehindIt) {
  HttpServer::Limits limits;
  limits.most_request_bytes = 1000;
  limits.receive_limit = milliseconds(500);
  Listen(limits);
  const std::string inner = "POST /inner HTTP/1.1\r\nHost: x\r\nContent-Length: 0\r\n\r\n";
  const auto length = absl::StrCat("Content-Length: ", inner.size(), "\r\n\r\n", inner);
  const std::string host = "Host: x\r\n";
  const std::pair<std::string, int> refused[] = {
      {absl::StrCat("POST /", std::string(20'000, 'a'), " HTTP/1.1\r\n", host, length), 431},
      {absl::StrCat("POST /p HTTP/1.1\r\n", host, "A: ", std::string(20'000, 'a'), "\r\n", length),
       431},
      {absl::StrCat("POST /p HTTP/1.1\r\n", host, "Transfer-Encoding: chunked\r\n", length), 411},
      {absl::StrCat("POST /p HTTP/1.1\r\n", host, "Content-Encoding: gzip\r\n", length), 415},
      {absl::StrCat("POST /p HTTP/1.1\r\n", host, "Content-Length: 1001\r\n\r\n", inner), 413},
      {absl::StrCat("POST /p HTTP/1.1\r\n", host, "Content-Length: 0\r\n", length), 400},
      {absl::StrCat("POST /p HTTP/1.1\r\n", host, "Content-Length: +5\r\n\r\n", inner), 400},
      {absl::StrCat("POST /p HTTP/2.0\r\n", host, length), 505},
      {absl::StrCat("POST /p HTTP/1.1\r\n", length), 400},
      {absl::StrCat("POST  /p HTTP/1.1\r\n", host, length), 400},
      {absl::StrCat("POST /p HTTP/1.1\n", host, length), 400},
      {absl::StrCat("POST /p HTTP/1.1\r\n", host, " folded: x\r\n", length), 400},
      {absl::StrCat("POST /p HTTP/1.1\r\n", host, "A : x\r\n", length), 400},
  };
  for (const auto& [bytes, status] : refused) {
    asked_ = 0;
    EXPECT_EQ(Send(bytes).status, status) << bytes.substr(0, 200);
    EXPECT_EQ(asked_, 0) << bytes.substr(0, 200);
  }
  // A body is read with any method, and is no request.
  asked_ = 0;
  EXPECT_EQ(Send(absl::StrCat("GET /g HTTP/1.1\r\n", host, kClose, length)).status, 200);
  EXPECT_EQ(asked_, 1);
  EXPECT_EQ(Send(Post(std::string(1000, 'x'), kClose)).status, 200);
  EXPECT_EQ(Send(Post("x", absl::StrCat(kClose, "Content-Encoding: identity\r\n"))).status, 200);
  EXPECT_EQ(Send(absl::StrCat("POST /none HTTP/1.1\r\n", host, kClose, "\r\n")).status, 200);
}

TEST_F(HttpServerTest, OldClientsGetTheirContentWithoutChunks) {
  Listen();
  const auto plain = Send("GET /p HTTP/1.0\r\n\r\n");
  EXPECT_EQ(plain.body, "GET /p ");
  EXPECT_TRUE(absl::StrContains(plain.headers, "Connection: close"));
  const auto head = Send(absl::StrCat("HEAD /p HTTP/1.1\r\nHost: x\r\n", kClose, "\r\n"));
  EXPECT_EQ(head.body, "");
  EXPECT_TRUE(absl::StrContains(head.headers, "Content-Length: 8"));
}

TEST_F(HttpServerTest, AClientThatWaitsIsToldToGoOn) {
  Listen();
  const int socket = ConnectHttp(address_);
  const std::string begin = absl::StrCat("POST /p HTTP/1.1\r\nHost: x\r\n", kClose,
                                         "Expect: 100-continue\r\nContent-Length: 2\r\n\r\n");
  send(socket, begin.data(), begin.size(), MSG_NOSIGNAL);
  char told[64] = {};
  ASSERT_GT(recv(socket, told, sizeof(told) - 1, 0), 0);
  EXPECT_TRUE(absl::StartsWith(told, "HTTP/1.1 100 ")) << told;
  send(socket, "ok", 2, MSG_NOSIGNAL);
  EXPECT_TRUE(absl::StrContains(ReceiveAll(socket), "POST /p ok"));
}

TEST_F(HttpServerTest, SlowClientsAreCutAndDelayNoOthers) {
  HttpServer::Limits limits;
  limits.receive_limit = limits.idle_limit = milliseconds(300);
  Listen(limits);
  const int silent = ConnectHttp(address_), slow = ConnectHttp(address_);
  const std::string begin = "POST /p HTTP/1.1\r\nHost: x\r\nContent-Length: 3\r\n\r\nx";
  send(slow, begin.data(), begin.size(), MSG_NOSIGNAL);
  EXPECT_EQ(Send(Post("x", kClose)).status, 200);
  EXPECT_EQ(ReceiveAll(silent), "");
  ReceiveAll(slow);  // returns: the server closes
  EXPECT_EQ(asked_, 1);
}

TEST_F(HttpServerTest, AStreamEndsWithItsClient) {
  Listen();
  const int socket = ConnectHttp(address_);
  const std::string begin = "GET /stream HTTP/1.1\r\nHost: x\r\n\r\n";
  send(socket, begin.data(), begin.size(), MSG_NOSIGNAL);
  char bytes[300];
  std::size_t got = 0;
  while (got < sizeof(bytes)) {
    const ssize_t more = recv(socket, bytes + got, sizeof(bytes) - got, 0);
    ASSERT_GT(more, 0);
    got += static_cast<std::size_t>(more);
  }
  EXPECT_EQ(streams_ended_, 0);
  close(socket);
  EXPECT_TRUE(Eventually([&] { return streams_ended_ == 1; }));
  EXPECT_TRUE(Eventually([&] { return server_->counts().open == 0; }));
}

TEST_F(HttpServerTest, AClientThatDoesNotReadIsCut) {
  HttpServer::Limits limits;
  limits.send_limit = milliseconds(300);
  Listen(limits);
  const int socket = ConnectHttp(address_);
  const std::string begin = "GET /flood HTTP/1.1\r\nHost: x\r\n\r\n";
  send(socket, begin.data(), begin.size(), MSG_NOSIGNAL);
  EXPECT_TRUE(Eventually([&] { return streams_ended_ == 1; }));
  close(socket);
}

TEST_F(HttpServerTest, ConnectionsAboveTheLimitAreToldSo) {
  HttpServer::Limits limits;
  limits.most_connections = 6;  // half of them from one address
  Listen(limits);
  std::vector<int> held;
  for (int i = 0; i < 3; ++i) held.push_back(ConnectHttp(address_));
  ASSERT_TRUE(Eventually([&] { return server_->counts().open == 3; }));
  const auto refused = Send(Post("x"));
  EXPECT_EQ(refused.status, 503);
  EXPECT_TRUE(absl::StrContains(refused.headers, "Retry-After"));
  EXPECT_EQ(server_->counts().refused, 1u);
  for (const int socket : held) close(socket);
  EXPECT_TRUE(Eventually([&] { return server_->counts().open == 0; }));
  EXPECT_EQ(Send(Post("x", kClose)).status, 200);
}

TEST_F(HttpServerTest, EndsWhileClientsAreConnected) {
  Listen();
  const int silent = ConnectHttp(address_), stream = ConnectHttp(address_);
  const std::string begin = "GET /stream HTTP/1.1\r\nHost: x\r\n\r\n";
  send(stream, begin.data(), begin.size(), MSG_NOSIGNAL);
  ASSERT_TRUE(Eventually([&] { return asked_ == 1; }));
  server_ = nullptr;
  EXPECT_EQ(streams_ended_, 1);
  EXPECT_EQ(ReceiveAll(silent), "");
  ReceiveAll(stream);
}

TEST_F(HttpServerTest, RandomBytesDoNoHarm) {
  Listen();
  const auto seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("seed ", seed));
  std::mt19937 random(seed);
  const std::string good = Post("body", "A: b\r\n");
  for (int i = 0; i < 200; ++i) {
    std::string bytes = good;
    for (int k = static_cast<int>(random() % 6); k >= 0; --k) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    if (random() % 3 == 0) bytes.resize(random() % bytes.size());
    const int socket = ConnectHttp(address_);
    send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    shutdown(socket, SHUT_WR);
    ReceiveAll(socket);
  }
  EXPECT_EQ(Send(Post("x", kClose)).status, 200);
}

}  // namespace
}  // namespace dynmesh::server::http_server_test
