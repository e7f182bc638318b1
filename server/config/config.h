// The server's options, with safe defaults for limits. Plain data.
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
  // host:port; the default is loopback. Port 0 picks a free port.
  std::string listen = "127.0.0.1:7878";
  TlsFiles tls;
  // Allows a listen address that is not loopback without TLS. Refused otherwise.
  bool insecure_listen = false;
  // Tokens and their roles (tokens.h). Empty: every client may do everything.
  std::string tokens_file;

  // HOST or HOST:PORT at which clients and other servers reach this one; without a port, or with
  // port 0, the one of `listen`. Not empty: it shares the journal's meshes with others that have
  // such an address. Empty: it has all meshes itself.
  std::string node_address;
  // PEM file of the authority of the other servers' certificates, for calls that are handed on to
  // them. With TLS and without this none is.
  std::string node_ca;
  // How long another server waits, when this one has ended, before it takes over its meshes.
  absl::Duration lease = absl::Seconds(3);
  // Servers that follow each mesh in use, besides the one that has it. 0: none, and meshes are not
  // handed over at a drain.
  std::uint64_t followers = 1;
  // Meshes that this server follows at most, those included that a read asked for. 0: none.
  std::uint64_t max_followed_meshes = 100;
  // A mesh that nothing was written to, read of or watched for so long is not followed any more.
  absl::Duration follower_idle = absl::Minutes(10);

  // host:port of metrics and health over HTTP (metrics_http.h); empty: none.
  std::string metrics;

  // host:port of the service itself over HTTP (http_door.h); empty: none.
  std::string http;
  // The name in the address that browsers have, as behind a proxy; empty: the host of `http`.
  std::string http_name;
  // Connections of HTTP, each with a thread while it is open. Further ones are answered 503.
  std::uint64_t max_http_connections = 256;

  // Threads that apply edits and threads that serve readers. Meshes run in parallel; one mesh has
  // at most one writer thread at a time. 0: one per core, at least 2.
  int writer_threads = 0;
  int reader_threads = 0;

  std::uint64_t max_meshes = 1'000;
  // Limit of one mesh; 0: what half of max_memory_bytes holds (memory_guard.h).
  std::uint64_t max_vertices = 0;
  std::uint64_t max_features = 50'000'000;  // limit of one mesh
  // Edits in one batch, about 140 bytes each until applied. 8 points of polygons count as one edit;
  // each ring counts as 3 more.
  std::uint64_t max_batch_edits = 2'000'000;
  // Limit of operations of a batch, or of the creation of a mesh. 0: no limit.
  std::uint64_t max_batch_operations = 0;
  // Edits of all batches that are being received or wait.
  std::uint64_t max_pending_edits = 8'000'000;
  int max_message_bytes = 4 << 20;  // size limit of one received message
  std::uint64_t max_watchers = 10'000;
  std::uint64_t max_edit_streams = 1'000;
  std::uint64_t max_snapshot_streams = 64;  // each may hold an old copy of a mesh
  // Builds (BuildMesh) that are open, from the first features to the last chunk. Each has a thread
  // of low priority and holds a mesh. 0: none are allowed.
  std::uint64_t max_builds = 8;
  // Limit of the mesh of a build; 0: as of max_vertices.
  std::uint64_t max_build_vertices = 0;
  // Limit of the time of a build, without receiving and sending. 0: no limit.
  absl::Duration max_build_time = absl::Minutes(10);
  // Open watches, edit streams, loads, builds, snapshots and reads of features of one client (a
  // token or an address). 0: no limit.
  std::uint64_t max_streams_per_client = 1'000;
  std::uint64_t max_waiting_edits = 1'000;  // unary batches that wait for one mesh
  // Requests per second of one client (a token or an address), and the burst size after a pause.
  // Each batch of an EditStream counts as one request. 0: no limit.
  double max_requests_per_second = 100'000;
  // Above this many resident bytes of the process nothing grows. 0: nine tenths of the available
  // memory.
  std::uint64_t max_memory_bytes = 0;
  // Measures the resident bytes. Not an option: for tests.
  std::uint64_t (*resident_bytes)() = &ResidentBytes;
  // Open calls per connection; further calls wait in the client.
  int max_streams_per_connection = 10'000;
  // Limit of all connections together. Further ones are closed at once.
  std::uint64_t max_connections = 20'000;
  // The same of one address; an IPv6 network of 64 bits is one. 0: half of max_connections.
  std::uint64_t max_connections_per_address = 0;
  // New connections per second of one address, not counting those with an answered call. After a
  // pause those of 0.4 s at once. Further ones wait. 0: no limit.
  double max_new_connections_per_second = 20;
  // Calls per second of one address, and the burst size, that are refused for their token or that
  // the client cancels at once. Then the connections that they came on are cut, and new ones are
  // refused for a second. 0: no limit.
  double max_wasted_calls_per_second = 200;
  // For the TLS handshake and the first bytes of HTTP/2.
  absl::Duration handshake_timeout = absl::Seconds(20);
  // A client silent for keepalive_interval is pinged. It has keepalive_timeout to answer.
  absl::Duration keepalive_interval = absl::Seconds(60);
  absl::Duration keepalive_timeout = absl::Seconds(20);
  // A connection without calls is closed after this time. Clients reconnect by themselves.
  absl::Duration idle_timeout = absl::Minutes(10);
  // Limit of the pause between the parts of a batch or load; then it is cancelled. Also the limit
  // for the first message of an edit stream.
  absl::Duration batch_timeout = absl::Minutes(5);
  // Limit for one message to wait for the client to take it; then the call ends. 0: no limit.
  absl::Duration send_timeout = absl::Minutes(5);
  // Batches of one EditStream that are received and not fully answered. As many as are applied
  // while a journal on other machines confirms those before them.
  int edit_window = 512;
  // Once more bytes of its answers wait for the client to take them, a stream reads no batch.
  std::uint64_t edit_answer_bytes = 16 << 20;

  // Diffs kept of each mesh for watchers that reconnect. The newest diff is always kept.
  std::uint64_t history_revisions = 10'000;
  std::uint64_t history_bytes = 64 << 20;
  std::uint64_t remembered_requests = 10'000;  // request_ids kept per mesh
  // When the journal writes its next snapshot, from which the mesh is rebuilt: after this many
  // bytes of edits and at least as many as the last snapshot has, or after compact_operations
  // executed operations and at least twice as many as the mesh has.
  std::uint64_t compact_bytes = 1 << 20;
  std::uint64_t compact_operations = 1'000'000;
  // Bytes of a mesh's journal that are kept before its newest snapshot. At least one generation is
  // kept.
  std::uint64_t journal_history_bytes = 64 << 20;
  // Revisions that a watcher may lag before it is sent coalesced diffs.
  std::uint64_t watch_queue = 64;
  absl::Duration progress_interval = absl::Seconds(10);  // default, for idle watchers

  absl::Duration report_interval = absl::Seconds(5);  // between log lines of long work
  absl::Duration drain_timeout = absl::Seconds(20);
};

// True iff the address is reachable from this machine only. Names other than localhost are not
// resolved.
bool IsLoopback(absl::string_view listen);

// INVALID_ARGUMENT, naming the option, for a limit out of range or an unsafe setting.
absl::Status ValidateConfig(const ServerConfig& config);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CONFIG_CONFIG_H_
