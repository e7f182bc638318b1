#include "server/meshes/mesh_strand.h"

#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::server {
namespace {

constexpr absl::Duration kRetryAfter = absl::Milliseconds(100);

absl::Status QueueFull(std::size_t waiting) {
  codec::ServiceError error;
  error.reason = codec::reason::kQueueFull;
  error.retry_after = kRetryAfter;
  return codec::MakeServiceError(
      absl::StatusCode::kResourceExhausted,
      absl::StrCat(waiting, " requests wait for this mesh already: try again later"), error);
}

absl::Status ShareFull(absl::string_view client, std::uint64_t share, std::size_t limit) {
  codec::ServiceError error;
  error.reason = codec::reason::kQueueFull;
  error.metadata["client"] = std::string(client);
  error.retry_after = kRetryAfter;
  return codec::MakeServiceError(
      absl::StatusCode::kResourceExhausted,
      absl::StrCat("this client has its share of the requests that may wait for this mesh, ", share,
                   " of ", limit, ": wait for the answers to those it has sent"),
      error);
}

}  // namespace

absl::Status CancelledInTime() {
  return absl::CancelledError("the call was cancelled before its turn: nothing changed");
}

MeshStrand::MeshStrand(WorkerPool* pool, const SerialQueue::Turn& turn, std::size_t max_waiting)
    : max_waiting_(max_waiting),
      clients_(max_waiting - max_waiting / 2),
      queue_(SerialQueue::Create(pool, turn)) {}

absl::StatusOr<Share> MeshStrand::Take(absl::string_view client) {
  if (client.empty()) return Share();
  Share share = clients_.Take(client);
  if (!share) return ShareFull(client, clients_.limit(), max_waiting_);
  return share;
}

absl::Status MeshStrand::TryPost(Task task, TaskOwner owner) {
  return queue_->TryPost(std::move(task), max_waiting_, std::move(owner)) ? absl::OkStatus()
                                                                          : QueueFull(max_waiting_);
}

}  // namespace dynmesh::server
