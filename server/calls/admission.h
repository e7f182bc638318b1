// Checks of every call before it works: drain, limits, names. Does not depend on gRPC. Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_ADMISSION_H_
#define DYNMESH_SERVER_CALLS_ADMISSION_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/access/access.h"
#include "server/access/client_quotas.h"
#include "server/access/quota.h"
#include "server/access/shared_limit.h"
#include "server/base/work_gate.h"
#include "server/base/worker_pool.h"
#include "server/calls/open_sends.h"
#include "server/calls/shared_events.h"
#include "server/config/config.h"
#include "server/meshes/build_pool.h"
#include "server/meshes/mesh_registry.h"

namespace dynmesh::server {

// Shared by the calls of a service.
struct ServiceContext {
  static constexpr std::uint64_t kMostPasts = 16;  // that wait or are made

  ServiceContext(const ServerConfig& c, MeshRegistry* r, WorkerPool* w, WorkerPool* rd,
                 WorkerPool* a, ServerMetrics* m, Access* ac, absl::Time now,
                 BuildPool* b = nullptr)
      : config(c),
        registry(r),
        writers(w),
        readers(rd),
        answers(a),
        metrics(m),
        access(ac),
        build_pool(b),
        start_time(now),
        watchers("watches", c.max_watchers),
        edit_streams("edit streams", c.max_edit_streams),
        snapshot_streams("concurrent snapshots", c.max_snapshot_streams),
        builds("concurrent builds", c.max_builds),
        pasts("watches that begin in the past", kMostPasts),
        // A batch as large as may be is not refused for good.
        pending_edits("edits that wait", c.max_pending_edits, c.max_batch_edits),
        client_streams(c.max_streams_per_client) {}

  const ServerConfig config;
  MeshRegistry* const registry;
  WorkerPool* const writers;
  WorkerPool* const readers;
  WorkerPool* const answers;  // starts writes in place of a mesh's strand; never blocks
  ServerMetrics* const metrics;
  Access* const access;
  BuildPool* const build_pool;  // null: there are no builds
  const absl::Time start_time;
  WorkGate gate;
  std::atomic<bool> recovering{false};  // meshes are being recovered: no call is answered yet
  SharedLimit watchers;
  SharedLimit edit_streams;
  SharedLimit snapshot_streams;
  SharedLimit builds;
  SharedLimit pasts;
  SharedLimit pending_edits;
  ClientQuotas client_streams;
  OpenSends sends;
  SharedEvents events;  // of all watches
};

// UNAVAILABLE (DRAINING), with the time after which to retry with another server.
absl::Status DrainingError();

// UNAVAILABLE (RECOVERING), with the time after which to retry.
absl::Status RecoveringError();

// A ticket, or DrainingError.
absl::StatusOr<WorkGate::Ticket> EnterWork(ServiceContext& context);

// The clients that have most of a limit, by its name in an error's metadata; "" if there is none.
std::string HoldersOf(const ServiceContext& context, absl::string_view limit);

// The client, if it shares the server with others; "" if there is one client only.
std::string SharingClient(const ServiceContext& context, const Pass& pass);

// RESOURCE_EXHAUSTED: STREAM_LIMIT, or CLIENT_STREAM_LIMIT if the client has its share of `limit`.
// Both have the limit's name in the metadata as `limit`.
absl::StatusOr<SharedLimit::Place> TakePlace(ServiceContext& context, SharedLimit& limit,
                                             const Pass& pass);

// A stream's place among those of its kind, and among its client's streams.
struct StreamPlace {
  SharedLimit::Place of_kind;
  Share of_client;
};
// As above; CLIENT_STREAM_LIMIT also if the client is at its limit of streams of all kinds.
absl::StatusOr<StreamPlace> TakeStream(ServiceContext& context, SharedLimit& limit,
                                       const Pass& pass);

// Reserves edits of weight `count` for a batch of weight `before`: INVALID_ARGUMENT
// (BATCH_TOO_LARGE) or RESOURCE_EXHAUSTED (PENDING_LIMIT).
absl::StatusOr<SharedLimit::Place> TakeEdits(ServiceContext& context, const Pass& pass,
                                             std::size_t before, std::size_t count);

// The same, part by part: the reservation of a batch while it is received and waits.
class EditShares {
 public:
  absl::Status Take(ServiceContext& context, const Pass& pass, std::size_t count);
  void Release() { places_.clear(); }

 private:
  std::size_t weight_ = 0;
  std::vector<SharedLimit::Place> places_;
};

// `refused`, the error of a batch; or NOT_OWNER if it was judged by a state of the mesh that may
// not be the present one.
absl::Status CheckRefusal(const MeshRegistry& meshes, const MeshHost& host, absl::Status refused);

// The mesh of an edit stream, the stream's right to edit it, and its place among the edit streams.
struct EditTarget {
  MeshRegistry::HostPtr host;
  Access::Stream allowed;
  StreamPlace place;
};
// `host` as the registry opened it, for a caller with the right; null: the call ended before it was
// opened, which is an error here. `cancel` is called when the right is lost.
absl::StatusOr<EditTarget> OpenToEdit(ServiceContext& context, const Pass& pass,
                                      absl::StatusOr<MeshRegistry::HostPtr> host,
                                      Access::Cancel cancel);

absl::Status CheckRequestId(absl::string_view request_id);

absl::Status BadRequest(absl::string_view field, absl::string_view message);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_ADMISSION_H_
