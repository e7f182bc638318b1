#include "server/metrics/failed_calls.h"

#include <chrono>
#include <utility>

#include "proto/codec/grpc_status.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"
#include "server/base/peer.h"

namespace dynmesh::server {
namespace {

constexpr std::chrono::seconds kBetweenLines{1};

LogLevel LevelOf(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::UNKNOWN:
    case grpc::StatusCode::INTERNAL:
    case grpc::StatusCode::DATA_LOSS:
      return LogLevel::kWarning;
    case grpc::StatusCode::UNAUTHENTICATED:
    case grpc::StatusCode::PERMISSION_DENIED:
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return LogLevel::kInfo;
    default:
      return LogLevel::kDebug;
  }
}

}  // namespace

FailedCalls::FailedCalls(MetricRegistry& registry)
    : by_reason_(registry.AddCounters("dynmesh_failed_calls_total",
                                      "Calls that ended with an error, by its reason.")) {}

void FailedCalls::Tell(const Call& call, const grpc::Status& status) {
  const auto error = codec::GetServiceError(codec::FromGrpcStatus(status));
  const std::string reason = error.has_value() ? error->reason : "";
  if (!reason.empty()) by_reason_.With({{"reason", reason}}).Add();
  const LogLevel level = LevelOf(status.error_code());
  if (!LogEnabled(level)) return;
  std::uint64_t left_out = 0;
  if (level != LogLevel::kDebug && !LogEnabled(LogLevel::kDebug)) {
    const auto line = TakeLine(reason.empty() ? std::string(call.code) : reason);
    if (!line.has_value()) return;
    left_out = *line;
  }
  // Only errors caused by the client name it.
  std::string client;
  if (error.has_value() && error->metadata.contains("client")) {
    client = error->metadata.at("client");
  } else if (!call.peer.empty()) {
    client = ClientAt(AddressOf(call.peer));
  }
  std::string holders;
  if (error.has_value() && error->metadata.contains("limit") && holders_ != nullptr) {
    holders = holders_(error->metadata.at("limit"));
  }
  Log(level, level == LogLevel::kInfo ? "call_refused" : "call_failed",
      {{"call", call.id},
       {"method", call.method},
       {"code", call.code},
       {"reason", reason},
       {"client", client},
       {"peer", call.peer},
       {"left_out", left_out},
       {"holders", holders},
       {"message", status.error_message()}});
}

std::optional<std::uint64_t> FailedCalls::TakeLine(const std::string& reason) {
  const MetricsClock::time_point now = MetricsClock::now();
  const MutexLock lock(mutex_);
  const auto [it, is_first] = told_.try_emplace(reason, Told{now, 0});
  if (!is_first && now - it->second.last < kBetweenLines) {
    ++it->second.left_out;
    return std::nullopt;
  }
  it->second.last = now;
  return std::exchange(it->second.left_out, 0);
}

}  // namespace dynmesh::server
