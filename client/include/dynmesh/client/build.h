// A build: a mesh made by a server that does not keep it. For MeshClient::BuildMesh.
//
//   dynmesh::client::BuildParams params;
//   params.max_time = absl::Minutes(1);
//   auto mesh = client->BuildMesh(features, options, params);
#ifndef DYNMESH_CLIENT_BUILD_H_
#define DYNMESH_CLIENT_BUILD_H_

#include <atomic>
#include <functional>

#include "absl/time/time.h"
#include "dynmesh/client/load.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::client {

// Parameters of a build. Only `engine` and `only_inside` change the resulting mesh.
struct BuildParams {
  BuildEngine engine = BuildEngine::kDynamic;  // the mesher
  bool only_inside = false;                    // as in BuildOptions
  // The longest time that the server may compute, without sending and receiving; 0 or more. 0: the
  // server's limit.
  absl::Duration max_time = absl::ZeroDuration();
  // Called about twice a second from another thread, with the stages kSend, kValidate, kRefine and
  // kDiff, never after BuildMesh has returned. May be null.
  std::function<void(const LoadProgress&)> progress = nullptr;
  // Polled between messages in both directions, so about twice a second. Once true, the build ends:
  // CANCELLED. May be null.
  const std::atomic<bool>* cancelled = nullptr;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_BUILD_H_
