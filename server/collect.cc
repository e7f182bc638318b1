#include "server/collect.h"

#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "dynmesh/version.h"
#include "server/base/process.h"

namespace dynmesh::server {
namespace {

// Field `n` > 2 of /proc/self/stat, numbered as in proc(5). Field 2, the command's name, may
// contain anything and ends at the last parenthesis.
double StatField(const std::string& stat, int n) {
  std::istringstream fields(stat.substr(std::min(stat.size(), stat.rfind(')') + 1)));
  std::string word;
  for (int i = 3; i <= n && fields >> word; ++i) {
  }
  return word.empty() ? 0 : std::strtod(word.c_str(), nullptr);
}

std::string ReadAll(const char* path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

double SecondsOf(clockid_t clock) {
  timespec time = {};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Boot time in seconds since 1970. Not from /proc/stat, which may be hidden from a service.
double BootedAt() { return SecondsOf(CLOCK_REALTIME) - SecondsOf(CLOCK_BOOTTIME); }

}  // namespace

void WriteMeshes(const MeshRegistry& meshes, MetricsText& out) {
  struct Row {
    std::string id;
    MeshStats stats;
    std::size_t watchers;
    WatchHub::Counts watches;
    std::size_t waiting;
    std::optional<MeshHost::Running> running;
  };
  std::vector<Row> rows;
  for (const auto& host : meshes.Hosts()) {
    rows.push_back({host->id(), host->stats(), host->hub()->size(), host->hub()->counts(),
                    host->waiting(), host->running()});
  }
  const auto write = [&](const char* name, const char* help, auto value) {
    out.Begin(name, "gauge", help);
    for (const Row& row : rows) out.Sample({{"mesh", row.id}}, static_cast<double>(value(row)));
  };
  out.Single("dynmesh_meshes", "gauge", "Meshes held, damaged ones included.",
             static_cast<double>(meshes.size()));
  write("dynmesh_mesh_revision", "Revision.", [](const Row& r) { return r.stats.revision; });
  write("dynmesh_mesh_features", "Features.", [](const Row& r) { return r.stats.features; });
  write("dynmesh_mesh_vertices", "Vertices.", [](const Row& r) { return r.stats.vertices; });
  write("dynmesh_mesh_simplices", "Triangles, in 3D tetrahedra.",
        [](const Row& r) { return r.stats.simplices; });
  write("dynmesh_mesh_trace_bytes", "Memory of the trace, which makes edits quick.",
        [](const Row& r) { return r.stats.trace_bytes; });
  write("dynmesh_mesh_bytes", "Memory of the mesh, its trace aside.",
        [](const Row& r) { return r.stats.mesh_bytes; });
  write("dynmesh_mesh_watchers", "Watches.", [](const Row& r) { return r.watchers; });
  write("dynmesh_mesh_watchers_behind",
        "Watches that have not been handed all there is, those included that are being sent it.",
        [](const Row& r) { return r.watches.behind; });
  const auto count = [&](const char* name, const char* help, auto value) {
    out.Begin(name, "counter", help);
    for (const Row& row : rows) out.Sample({{"mesh", row.id}}, static_cast<double>(value(row)));
  };
  count("dynmesh_mesh_watch_coalesced_total",
        "Diffs sent that stand for several revisions, to watches that fell behind.",
        [](const Row& r) { return r.watches.coalesced; });
  count("dynmesh_mesh_watch_resynced_total",
        "Snapshots sent to watches that fell too far behind for diffs.",
        [](const Row& r) { return r.watches.resynced; });
  write("dynmesh_mesh_waiting_edits", "Batches and queries that wait for their turn.",
        [](const Row& r) { return r.waiting; });
  write("dynmesh_mesh_batch_edits", "Edits of the batch that runs; 0: none does.",
        [](const Row& r) { return r.running.has_value() ? r.running->edits : 0; });
  const auto write_running = [&](const char* name, const char* help, auto value) {
    out.Begin(name, "gauge", help);
    for (const Row& row : rows) {
      if (!row.running.has_value()) continue;
      const BatchProgress& progress = row.running->progress;
      out.Sample({{"mesh", row.id}, {"stage", NameOf(progress.stage)}},
                 static_cast<double>(value(progress)));
    }
  };
  write_running("dynmesh_mesh_batch_done_ratio",
                "How much of the batch's stage is done: 0 to 1; 0 also if that is not known yet.",
                [](const BatchProgress& p) {
                  return p.total == 0 ? 0
                                      : static_cast<double>(p.done) / static_cast<double>(p.total);
                });
  write_running("dynmesh_mesh_batch_work_done",
                "How much of the batch's stage is done, in whatever the stage counts.",
                [](const BatchProgress& p) { return p.done; });
  write_running("dynmesh_mesh_batch_work",
                "How much the batch's stage is, in the same; 0: not known yet.",
                [](const BatchProgress& p) { return p.total; });
}

void WriteNode(const MeshRegistry& meshes, const LeaseKeeper& keeper, absl::Duration lease,
               MetricsText& out) {
  const std::chrono::duration<double> age = keeper.Age();
  out.Single("dynmesh_lease_age_seconds", "gauge",
             "Since the sending of the last renewal of this server's leases that succeeded.",
             age.count());
  out.Single("dynmesh_lease_seconds", "gauge",
             "How long a lease is: an older one has ended, and another server may have the meshes.",
             absl::ToDoubleSeconds(lease));
  std::vector<std::pair<std::string, std::int64_t>> epochs;
  for (const auto& host : meshes.Hosts()) {
    if (const std::int64_t epoch = meshes.EpochOf(host->id()); epoch > 0) {
      epochs.emplace_back(host->id(), epoch);
    }
  }
  const std::vector<Followers::Followed> followed = meshes.Followed();
  out.Begin("dynmesh_mesh_role", "gauge",
            "1, with what this server is for the mesh: owner or follower.");
  for (const auto& [id, epoch] : epochs) out.Sample({{"mesh", id}, {"role", "owner"}}, 1);
  for (const auto& f : followed) {
    out.Sample({{"mesh", f.host->id()}, {"role", "follower"}}, 1);
  }
  const auto follower = [&](const char* name, const char* help, auto value) {
    out.Begin(name, "gauge", help);
    for (const auto& f : followed) {
      out.Sample({{"mesh", f.host->id()}}, static_cast<double>(value(f)));
    }
  };
  follower("dynmesh_follower_revision", "Revision of a mesh that this server follows.",
           [](const auto& f) { return f.host->head().revision; });
  follower("dynmesh_follower_lag_revisions",
           "Revisions that the journal has and this server has not made again.",
           [](const auto& f) { return f.behind; });
  follower("dynmesh_follower_lag_seconds",
           "Since this server had all that the journal had; 0: it has.",
           [](const auto& f) { return f.lag_seconds; });
  follower("dynmesh_follower_bytes", "Memory of the mesh and its trace.", [](const auto& f) {
    const MeshStats stats = f.host->stats();
    return stats.mesh_bytes + stats.trace_bytes;
  });
  follower("dynmesh_follower_watchers", "Watches that this server serves as a follower.",
           [](const auto& f) { return f.host->hub()->size(); });
  out.Begin("dynmesh_mesh_epoch", "gauge",
            "The epoch in which this server has the mesh: how often a server claimed it.");
  for (const auto& [id, epoch] : epochs) out.Sample({{"mesh", id}}, static_cast<double>(epoch));
}

void WriteJournal(const Journal& journal, MetricsText& out) {
  const Journal::Counts counts = journal.counts();
  out.Single("dynmesh_journal_syncs_total", "counter", "Transactions that are on the disk.",
             static_cast<double>(counts.syncs));
  out.Single("dynmesh_journal_failures_total", "counter",
             "Transactions that could not be written; each may be of several batches.",
             static_cast<double>(counts.failures));
  out.Single("dynmesh_journal_failing", "gauge",
             "1 if the last transaction could not be written, or the journal is gone: edits are "
             "refused.",
             counts.failing ? 1 : 0);
  out.Single("dynmesh_journal_gone", "gauge",
             "1 if the files at the journal's path are not those that were opened.",
             counts.gone ? 1 : 0);
  out.Single(
      "dynmesh_journal_oldest_write_seconds", "gauge",
      "How long the disk or the database has not answered the oldest write; 0: none is under "
      "way.",
      absl::ToDoubleSeconds(counts.oldest_write));
  out.Single("dynmesh_journal_fenced_total", "counter",
             "Writes of batches that were refused, as another server has claimed the mesh.",
             static_cast<double>(counts.fenced));
  out.Single("dynmesh_journal_unknown_total", "counter",
             "Writes of batches whose outcome was not found out: the clients are to repeat them.",
             static_cast<double>(counts.unknown));
  out.Single("dynmesh_journal_bytes", "gauge", "The journal's files.",
             static_cast<double>(journal.bytes()));
}

void WriteLimits(const MemoryGuard& memory, const TlsFiles& tls, MetricsText& out) {
  out.Single("dynmesh_memory_limit_bytes", "gauge",
             "Memory of the process above which nothing grows.",
             static_cast<double>(memory.limit()));
  if (!tls.enabled()) return;
  const absl::StatusOr<absl::Time> end = EndOfCertificate(tls.certificate);
  if (!end.ok()) return;  // the one before is in use; a log line reports the failure
  out.Single("dynmesh_certificate_end_time_seconds", "gauge",
             "When the certificate in the file is no longer valid, since 1970.",
             absl::ToDoubleSeconds(*end - absl::UnixEpoch()));
}

void WriteStreams(const ClientQuotas& streams, MetricsText& out) {
  out.Single(
      "dynmesh_client_streams_most", "gauge",
      "Watches, edit streams, loads, builds and snapshots open of the client that has most of "
      "them.",
      static_cast<double>(streams.most()));
  out.Single("dynmesh_client_streams_limit", "gauge",
             "How many one client may have; 0: any number.", static_cast<double>(streams.limit()));
}

void WriteConnections(const ConnectionTable::Counts& counts, MetricsText& out) {
  out.Single("dynmesh_connections", "gauge", "Connections open.", static_cast<double>(counts.open));
  out.Single("dynmesh_connections_waiting", "gauge",
             "New connections that wait, as their address has too many.",
             static_cast<double>(counts.waiting));
  out.Single("dynmesh_connections_refused_total", "counter",
             "Connections closed at once, as their address has as many as it may have.",
             static_cast<double>(counts.refused));
  out.Single("dynmesh_connections_cut_total", "counter",
             "Connections cut for calls without a known token, or cancelled at once.",
             static_cast<double>(counts.cut));
  out.Single("dynmesh_wasted_calls_total", "counter", "Such calls.",
             static_cast<double>(counts.wasted));
}

void WriteHttp(const HttpServer::Counts& counts, MetricsText& out) {
  out.Single("dynmesh_http_connections", "gauge", "Connections of HTTP open.",
             static_cast<double>(counts.open));
  out.Single("dynmesh_http_refused_total", "counter",
             "Connections of HTTP answered 503 or closed, as there were too many.",
             static_cast<double>(counts.refused));
}

void WriteProcess(MetricsText& out) {
  const std::string stat = ReadAll("/proc/self/stat");
  const auto ticks = static_cast<double>(sysconf(_SC_CLK_TCK));
  // Computed once: constant even if clocks are adjusted.
  static const double start = BootedAt() + StatField(stat, 22) / ticks;
  out.Single("process_resident_memory_bytes", "gauge", "Memory of the process.",
             static_cast<double>(ResidentBytes()));
  out.Single("process_cpu_seconds_total", "counter", "Processor time, user's and system's.",
             (StatField(stat, 14) + StatField(stat, 15)) / ticks);
  out.Single("process_start_time_seconds", "gauge", "When the process started, since 1970.", start);
  out.Single("process_open_fds", "gauge", "Files and connections that are open.",
             static_cast<double>(OpenDescriptors()));
  out.Begin("dynmesh_build_info", "gauge", "1, with the version.");
  out.Sample({{"version", kVersion}}, 1);
}

}  // namespace dynmesh::server
