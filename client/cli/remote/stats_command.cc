// dynmesh stats [MESH] --server ADDR: figures of a server and of a mesh; dynmesh stats MESHFILE: of
// a file, in process. With --watch repeatedly (stats_watch.h).
#include <memory>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_format.h"
#include "client/cli/file_stats.h"
#include "client/cli/remote/connection.h"
#include "client/cli/remote/remote_commands.h"
#include "client/cli/remote/stats_watch.h"
#include "client/cli/words.h"

namespace dynmesh::cli {
namespace {

struct StatsCommand {
  std::string mesh;  // an id or a file
  ServerFlags server;
  FileStatsFlags file;
  CLI::Option* watch = nullptr;  // its text is the seconds, which are optional
  std::string watch_seconds;
  std::uint64_t count = 0;
};

std::string StatsText(const client::ServerStatus& s) {
  std::string text = absl::StrFormat(
      "server version     %s\n"
      "uptime             %s\n"
      "meshes             %d\n"
      "watchers           %d\n",
      s.version, absl::FormatDuration(absl::Trunc(s.uptime, absl::Seconds(1))), s.meshes,
      s.watchers);
  if (!s.mesh.has_value()) return text;
  const client::MeshStatus& m = *s.mesh;
  const std::string subfacets =
      m.dimension == 3 ? absl::StrFormat("subfacets          %d\n", m.stats.subfacets) : "";
  absl::StrAppendFormat(&text,
                        "revision           %d\n"
                        "oldest revision    %d\n"
                        "hash               %s\n"
                        "features           %d\n"
                        "vertices           %d\n"
                        "%-17s  %d\n"
                        "subsegments        %d\n"
                        "%s"
                        "operations         %d\n"
                        "trace              %.1f MB\n"
                        "mesh               %.1f MB\n"
                        "watchers of it     %d\n"
                        "waiting edits      %d\n",
                        m.stats.revision, m.oldest_revision, m.hash.ToHex(), m.stats.features,
                        m.stats.vertices, SimplicesWord(m.dimension), m.stats.simplices,
                        m.stats.subsegments, subfacets, m.stats.operations,
                        static_cast<double>(m.stats.trace_bytes) / 1e6,
                        static_cast<double>(m.stats.mesh_bytes) / 1e6, m.watchers, m.waiting_edits);
  return text;
}

std::string StatsJson(const std::string& id, const client::ServerStatus& s) {
  JsonObject object;
  object.AddText("server_version", s.version)
      .Add("uptime_seconds", absl::ToDoubleSeconds(s.uptime))
      .Add("meshes", s.meshes)
      .Add("watchers", s.watchers);
  if (s.mesh.has_value()) {
    const client::MeshStatus& m = *s.mesh;
    object.AddText("mesh", id)
        .Add("revision", m.stats.revision)
        .Add("oldest_revision", m.oldest_revision)
        .AddText("hash", m.hash.ToHex())
        .Add("features", m.stats.features)
        .Add("vertices", m.stats.vertices)
        .Add("simplices", m.stats.simplices)
        .Add("subsegments", m.stats.subsegments)
        .Add("subfacets", m.stats.subfacets)
        .Add("dimension", m.dimension)
        .Add("operations", m.stats.operations)
        .Add("trace_bytes", m.stats.trace_bytes)
        .Add("mesh_bytes", m.stats.mesh_bytes)
        .Add("mesh_watchers", m.watchers)
        .Add("waiting_edits", m.waiting_edits);
  }
  return object.ToLine();
}

absl::StatusOr<StatsWatch> WatchOf(const StatsCommand& command) {
  StatsWatch watch;
  watch.count = command.count;
  double seconds = 0;
  if (command.watch_seconds.empty()) return watch;
  if (!absl::SimpleAtod(command.watch_seconds, &seconds) || !(seconds >= 0.01 && seconds <= 1e6)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--watch %s: must be seconds; a mesh's id comes before it", command.watch_seconds));
  }
  watch.interval = absl::Seconds(seconds);
  return watch;
}

int Run(const StatsCommand& command) {
  if (command.watch->count() > 0) {
    if (IsMeshFile(command.mesh) || !command.file.svg.empty()) {
      return ReportServerError(absl::InvalidArgumentError("--watch is of a server's meshes"));
    }
    const auto watch = WatchOf(command);
    if (!watch.ok()) return ReportServerError(watch.status());
    return RunStatsWatch(command.mesh, *watch, command.server);
  }
  if (IsMeshFile(command.mesh))
    return RunFileStats(command.mesh, command.file, command.server.json);
  if (!command.file.svg.empty()) {
    return ReportServerError(absl::InvalidArgumentError(
        "--svg draws a mesh file's angles: export the mesh (-o MESH.node) and give that file"));
  }
  if (command.file.min_dihedral) {
    return ReportServerError(absl::InvalidArgumentError(
        "--min-dihedral is of a mesh file: export the mesh (-o MESH.node) and give that file"));
  }
  const auto client = Connect(command.server);
  if (!client.ok()) return ReportServerError(client.status());
  const auto status = (*client)->GetStats(command.mesh);
  if (!status.ok()) return ReportServerError(status.status());
  return Print(command.server.json ? StatsJson(command.mesh, *status) : StatsText(*status));
}

}  // namespace

void RegisterStatsCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<StatsCommand>();
  CLI::App* const sub =
      AddCommand(app, slot, "stats", "Figures of a server and of a mesh, or of a mesh file",
                 [command] { return Run(*command); });
  sub->add_option("MESH", command->mesh,
                  "Its id (default: of the server only), or a .node file, which needs no server");
  command->watch = sub->add_option("--watch", command->watch_seconds,
                                   "A table of the server's meshes, refreshed every SECONDS "
                                   "(default: 2) until Ctrl-C")
                       ->type_name("SECONDS")
                       ->expected(0, 1);
  sub->add_option("--count", command->count, "With --watch: end after so many tables")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->needs(command->watch);
  AddFileStatsFlags(*sub, command->file);
  AddServerFlags(*sub, command->server);
}

}  // namespace dynmesh::cli
