// What a server is told: where to listen, and limits with safe defaults. Plain data.
#ifndef DYNMESH_SERVER_CONFIG_CONFIG_H_
#define DYNMESH_SERVER_CONFIG_CONFIG_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/access/tls.h"
#include "server/base/process.h"

namespace dynmesh::server {

struct ServerConfig {
  // host:port; loopback unless told otherwise. Port 0 takes any free one.
  std::string listen = "127.0.0.1:7878";
  TlsFiles tls;
  // Elsewhere than on loopback without TLS, which is refused otherwise.
  bool insecure_listen = false;
  // Who may do what (tokens.h); empty: whoever can connect may do everything.
  std::string tokens_file;

  // host:port of metrics and health over HTTP (metrics_http.h); empty: none.
  std::string metrics;

  // Threads that apply edits (meshes run in parallel, one mesh never) and threads that
  // serve readers. 0: one for each core, at least 2.
  int writer_threads = 0;
  int reader_threads = 0;

  std::uint64_t max_meshes = 1'000;
  // Of one mesh; 0: as many as half of max_memory_bytes holds (memory_guard.h).
  std::uint64_t max_vertices = 0;
  std::uint64_t max_features = 50'000'000;  // of one mesh
  // Edits in one batch: about 140 bytes each until applied; 8 points of polygons count as one, a
  // ring as 3 more.
  std::uint64_t max_batch_edits = 2'000'000;
  // Operations that a batch, or making a mesh, may execute; 0: any number.
  std::uint64_t max_batch_operations = 0;
  // Edits of all batches that are being received or wait for their turn.
  std::uint64_t max_pending_edits = 8'000'000;
  int max_message_bytes = 4 << 20;  // received in one message
  std::uint64_t max_watchers = 10'000;
  std::uint64_t max_edit_streams = 1'000;
  std::uint64_t max_snapshot_streams = 64;  // each may hold an old copy of a mesh
  // Watches, edit streams, loads, snapshots and reads of features that one client, a token or an
  // address, has open. 0: any number.
  std::uint64_t max_streams_per_client = 1'000;
  std::uint64_t max_waiting_edits = 1'000;  // unary batches that wait for one mesh
  // Requests a second of one client, a token or an address, and as many at once after a pause;
  // each batch of an EditStream is one. 0: any number.
  double max_requests_per_second = 100'000;
  // Resident bytes of the process above which nothing grows; 0: nine tenths of what it may have.
  std::uint64_t max_memory_bytes = 0;
  // What is measured for that. Not an option: for tests.
  std::uint64_t (*resident_bytes)() = &ResidentBytes;
  // Calls open on one connection; further ones wait in the client.
  int max_streams_per_connection = 10'000;
  // Connections, all together. Those above it are closed at once.
  std::uint64_t max_connections = 20'000;
  // For TLS, and until the first word of HTTP/2.
  absl::Duration handshake_timeout = absl::Seconds(20);
  // A client that is silent for so long is asked whether it is there, and has so long to say so.
  absl::Duration keepalive_interval = absl::Seconds(60);
  absl::Duration keepalive_timeout = absl::Seconds(20);
  // Of a connection without calls. Clients connect again by themselves.
  absl::Duration idle_timeout = absl::Minutes(10);
  // A batch in pieces, or a load, of which nothing more comes for so long is given up; so is a
  // stream of edits that does not begin.
  absl::Duration batch_timeout = absl::Minutes(5);
  // A call whose client takes nothing of what is sent to it for so long is ended. 0: never.
  absl::Duration send_timeout = absl::Minutes(5);
  // Batches of one EditStream that are received and not fully answered.
  int edit_window = 128;

  // Diffs kept of each mesh for watchers that come back. The newest is always kept.
  std::uint64_t history_revisions = 10'000;
  std::uint64_t history_bytes = 64 << 20;
  std::uint64_t remembered_requests = 10'000;  // request_ids of a mesh
  // Bytes of a mesh's edits (and as many as its last snapshot has), or operations they executed
  // (and twice as many as the mesh has), after which the journal's next snapshot is written, from
  // which the mesh is made again.
  std::uint64_t compact_bytes = 1 << 20;
  std::uint64_t compact_operations = 1'000'000;
  // Bytes of a mesh's journal that are kept before its newest snapshot, and at least one
  // generation.
  std::uint64_t journal_history_bytes = 64 << 20;
  // Revisions a watcher may lag before it is sent coalesced diffs.
  std::uint64_t watch_queue = 64;
  absl::Duration progress_interval = absl::Seconds(10);  // default, for idle watchers

  absl::Duration report_interval = absl::Seconds(5);  // of long work, to the log
  absl::Duration drain_timeout = absl::Seconds(20);
};

// Is it reached from this machine only? Names other than localhost are not looked up.
bool IsLoopback(absl::string_view listen);

// INVALID_ARGUMENT, naming the option, if a limit makes no sense, or what was asked for is not
// safe.
absl::Status ValidateConfig(const ServerConfig& config);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CONFIG_CONFIG_H_
