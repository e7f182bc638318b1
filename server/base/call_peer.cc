#include "server/base/call_peer.h"

#include <random>

#include "absl/strings/str_cat.h"

namespace dynmesh::server {

const std::string& HttpPeerKey() {
  static const std::string* const key = [] {
    std::random_device random;
    auto* const text = new std::string("dynmesh-http-peer-");
    for (int i = 0; i < 4; ++i) absl::StrAppend(text, absl::Hex(random(), absl::kZeroPad8));
    return text;
  }();
  return *key;
}

std::string PeerOf(const grpc::ServerContextBase& call) {
  const auto of_http = call.client_metadata().find(HttpPeerKey());
  if (of_http == call.client_metadata().end()) return call.peer();
  return {of_http->second.data(), of_http->second.size()};
}

}  // namespace dynmesh::server
