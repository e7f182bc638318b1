// Shared by the parts of the client library: names, statuses, how its parts begin. Includes gRPC,
// which no public header may do.
#ifndef DYNMESH_CLIENT_CHANNEL_INTERNAL_H_
#define DYNMESH_CLIENT_CHANNEL_INTERNAL_H_

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "client/stub_internal.h"
#include "dynmesh/client/build.h"
#include "dynmesh/client/diff_stream.h"
#include "dynmesh/client/edit_session.h"
#include "dynmesh/client/load.h"
#include "dynmesh/client/watch_session.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::client {

// "plate" or "meshes/plate" as "meshes/plate". Checked by the server.
inline std::string FullName(const std::string& mesh) {
  return mesh.rfind("meshes/", 0) == 0 ? mesh : "meshes/" + mesh;
}

inline absl::Status CheckDimension(int dimension) {
  if (dimension == 2 || dimension == 3) return absl::OkStatus();
  return absl::InvalidArgumentError("dimension is not 2 or 3");
}

// Of a mesh to be made. The server's limit takes the place of the default max_vertices.
inline void EncodeNewOptions(const MeshOptions& options, v1::MeshOptions* out) {
  codec::EncodeOptions(options, out);
  if (options.limits.max_vertices == Limits().max_vertices) out->clear_max_vertices();
}

// A wait on a condition variable must end at a time that its clock can tell.
inline std::chrono::nanoseconds Bounded(absl::Duration limit) {
  return absl::ToChronoNanoseconds(std::min(limit, absl::Hours(24 * 365)));
}

// True if a watch that ended with `status` is to be reopened: the server is unavailable, restarts
// or lacks resources.
inline bool IsPassing(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:  // a watch does not end by itself
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kCancelled:  // by the server
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kResourceExhausted:
    case absl::StatusCode::kDeadlineExceeded:
      return true;
    default:
      return false;
  }
}

// Size limit of the features and ids of one message.
inline constexpr std::size_t kMessageBytes = 1 << 20;
inline constexpr std::size_t kFeatureBytes = 96;  // upper bound, without rings
inline constexpr std::size_t kIdsPerMessage = kMessageBytes / kFeatureBytes;

// An upper bound.
inline std::size_t WireBytes(const Feature& feature) {
  std::size_t bytes = kFeatureBytes;
  for (const std::vector<FeatureId>& ring : feature.rings) bytes += 10 * ring.size() + 8;
  if (feature.label) bytes += 24 + feature.label->name.size();
  return bytes;
}
inline std::size_t WireBytes(const Edit& edit) { return WireBytes(edit.feature); }

// The end of the edits or features from `begin` on that fit into a message; at least one does.
template <typename Item>
std::size_t PartEnd(std::span<const Item> items, std::size_t begin) {
  std::size_t bytes = 0;
  std::size_t end = begin;
  while (end < items.size()) {
    bytes += WireBytes(items[end]);
    if (bytes > kMessageBytes && end > begin) break;
    ++end;
  }
  return end;
}

std::unique_ptr<EditSession> StartEditSession(std::shared_ptr<Stub> stub, const std::string& mesh,
                                              bool stop_on_error, absl::Duration timeout);

std::unique_ptr<WatchSession> StartWatchSession(std::shared_ptr<Stub> stub, const std::string& mesh,
                                                const WatchOptions& options,
                                                WatchListener* listener);

std::unique_ptr<DiffStream> StartDiffStream(std::shared_ptr<Stub> stub, const std::string& mesh,
                                            const DiffStreamOptions& options);

absl::StatusOr<LoadResult> RunLoad(Stub& stub, const std::string& mesh, const FeatureSource& source,
                                   const LoadParams& params, absl::Duration timeout);

absl::StatusOr<Mesh> RunBuild(Stub& stub, std::span<const Feature> features,
                              const MeshOptions& options, const BuildParams& params,
                              absl::Duration timeout);

// Joins the fragments of a diff; done after a fragment without `more`.
struct ResultAssembler {
  codec::DiffAssembler assembler;
  // Nothing while fragments are missing.
  absl::StatusOr<std::optional<EditResult>> Add(const v1::MeshDiff& fragment) {
    auto diff = assembler.Add(fragment);
    if (!diff.ok()) return diff.status();
    if (!diff->has_value()) return std::optional<EditResult>();
    return std::optional<EditResult>(
        EditResult{**std::move(diff), fragment.replayed(), fragment.columns_omitted()});
  }
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_CHANNEL_INTERNAL_H_
