// Checks of every call before it works: drain, limits, names. Does not depend on gRPC. Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_ADMISSION_H_
#define DYNMESH_SERVER_CALLS_ADMISSION_H_

#include <atomic>
#include <cstddef>
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
        watchers(c.max_watchers),
        edit_streams(c.max_edit_streams),
        snapshot_streams(c.max_snapshot_streams),
        builds(c.max_builds),
        client_streams(c.max_streams_per_client),
        pending_edits(c.max_pending_edits) {}

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
  Quota watchers;
  Quota edit_streams;
  Quota snapshot_streams;
  Quota builds;
  ClientQuotas client_streams;
  Quota pending_edits;
  OpenSends sends;
  SharedEvents events;  // of all watches
};

// UNAVAILABLE (DRAINING), with the time after which to retry with another server.
absl::Status DrainingError();

// UNAVAILABLE (RECOVERING), with the time after which to retry.
absl::Status RecoveringError();

// A ticket, or DrainingError.
absl::StatusOr<WorkGate::Ticket> EnterWork(ServiceContext& context);

// RESOURCE_EXHAUSTED (STREAM_LIMIT). `what` names the streams of `quota`: "watches", ...
absl::StatusOr<Lease> TakeStream(Quota& quota, absl::string_view what);

// A stream's leases: of the quota of its kind, and of its client's.
struct StreamPlace {
  Lease of_kind;
  Lease of_client;
};
// As above; RESOURCE_EXHAUSTED (CLIENT_STREAM_LIMIT) if the client is at its limit.
absl::StatusOr<StreamPlace> TakeStream(ServiceContext& context, Quota& quota,
                                       absl::string_view what, const Pass& pass);

// Reserves edits of weight `count` for a batch of weight `before`: INVALID_ARGUMENT
// (BATCH_TOO_LARGE) or RESOURCE_EXHAUSTED (PENDING_LIMIT).
absl::StatusOr<Lease> TakeEdits(ServiceContext& context, std::size_t before, std::size_t count);

// The same, part by part: the reservation of a batch while it is received and waits.
class HeldEdits {
 public:
  absl::Status Take(ServiceContext& context, std::size_t count);
  void Release() { leases_.clear(); }

 private:
  std::size_t weight_ = 0;
  std::vector<Lease> leases_;
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
                                      std::function<void()> cancel);

absl::Status CheckRequestId(absl::string_view request_id);

absl::Status BadRequest(absl::string_view field, absl::string_view message);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_ADMISSION_H_
