// What a call tells about itself that asks for a mesh which another server may have. Pure.
#ifndef DYNMESH_SERVER_CALLS_ASKING_H_
#define DYNMESH_SERVER_CALLS_ASKING_H_

#include <grpcpp/server_context.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "absl/strings/numbers.h"
#include "absl/strings/string_view.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "proto/codec/metadata.h"
#include "server/meshes/mesh_opener.h"

namespace dynmesh::server {

// Thread-safe.
inline Asking AskingOf(const grpc::CallbackServerContext& call) {
  Asking asking;
  const auto left = call.deadline() - std::chrono::system_clock::now();
  if (left < std::chrono::hours(24)) asking.deadline = std::chrono::steady_clock::now() + left;
  const auto it = call.client_metadata().find(codec::kRedirectsKey);
  int redirects = 0;
  if (it != call.client_metadata().end() &&
      absl::SimpleAtoi(absl::string_view(it->second.data(), it->second.size()), &redirects) &&
      redirects >= 0) {
    asking.redirects = redirects;
  }
  return asking;
}

// Of a read that need not be of the present state: the revision that it needs at least. `other`: a
// revision that it is about, too.
template <class Request>
std::optional<std::uint64_t> MinRevisionOf(const Request& request, std::uint64_t other = 0) {
  if (!request.has_min_revision()) return std::nullopt;
  return std::max(request.min_revision(), other);
}
inline std::optional<std::uint64_t> MinRevisionOf(const v1::WatchRequest& request) {
  return MinRevisionOf<v1::WatchRequest>(request, request.start_revision());
}
inline std::optional<std::uint64_t> MinRevisionOf(const v1::GetFeaturesRequest& request) {
  return MinRevisionOf<v1::GetFeaturesRequest>(request, request.revision());
}

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_ASKING_H_
