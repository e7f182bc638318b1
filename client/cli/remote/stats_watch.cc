#include "client/cli/remote/stats_watch.h"

#include <signal.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <limits>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "client/cli/command.h"

namespace dynmesh::cli {
namespace {

// A request that hangs would delay the handling of a signal.
constexpr double kTimeoutSeconds = 10;

struct Row {
  std::string mesh;
  client::MeshStatus status;
  double rate = std::numeric_limits<double>::quiet_NaN();  // revisions per second; unknown at first
};

// Blocks SIGINT and SIGTERM during its lifetime, so that the loop polls for them. To be made before
// any other thread, which would otherwise get the signals.
class SignalsInTurn {
 public:
  SignalsInTurn() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, &before_);
  }
  ~SignalsInTurn() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

  // True if a signal came before `time`.
  bool WaitUntil(absl::Time time) const {
    while (true) {
      const timespec left = absl::ToTimespec(std::max(absl::ZeroDuration(), time - absl::Now()));
      if (sigtimedwait(&signals_, nullptr, &left) > 0) return true;
      if (errno != EINTR) return false;
    }
  }

 private:
  sigset_t signals_;
  sigset_t before_;
};

// The meshes' figures, refreshed repeatedly, with the previous ones for the rates.
class Figures {
 public:
  Figures(client::MeshClient& client, std::string mesh) : client_(client), only_(std::move(mesh)) {}

  absl::StatusOr<std::vector<Row>> Next() {
    std::vector<std::string> ids = {only_};
    if (only_.empty()) {
      const auto meshes = client_.ListMeshes();
      if (!meshes.ok()) return meshes.status();
      ids.clear();
      for (const client::MeshInfo& info : *meshes) {
        if (info.damage.empty() || info.read_only) ids.push_back(info.id);
      }
    }
    std::vector<Row> rows;
    std::map<std::string, Seen> seen;
    for (const std::string& id : ids) {
      const auto status = client_.GetStats(id);
      // A listed mesh may have been deleted since.
      if (only_.empty() && absl::IsNotFound(status.status())) continue;
      if (!status.ok()) return status.status();
      Row row{id, *status->mesh};
      const Seen now{row.status.stats.revision, absl::Now()};
      // A mesh that was deleted and made again restarts.
      if (const auto it = seen_.find(id);
          it != seen_.end() && it->second.revision <= now.revision) {
        row.rate = static_cast<double>(now.revision - it->second.revision) /
                   absl::ToDoubleSeconds(now.time - it->second.time);
      }
      seen.emplace(id, now);
      rows.push_back(std::move(row));
    }
    seen_ = std::move(seen);
    return rows;
  }

 private:
  struct Seen {
    std::uint64_t revision;
    absl::Time time;
  };
  client::MeshClient& client_;
  const std::string only_;
  std::map<std::string, Seen> seen_;
};

std::string Table(const std::vector<Row>& rows) {
  std::size_t width = 4;
  for (const Row& row : rows) width = std::max(width, row.mesh.size());
  const int w = static_cast<int>(width);
  std::string text = absl::StrFormat("%-*s %10s %10s %10s %10s %9s %12s\n", w, "mesh", "revision",
                                     "features", "vertices", "simplices", "edits/s", "memory");
  for (const Row& row : rows) {
    const MeshStats& s = row.status.stats;
    const std::string rate = row.rate >= 0 ? absl::StrFormat("%.1f", row.rate) : "-";
    absl::StrAppendFormat(&text, "%-*s %10d %10d %10d %10d %9s %9.1f MB\n", w, row.mesh, s.revision,
                          s.features, s.vertices, s.simplices, rate,
                          static_cast<double>(s.trace_bytes + s.mesh_bytes) / 1e6);
  }
  return text;
}

std::string Line(const std::vector<Row>& rows) {
  std::vector<JsonObject> meshes;
  for (const Row& row : rows) {
    const MeshStats& s = row.status.stats;
    JsonObject mesh;
    mesh.AddText("mesh", row.mesh)
        .Add("revision", s.revision)
        .Add("features", s.features)
        .Add("vertices", s.vertices)
        .Add("simplices", s.simplices)
        .Add("edits_per_second", row.rate)
        .Add("trace_bytes", s.trace_bytes)
        .Add("mesh_bytes", s.mesh_bytes)
        .Add("watchers", row.status.watchers)
        .Add("waiting_edits", row.status.waiting_edits);
    meshes.push_back(std::move(mesh));
  }
  return JsonObject()
      .AddText("time", absl::FormatTime(absl::RFC3339_full, absl::Now(), absl::UTCTimeZone()))
      .AddObjects("meshes", meshes)
      .ToLine();
}

}  // namespace

int RunStatsWatch(const std::string& mesh, const StatsWatch& watch, const ServerFlags& server) {
  const SignalsInTurn signals;
  ServerFlags flags = server;
  if (flags.timeout_seconds == 0) flags.timeout_seconds = kTimeoutSeconds;
  const auto client = Connect(flags);
  if (!client.ok()) return ReportServerError(client.status());
  Figures figures(**client, mesh);
  const bool terminal = OutIsTerminal();
  absl::Time next = absl::Now();
  for (std::uint64_t i = 0; watch.count == 0 || i < watch.count; ++i) {
    if (signals.WaitUntil(next)) return kExitDone;
    const auto rows = figures.Next();
    if (!rows.ok()) return ReportServerError(rows.status());
    std::string text = server.json ? Line(*rows) : Table(*rows);
    if (!server.json) {
      // On a terminal redraws from the top; else prints one table after the other.
      text.insert(0, terminal ? "\033[H\033[2J" : i > 0 ? "\n" : "");
    }
    if (const int code = Print(text); code != kExitDone) return code;
    next = absl::Now() + watch.interval;
  }
  return kExitDone;
}

}  // namespace dynmesh::cli
