// The HTTP side of metrics: its content, and its robustness against hostile requests.
#include "server/http/metrics_http.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "server/http/http_listener.h"
#include "tests/server/http/http_get.h"

namespace dynmesh::server::metrics_http_test {
namespace {

class MetricsHttpTest : public ::testing::Test {
 protected:
  void Listen(const std::string& address = "127.0.0.1:0") {
    auto http = MetricsHttp::Listen(address, {[this] {
                                                ++scrapes_;
                                                return figures_;
                                              },
                                              [this] {
                                                const std::lock_guard lock(mutex_);
                                                return not_ready_;
                                              },
                                              [this] {
                                                const std::lock_guard lock(mutex_);
                                                return amiss_;
                                              }});
    ASSERT_TRUE(http.ok()) << http.status();
    http_ = *std::move(http);
  }
  HttpAnswer Get(const std::string& path) const { return HttpGet(http_->address(), path); }
  HttpAnswer Send(const std::string& bytes) const {
    return ParseHttp(SendHttp(http_->address(), bytes));
  }

  // Silent clients.
  std::vector<int> Connect(std::size_t count) const {
    std::vector<int> sockets;
    for (std::size_t i = 0; i < count; ++i) sockets.push_back(ConnectHttp(http_->address()));
    return sockets;
  }
  // The server has not closed the connection, nor sent anything.
  static bool IsOpen(int socket) {
    char byte = 0;
    return recv(socket, &byte, 1, MSG_DONTWAIT) < 0 && errno == EAGAIN;
  }

