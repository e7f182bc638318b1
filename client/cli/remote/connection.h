// Shared by the remote commands: connecting, and printing meshes.
#ifndef DYNMESH_CLIENT_CLI_REMOTE_CONNECTION_H_
#define DYNMESH_CLIENT_CLI_REMOTE_CONNECTION_H_

#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cli/json.h"
#include "core/mesh_data/region_filter.h"
#include "dynmesh/client/mesh_client.h"

namespace dynmesh::cli {

struct ServerFlags {
  std::string address = "127.0.0.1:7878";
  double timeout_seconds = 0;  // 0: none
  bool json = false;
  std::string tls_ca;
  std::string tls_certificate;
  std::string tls_key;
  std::string token_file;
  bool from_followers = false;
};

// --server --timeout --tls-ca --tls-cert --tls-key --token-file; `server` describes the first.
void AddConnectionFlags(CLI::App& command, ServerFlags& flags, const std::string& server);
// The same, --from-followers and --json.
void AddServerFlags(CLI::App& command, ServerFlags& flags);

// Parses --region, as ParseRegionFlag. A server needs the polygons' ids: `any` is refused.
absl::StatusOr<mesh_data::RegionChoice> ParseServerRegionFlag(const std::string& text);

// Connects with the token of --token-file, else of the environment's DYNMESH_TOKEN. Fails if a file
// is unreadable, but not if the server is unreachable.
absl::StatusOr<std::unique_ptr<client::MeshClient>> Connect(const ServerFlags& flags);

// For a progress bar.
const char* WordOf(client::LoadProgress::Stage stage);

// One line for a mesh, as text or JSON.
std::string MeshLine(const client::MeshInfo& mesh, bool json);
// Adds `labels` to a line of JSON, if there are any: objects with `id`, `marker` and `name`.
void AddLabels(const LabelColumn& labels, JsonObject& line);
// One line for a revision.
std::string DiffLine(const MeshDiff& diff, const char* event, bool json);

// The reason in the details of a server's error, such as JOURNAL_FAILED, behind its message: the
// runbook is sorted by it. Other statuses are unchanged. Drops the details.
absl::Status WithReason(const absl::Status& status);
// ReportError of that.
int ReportServerError(const absl::Status& status);

// Another client may use the mesh by now: the command does not delete it.
void WarnOfEmptyMesh(const std::string& mesh);

// Prints, or reports that standard output failed. Returns the exit code.
int Print(const std::string& text);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_REMOTE_CONNECTION_H_
