#include "client/cli/remote/connection.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <tuple>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/command.h"
#include "client/cli/mesh_flags.h"
#include "client/cli/words.h"
#include "core/io/script/edit_script.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::cli {

namespace {

// Leaves `text` unchanged if no file was given.
absl::Status ReadFlagFile(const char* flag, const std::string& path, std::string* text) {
  if (path.empty()) return absl::OkStatus();
  std::ifstream in(path, std::ios::binary);
  text->assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  if (in.good() && !text->empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s: %s cannot be read, or is empty", flag, path));
}

// A character that HTTP/2 forbids in a header would abort the process.
absl::Status CheckToken(const std::string& token) {
  const bool good =
      std::all_of(token.begin(), token.end(), [](char c) { return c > ' ' && c < 0x7f; });
  if (good) return absl::OkStatus();
  return absl::InvalidArgumentError("the token has characters that no token has");
}

}  // namespace

void AddConnectionFlags(CLI::App& command, ServerFlags& flags, const std::string& server) {
  command.add_option("--server", flags.address, server)->type_name("HOST:PORT");
  command
      .add_option("--timeout", flags.timeout_seconds,
                  "Time for each request, in seconds or with a unit, as 8s, 500ms or 10m (default: "
                  "none)")
      ->type_name("TIME")
      ->check(CLI::PositiveNumber)
      ->transform(CLI::AsNumberWithUnit(
          std::map<std::string, double>{{"ms", 0.001}, {"s", 1}, {"m", 60}, {"h", 3600}}));
  CLI::Option* const ca =
      command
          .add_option("--tls-ca", flags.tls_ca,
                      "Use TLS; PEM file of the authority that signed the server's certificate")
          ->type_name("FILE");
  CLI::Option* const certificate =
      command.add_option("--tls-cert", flags.tls_certificate, "PEM file: the certificate to show")
          ->type_name("FILE")
          ->needs(ca);
  CLI::Option* const key =
      command.add_option("--tls-key", flags.tls_key, "PEM file: its private key")
          ->type_name("FILE")
          ->needs(certificate);
  certificate->needs(key);
  command
      .add_option("--token-file", flags.token_file,
                  "File with the token to show (default: the environment's DYNMESH_TOKEN, if set)")
      ->type_name("FILE");
}

void AddServerFlags(CLI::App& command, ServerFlags& flags) {
  AddConnectionFlags(command, flags,
                     "The server; or some of those that share the meshes, with commas between "
                     "(default: 127.0.0.1:7878)");
  command.add_flag("--from-followers", flags.from_followers,
                   "Read from the first of the servers, which may follow the mesh of another one: "
                   "some ten milliseconds old");
  command.add_flag("--json", flags.json, "Print one JSON object a line");
}

absl::StatusOr<mesh_data::RegionChoice> ParseServerRegionFlag(const std::string& text) {
  absl::StatusOr<mesh_data::RegionChoice> choice = ParseRegionFlag(text);
  if (!choice.ok() || !choice->in_any) return choice;
  return absl::InvalidArgumentError(
      "--region: name the polygons by their ids, as 7,9; only `dynmesh mesh` and `dynmesh export` "
      "take any");
}

absl::StatusOr<std::unique_ptr<client::MeshClient>> Connect(const ServerFlags& flags) {
  client::ClientOptions options;
  for (const auto& [flag, path, text] :
       {std::tuple{"--tls-ca", &flags.tls_ca, &options.tls_ca},
        std::tuple{"--tls-cert", &flags.tls_certificate, &options.tls_certificate},
        std::tuple{"--tls-key", &flags.tls_key, &options.tls_key},
        std::tuple{"--token-file", &flags.token_file, &options.token}}) {
    if (absl::Status s = ReadFlagFile(flag, *path, text); !s.ok()) return s;
  }
  if (flags.token_file.empty()) {
    if (const char* const token = std::getenv("DYNMESH_TOKEN")) options.token = token;
  }
  absl::StripAsciiWhitespace(&options.token);
  if (absl::Status s = CheckToken(options.token); !s.ok()) return s;
  options.from_followers = flags.from_followers;
  if (flags.timeout_seconds > 0) options.timeout = absl::Seconds(flags.timeout_seconds);
  return client::MeshClient::Connect(flags.address, options);
}

const char* WordOf(client::LoadProgress::Stage stage) {
  using Stage = client::LoadProgress::Stage;
  switch (stage) {
    case Stage::kSend:
      return "sending";
    case Stage::kWait:
      return "waiting for other edits";
    case Stage::kValidate:
      return "validating";
    case Stage::kRefine:
      return "refining";
    case Stage::kDiff:
      return "making the diff";
    case Stage::kWrite:
      return "writing to the server's disk";
  }
  return "";
}

std::string MeshLine(const client::MeshInfo& mesh, bool json) {
  const MeshOptions& o = mesh.options;
  if (!mesh.damage.empty() && !(mesh.read_only && json)) {
    return json ? JsonObject().AddText("mesh", mesh.id).AddText("damage", mesh.damage).ToLine()
                : absl::StrFormat("%s  DAMAGED  %s\n", mesh.id, mesh.damage);
  }
  if (!mesh.owner.empty()) {
    return json ? JsonObject()
                      .AddText("mesh", mesh.id)
                      .Add("revision", mesh.revision)
                      .AddText("owner", mesh.owner)
                      .ToLine()
                : absl::StrFormat("%s  revision %d  at %s\n", mesh.id, mesh.revision, mesh.owner);
  }
  if (!json) {
    return absl::StrFormat("%s  revision %d  hash %s  %s\n", mesh.id, mesh.revision,
                           mesh.hash.ToHex(), io::FormatMeshLine(o));
  }
  JsonObject line;
  line.AddText("mesh", mesh.id);
  if (mesh.read_only) line.AddText("damage", mesh.damage);
  return line.Add("revision", mesh.revision)
      .AddText("hash", mesh.hash.ToHex())
      .Add("dimension", o.dimension)
      .AddText("kind", NameOf(o.kind))
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
    JsonObject line;
    line.AddText("event", event)
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
        .Add("notified", diff.work.notified)
        .Add("visited_cells", diff.work.visited_cells)
        .Add("visited_nodes", diff.work.visited_nodes)
        .Add("microseconds", diff.work.microseconds)
        .AddText("hash", diff.hash.ToHex());
    AddLabels(diff.labels, line);
    return line.ToLine();
  }
  return absl::StrFormat(
      "revision %d: vertices +%d -%d, %s +%d -%d, %d operations, %.0f us, hash %s%s\n",
      diff.to_revision, diff.added_vertices.size(), diff.removed_vertices.size(),
      SimplicesWord(diff.dimension), diff.added_simplex_count(), diff.removed_simplex_count(),
      diff.work.executed, diff.work.microseconds, diff.hash.ToHex(),
      diff.labels.empty() ? "" : absl::StrFormat(", labels %d", diff.labels.size()));
}

void AddLabels(const LabelColumn& labels, JsonObject& line) {
  if (labels.empty()) return;
  std::vector<JsonObject> rows;
  rows.reserve(labels.size());
  for (const auto& [id, label] : labels) {
    rows.push_back(JsonObject()
                       .AddText("id", std::to_string(id))
                       .Add("marker", label.marker)
                       .AddText("name", label.name));
  }
  line.AddObjects("labels", rows);
}

absl::Status WithReason(const absl::Status& status) {
  const auto error = codec::GetServiceError(status);
  if (!error.has_value() || error->reason.empty()) return status;
  return {status.code(), absl::StrCat(status.message(), " (", error->reason, ")")};
}

int ReportServerError(const absl::Status& status) { return ReportError(WithReason(status)); }

void WarnOfEmptyMesh(const std::string& mesh) {
  PrintWarning(absl::StrFormat(
      "this command made the mesh %s, and nothing is in it: `dynmesh delete %s` deletes it", mesh,
      mesh));
}

int Print(const std::string& text) {
  if (PrintOut(text)) return kExitDone;
  return ReportError(absl::UnavailableError("cannot write to standard output"));
}

}  // namespace dynmesh::cli
