// A server with fake meshes and metrics.
#ifndef DYNMESH_TESTS_SERVER_METRICS_OBSERVE_FIXTURE_H_
#define DYNMESH_TESTS_SERVER_METRICS_OBSERVE_FIXTURE_H_

#include <gtest/gtest.h>

#include <string>

#include "tests/server/http/http_get.h"
#include "tests/server/metrics/metrics_parser.h"
#include "tests/server/server_fixture.h"

namespace dynmesh::server {

// The address that a line of the log names.
inline std::string AddressIn(const std::string& log, const std::string& event) {
  const std::string mark = "event=" + event + " address=";
  const std::size_t at = log.find(mark);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + mark.size();
  return log.substr(begin, log.find_first_of(" \n", begin) - begin);
}
inline std::string MetricsAddress(const std::string& log) {
  return AddressIn(log, "metrics_listen");
}

class ObserveTest : public ServerFixture {
 protected:
  // As StartWithMesh, with metrics.
  void StartObserved() {
    ServerConfig config;
    config.metrics = "127.0.0.1:0";
    ASSERT_TRUE(SetLogLevel("info").ok());
    ::testing::internal::CaptureStderr();
    StartWithMesh(config);
    metrics_ = MetricsAddress(::testing::internal::GetCapturedStderr());
    ASSERT_TRUE(SetLogLevel("error").ok());
    ASSERT_NE(metrics_, "");
  }
  ParsedMetrics Scrape() const {
    const HttpAnswer answer = HttpGet(metrics_, "/metrics");
    EXPECT_EQ(answer.status, 200);
    ParsedMetrics parsed(answer.body);
    EXPECT_EQ(parsed.error(), "");
    return parsed;
  }
  static ParsedMetrics::Labels Of(const char* type, const char* method,
                                  const char* code = nullptr) {
    ParsedMetrics::Labels labels = {
        {"grpc_type", type}, {"grpc_service", "dynmesh.v1.MeshService"}, {"grpc_method", method}};
    if (code != nullptr) labels["grpc_code"] = code;
    return labels;
  }

  std::string metrics_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_METRICS_OBSERVE_FIXTURE_H_
