#include "server/calls/forwarder.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/metadata.h"
#include "proto/codec/status_codec.h"
#include "server/base/call_id.h"
#include "server/calls/asking.h"

namespace dynmesh::server {
namespace {

// The other server answers NOT_OWNER rather than to hand the call on again, and opens a free mesh.
constexpr int kHandedOn = 2;

// A server that is stopped, or cut off from this one, is noticed when a ping gets no answer: after
// the two times together, as its lease ends by default. The client's next call is sent to the next
// owner. A server that starts again is soon connected to.
grpc::ChannelArguments Arguments() {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 1'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 2'500);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);  // any number
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 2'500);  // limits an attempt to connect
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1'000);
  return arguments;
}

}  // namespace

v1::MeshService::Stub* Forwarder::ServerOf(const absl::Status& status,
                                           const grpc::CallbackServerContext& call) {
  if (credentials_ == nullptr || !absl::IsUnavailable(status)) return nullptr;
  if (AskingOf(call).redirects != Asking::kFollowsNone) return nullptr;
  const auto error = codec::GetServiceError(status);
  if (!error.has_value() || error->reason != codec::reason::kNotOwner) return nullptr;
  const auto owner = error->metadata.find("owner");
  if (owner == error->metadata.end() || owner->second.empty()) return nullptr;
  const MutexLock lock(mutex_);
  auto& server = servers_[owner->second];
  if (server == nullptr) {
    server = v1::MeshService::NewStub(
        grpc::CreateCustomChannel(owner->second, credentials_, Arguments()));
  }
  return server.get();
}

std::shared_ptr<grpc::ClientContext> Forwarder::ContextOf(const grpc::CallbackServerContext& call) {
  std::shared_ptr<grpc::ClientContext> context =
      grpc::ClientContext::FromCallbackServerContext(call);
  const auto [begin, end] = call.client_metadata().equal_range("authorization");
  for (auto it = begin; it != end; ++it) {
    context->AddMetadata("authorization", std::string(it->second.data(), it->second.size()));
  }
  context->AddMetadata(kCallIdKey, CallIdOf(call));
  context->AddMetadata(codec::kRedirectsKey, absl::StrCat(kHandedOn));
  return context;
}

grpc::Status Forwarder::AsGrpc(const absl::Status& status) { return codec::ToGrpcStatus(status); }

}  // namespace dynmesh::server