  std::string figures_ = "figures 1\n";  // set before requests
  std::atomic<int> scrapes_{0};
  std::mutex mutex_;
  std::string not_ready_;
  std::string amiss_;
  std::unique_ptr<MetricsHttp> http_;
};

TEST_F(MetricsHttpTest, ThreePathsAreServedAndNothingElse) {
  Listen();
  const HttpAnswer metrics = Get("/metrics");
  EXPECT_EQ(metrics.status, 200);
  EXPECT_EQ(metrics.body, "figures 1\n");
  EXPECT_NE(metrics.headers.find("Content-Type: text/plain; version=0.0.4"), std::string::npos)
      << metrics.headers;
  EXPECT_EQ(Get("/metrics?x=1").status, 200);
  EXPECT_EQ(Get("/healthz").status, 200);
  EXPECT_EQ(Get("/readyz").status, 200);
  for (const char* path : {"/", "/metrics/", "/metricsx", "/x", "/../etc/passwd", "/healthz/.."}) {
    EXPECT_EQ(Get(path).status, 404) << path;
  }
  const HttpAnswer head = Send("HEAD /metrics HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.body, "");
}

TEST_F(MetricsHttpTest, ReadyzSaysWhyNot) {
  Listen();
  {
    const std::lock_guard lock(mutex_);
    not_ready_ = "recovering";
  }
  const HttpAnswer answer = Get("/readyz");
  EXPECT_EQ(answer.status, 503);
  EXPECT_EQ(answer.body, "recovering\n");
  EXPECT_EQ(Get("/healthz").status, 200);
}

TEST_F(MetricsHttpTest, ReadyzSaysWhatIsAmissThoughItIsReady) {
  Listen();
  {
    const std::lock_guard lock(mutex_);
    amiss_ = "edits are refused";
  }
  EXPECT_EQ(Get("/readyz").status, 200);
  EXPECT_EQ(Get("/readyz").body, "ready; edits are refused\n");
  {
    const std::lock_guard lock(mutex_);
    not_ready_ = "draining";
  }
  EXPECT_EQ(Get("/readyz").status, 503);
  EXPECT_EQ(Get("/readyz").body, "draining\n");
}

TEST_F(MetricsHttpTest, OtherMethodsAreRefusedWithoutReadingTheirBodies) {
  Listen();
  for (const char* method : {"POST", "PUT", "DELETE", "PATCH", "OPTIONS"}) {
    EXPECT_EQ(Send(std::string(method) +
                   " /metrics HTTP/1.1\r\nHost: x\r\nContent-Length: 1000000000\r\n\r\n")
                  .status,
              405)
        << method;
  }
  EXPECT_EQ(scrapes_, 0);
}

TEST_F(MetricsHttpTest, WhatIsNoHttpEndsTheConnectionAndNotTheServer) {
  Listen();
  std::vector<std::string> malformed = {
      "\r\n\r\n",
      "GET\r\n\r\n",
      "GET /metrics\r\n\r\n",
      "GET /metrics HTTP/9.9\r\n\r\n",
      "BREW /metrics HTTP/1.1\r\n\r\n",
      "GET metrics HTTP/1.1\r\n\r\n",
      std::string("GET /\0 HTTP/1.1\r\n\r\n", 19),
      "GET /metrics HTTP/1.1\r\nno colon\r\n\r\n",
      "GET /metrics HTTP/1.1\r\nRange: bytes=9-1\r\n\r\n",
      "GET /metrics HTTP/1.1\r\nContent-Length: -1\r\n\r\n",
      "GET /%zz%00 HTTP/1.1\r\n\r\n",
      "GET /" + std::string(9'000, 'a') + " HTTP/1.1\r\n\r\n",
      "GET /metrics HTTP/1.1\r\nA: " + std::string(9'000, 'a') + "\r\n\r\n"};
  std::mt19937_64 random(20261122);
  for (int i = 0; i < 50; ++i) {
    std::string noise(random() % 300, '\0');
    for (char& c : noise) c = static_cast<char>(random());
    malformed.push_back("GET /metrics HTTP/1.1\r\n" + noise + "\r\n\r\n");
    malformed.push_back(noise + "\r\n\r\n");
  }
  for (const std::string& bytes : malformed) {
    // The client ends its request; the server would wait for more otherwise.
    const int socket = ConnectHttp(http_->address());
    ASSERT_GE(socket, 0);
    (void)!send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    shutdown(socket, SHUT_WR);
    EXPECT_NE(ParseHttp(ReceiveAll(socket)).status, 200) << bytes;
  }
  EXPECT_EQ(Get("/metrics").status, 200);
}

TEST_F(MetricsHttpTest, WhatFollowsTheHeadIsNotLookedAt) {
  Listen();
  const std::string head = " /metrics HTTP/1.1\r\nHost: x\r\nContent-Length: 5\r\n\r\n";
  EXPECT_EQ(Send("POST" + head + "hello").status, 405);
  EXPECT_EQ(Send("GET" + head + "hello").status, 200);
  EXPECT_EQ(Send("GET" + head + "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n").status, 200);
}

TEST_F(MetricsHttpTest, AHeadHasItsEnd) {
  Listen();
  for (const std::string bytes :
       {"GET /metrics HTTP/1.1\r\nHost: x", "GET /metrics HTTP/1.1\r\nHost: x\r\n",
        "GET /metrics HTTP/1.0\n\n"}) {
    const int socket = ConnectHttp(http_->address());
    ASSERT_GE(socket, 0);
    (void)!send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    shutdown(socket, SHUT_WR);
    EXPECT_EQ(ParseHttp(ReceiveAll(socket)).status, 400) << bytes;
  }
}

TEST_F(MetricsHttpTest, ALineWithoutEndIsCutOff) {
  Listen();
  const std::string line = "GET /" + std::string(1 << 20, 'a');
  const auto start = std::chrono::steady_clock::now();
  SendHttp(http_->address(), line);  // comes back though the request has no end
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(4));
  EXPECT_EQ(Get("/metrics").status, 200);
}

TEST_F(MetricsHttpTest, ClientsThatSayNothingAreGivenUp) {
  Listen();
  std::vector<int> silent;
  for (int i = 0; i < 2; ++i) silent.push_back(ConnectHttp(http_->address()));
  std::atomic<bool> done{false};
  std::thread drip([&] {  // a byte now and then
    while (!done) {
      (void)!send(silent[0], "x", 1, MSG_NOSIGNAL);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  });
  EXPECT_EQ(Get("/metrics").status, 200);  // waits for its turn, no more
  done = true;
  drip.join();
  for (const int socket : silent) close(socket);
}

// Requests that waited for silent clients would be answered when all of these are closed.
TEST_F(MetricsHttpTest, HealthIsAnsweredWhileManyConnectionsSayNothing) {
  Listen();
  bool is_open = false;
  while (!is_open) {  // a machine that is slow enough closes them before
    const std::vector<int> silent = Connect(64);
    EXPECT_EQ(Get("/healthz").status, 200);
    EXPECT_EQ(Get("/readyz").status, 200);
    EXPECT_EQ(Get("/metrics").status, 200);
    is_open = IsOpen(silent.back());
    for (const int socket : silent) close(socket);
  }
}

TEST_F(MetricsHttpTest, HealthIsAnsweredWhileManyConnectionsSendAByteNowAndThen) {
  Listen();
  bool is_open = false;
  while (!is_open) {
    const std::vector<int> slow = Connect(64);
    std::atomic<bool> done{false};
    std::thread drip([&] {
      for (std::size_t i = 0; !done; ++i) {
        (void)!send(slow[i % slow.size()], "G", 1, MSG_NOSIGNAL);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
    for (int i = 0; i < 20; ++i) EXPECT_EQ(Get("/healthz").status, 200);
    is_open = IsOpen(slow.back());
    done = true;
    drip.join();
    for (const int socket : slow) close(socket);
  }
}

TEST_F(MetricsHttpTest, ANewConnectionTakesThePlaceOfTheOldestSilentOne) {
  Listen();
  constexpr std::size_t kMore = 30;
  bool is_open = false;
  while (!is_open) {
    const std::vector<int> silent = Connect(HttpListener::kMostConnections + kMore);
    EXPECT_EQ(Get("/healthz").status, 200);
    for (std::size_t i = 0; i < kMore; ++i) {
      char byte = 0;
      EXPECT_LE(recv(silent[i], &byte, 1, 0), 0) << i;
    }
    is_open = IsOpen(silent.back());
    for (const int socket : silent) close(socket);
  }
}

TEST_F(MetricsHttpTest, HealthIsAnsweredWhileAnswersAreNotRead) {
  figures_.assign(32 << 20, '1');  // more than the kernel takes for a client
  Listen();
  const std::string request = "GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n";
  bool is_open = false;
  while (!is_open) {
    const std::vector<int> deaf = Connect(8);
    for (const int socket : deaf) {
      ASSERT_EQ(send(socket, request.data(), request.size(), MSG_NOSIGNAL),
                static_cast<ssize_t>(request.size()));
    }
    char byte = 0;
    // The answers are there.
    for (const int socket : deaf) ASSERT_EQ(recv(socket, &byte, 1, MSG_PEEK), 1);
    EXPECT_EQ(Get("/healthz").status, 200);
    std::vector<char> all(64 << 20);
    // A connection that was given up brings less.
    std::size_t got = 0;
    for (ssize_t n; (n = recv(deaf.back(), all.data(), all.size(), 0)) > 0;) {
      got += static_cast<std::size_t>(n);
    }
    is_open = got > figures_.size();
    for (const int socket : deaf) close(socket);
  }
}

// As some scrapers do: the answer's header tells them that the connection ends.
TEST_F(MetricsHttpTest, AScrapeThatAsksForKeepAliveIsAnsweredAndClosed) {
  Listen();
  for (int i = 0; i < 3; ++i) {
    const HttpAnswer answer =
        Send("GET /metrics HTTP/1.1\r\nHost: x\r\nConnection: keep-alive\r\n\r\n");
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body, figures_);
    EXPECT_NE(answer.headers.find("Connection: close"), std::string::npos) << answer.headers;
  }
}

TEST_F(MetricsHttpTest, ItEndsAtOnceThoughConnectionsAreOpen) {
  Listen();
  std::vector<int> silent;
  for (int i = 0; i < 12; ++i) silent.push_back(ConnectHttp(http_->address()));
  const auto start = std::chrono::steady_clock::now();
  http_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(3));
  for (const int socket : silent) close(socket);
}

TEST_F(MetricsHttpTest, ManyScrapesAtTheSameTimeAreAllAnswered) {
  Listen();
  std::atomic<int> good{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) good += Get("/metrics").status == 200 ? 1 : 0;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good, 160);
  EXPECT_EQ(scrapes_, 160);
}

TEST_F(MetricsHttpTest, AddressesAreLoopbackUnlessTheySayOtherwise) {
  for (const char* address : {"0", ":0"}) {
    Listen(address);
    EXPECT_EQ(http_->address().rfind("127.0.0.1:", 0), 0u) << http_->address();
    EXPECT_EQ(Get("/healthz").status, 200);
  }
  for (const char* bad : {"", "localhost", "127.0.0.1:x", "127.0.0.1:70000", "127.0.0.1:-1"}) {
    EXPECT_EQ(MetricsHttp::Listen(bad, {}).status().code(), absl::StatusCode::kInvalidArgument)
        << bad;
  }
  // A port that is taken is not shared.
  EXPECT_EQ(MetricsHttp::Listen(http_->address(), {}).status().code(),
            absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace dynmesh::server::metrics_http_test
