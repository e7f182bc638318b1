// What a call tells about itself that asks for a mesh which another server may have.
#ifndef DYNMESH_SERVER_CALLS_ASKING_H_
#define DYNMESH_SERVER_CALLS_ASKING_H_

#include <grpcpp/server_context.h>

#include <chrono>

#include "absl/strings/numbers.h"
#include "absl/strings/string_view.h"
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

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_ASKING_H_
