#include "client/cli/remote/connection.h"

#include "absl/strings/str_format.h"
#include "client/cli/command.h"
#include "client/cli/mesh_flags.h"
#include "client/cli/words.h"
#include "core/io/edit_script.h"

namespace dynmesh::cli {

void AddServerFlags(CLI::App& command, ServerFlags& flags) {
  command.add_option("--server", flags.address, "The server (default: 127.0.0.1:7878)")
      ->type_name("HOST:PORT");
  command
      .add_option("--timeout", flags.timeout_seconds, "Seconds for each request (default: none)")
      ->type_name("S")
      ->check(CLI::PositiveNumber);
  command.add_flag("--json", flags.json, "Print one JSON object a line");
}

absl::StatusOr<data::RegionChoice> ParseServerRegionFlag(const std::string& text) {
  absl::StatusOr<data::RegionChoice> choice = ParseRegionFlag(text);
  if (!choice.ok() || !choice->in_any) return choice;
  return absl::InvalidArgumentError("--region: a server has to be told which polygons, not any");
}

std::unique_ptr<client::MeshClient> Connect(const ServerFlags& flags) {
  client::ClientOptions options;
  if (flags.timeout_seconds > 0) options.timeout = absl::Seconds(flags.timeout_seconds);
  return client::MeshClient::Connect(flags.address, options);
}

std::string MeshLine(const client::MeshInfo& mesh, bool json) {
  const MeshOptions& o = mesh.options;
  if (!json) {
    return absl::StrFormat("%s  revision %d  hash %s  %s\n", mesh.id, mesh.revision,
                           mesh.hash.ToHex(), io::FormatMeshLine(o));
  }
  return JsonObject()
      .AddText("mesh", mesh.id)
      .Add("revision", mesh.revision)
      .AddText("hash", mesh.hash.ToHex())
      .Add("dimension", o.dimension)
      .Add("rho", o.quality)
      .AddText("criterion", o.criterion == Criterion::kThesis ? "thesis" : "edge")
      .AddText("options", io::FormatMeshLine(o))
      .Add("max_vertices", o.limits.max_vertices)
      .AddText("create_time",
               absl::FormatTime(absl::RFC3339_full, mesh.create_time, absl::UTCTimeZone()))
      .ToLine();
}

std::string DiffLine(const MeshDiff& diff, const char* event, bool json) {
  if (json) {
    return JsonObject()
        .AddText("event", event)
        .Add("from_revision", diff.from_revision)
        .Add("revision", diff.to_revision)
        .Add("added_vertices", diff.added_vertices.size())
        .Add("removed_vertices", diff.removed_vertices.size())
        .Add("added_simplices", diff.added_simplex_count())
        .Add("removed_simplices", diff.removed_simplex_count())
        .Add("added_subfacets", diff.added_subfacets.size())
        .Add("removed_subfacets", diff.removed_subfacets.size())
        .Add("operations", diff.work.executed)
        .Add("created", diff.work.created)
        .Add("dropped", diff.work.dropped)
        .Add("microseconds", diff.work.microseconds)
        .AddText("hash", diff.hash.ToHex())
        .ToLine();
  }
  return absl::StrFormat(
      "revision %d: vertices +%d -%d, %s +%d -%d, %d operations, %.0f us, hash %s\n",
      diff.to_revision, diff.added_vertices.size(), diff.removed_vertices.size(),
      SimplicesWord(diff.dimension), diff.added_simplex_count(), diff.removed_simplex_count(),
      diff.work.executed, diff.work.microseconds, diff.hash.ToHex());
}

int Print(const std::string& text) {
  if (PrintOut(text)) return kExitDone;
  return ReportError(absl::UnavailableError("cannot write to standard output"));
}

}  // namespace dynmesh::cli
