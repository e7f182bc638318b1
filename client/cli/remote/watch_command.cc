// dynmesh watch MESH --server ADDR: follows a mesh in a replica that verifies every step. Prints
// one line per event, until a revision or indefinitely.
#include <memory>
#include <optional>
#include <string>

#include "absl/strings/str_format.h"
#include "client/cli/mesh_flags.h"
#include "client/cli/output.h"
#include "client/cli/remote/connection.h"
#include "client/cli/remote/remote_commands.h"
#include "client/cli/words.h"
#include "core/base/mutex.h"
#include "core/base/text.h"
#include "core/mesh_data/region_filter.h"

namespace dynmesh::cli {
namespace {

struct WatchCommand {
  ServerFlags server;
  std::string id;
  std::optional<std::uint64_t> until;
  std::string region;
  OutputFlags output;
  std::string markers;
  bool progress = false;
};

// Prints the events. Done when the requested revision is reached, when output fails, or when the
// watch ends.
class Printer final : public client::WatchListener {
 public:
  Printer(const WatchCommand& command, const mesh_data::RegionChoice& region)
      : command_(command), region_(region) {}

  void OnSnapshot(const client::MeshReplica& replica) override {
    Write(State("snapshot", replica, true), replica);
  }
  void OnDiff(const client::MeshReplica& replica, const MeshDiff& diff) override {
    Write(DiffLine(diff, "diff", command_.server.json), replica);
  }
  void OnProgress(const client::MeshReplica& replica) override {
    if (command_.progress) Write(State("progress", replica, false), replica);
  }
  void OnTrouble(const absl::Status& status) override {
    PrintWarning(text::Concat(text::View(status.message()), " (the watch goes on)"));
  }
  void OnEnd(const absl::Status& status) override { Finish(status); }

  const Mesh& mesh() const { return mesh_; }  // after Wait returned OK

  // Blocks until done. OK if the revision was reached.
  absl::Status Wait() {
    const MutexLock lock(mutex_);
    changed_.Wait(mutex_,
                  [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return result_.has_value(); });
    return *result_;
  }

 private:
  std::string State(const char* event, const client::MeshReplica& replica, bool with_labels) const {
    if (command_.server.json) {
      JsonObject line;
      line.AddText("event", event)
          .Add("revision", replica.revision())
          .Add("vertices", replica.vertex_count())
          .Add("simplices", replica.simplex_count())
          .Add("subsegments", replica.subsegment_count())
          .Add("subfacets", replica.subfacet_count())
          .AddText("hash", replica.hash().ToHex());
      if (with_labels) AddLabels(replica.mesh().labels(), line);
      return line.ToLine();
    }
    return absl::StrFormat("%s at revision %d: %d vertices, %d %s, hash %s\n", event,
                           replica.revision(), replica.vertex_count(), replica.simplex_count(),
                           SimplicesWord(replica.dimension()), replica.hash().ToHex());
  }

  void Write(const std::string& line, const client::MeshReplica& replica) {
    if (finished()) return;
    if (!PrintOut(line)) Finish(absl::UnavailableError("cannot write to standard output"));
    if (command_.until.has_value() && replica.revision() >= *command_.until) {
      // The mesh may change further; the output is of the requested revision.
      if (!command_.output.paths.empty()) mesh_ = mesh_data::OnlyInside(replica.ToMesh(), region_);
      Finish(absl::OkStatus());
    }
  }

  void Finish(const absl::Status& status) {
    const MutexLock lock(mutex_);
    if (!result_.has_value()) result_ = status;
    changed_.NotifyAll();
  }
  bool finished() {
    const MutexLock lock(mutex_);
    return result_.has_value();
  }

  const WatchCommand& command_;
  const mesh_data::RegionChoice& region_;
  Mutex mutex_;
  CondVar changed_;
  std::optional<absl::Status> result_ ABSL_GUARDED_BY(mutex_);
  Mesh mesh_;  // by the last callback before result_
};

int Run(const WatchCommand& command) {
  if (auto status = CheckOutputs(command.output); !status.ok()) return ReportServerError(status);
  if (!command.output.paths.empty() && !command.until.has_value()) {
    return ReportServerError(absl::InvalidArgumentError("-o needs --until: of which revision?"));
  }
  MeshLabels labels;
  if (auto status = ParseMarkersFlag(command.markers, labels); !status.ok()) {
    return ReportServerError(status);
  }
  const auto region = ParseServerRegionFlag(command.region);
  if (!region.ok()) return ReportServerError(region.status());
  const auto connection = Connect(command.server);
  if (!connection.ok()) return ReportServerError(connection.status());
  client::MeshClient* const client = connection->get();
  // Queried first, so that a wrong address or name is an error at once.
  const auto info = client->GetMesh(command.id);
  if (!info.ok()) return ReportServerError(info.status());
  if (auto status = CheckOutputsOf(info->options, command.output); !status.ok()) {
    return ReportServerError(status);
  }
  Printer printer(command, *region);
  client::WatchOptions options;
  options.regions = region->in;
  const auto session = client->Watch(command.id, options, &printer);
  absl::Status status = printer.Wait();
  session->Stop();
  labels.features =
      std::make_shared<const io::FeatureLabels>(io::FromLabelColumn(printer.mesh().labels));
  if (status.ok()) status = WriteOutputs(printer.mesh(), info->options, command.output, labels);
  return status.ok() ? kExitDone : ReportServerError(status);
}

}  // namespace

void RegisterWatchCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<WatchCommand>();
  CLI::App* const sub =
      AddCommand(app, slot, "watch", "Follow a server's mesh", [command] { return Run(*command); });
  sub->add_option("MESH", command->id, "Its id")->required();
  sub->add_option("--until", command->until, "End when this revision is there")
      ->type_name("REVISION");
  sub->add_flag("--progress", command->progress,
                "Tell, too, that the server is alive while nothing changes");
  AddRegionFlag(*sub, command->region);
  sub->get_option("--region")
      ->description(
          "Only what lies in at least one of these polygons; in 3D in closed surfaces, each by the "
          "id that `dynmesh stats` has for it")
      ->type_name("ID[,ID...]");
  AddOutputFlags(*sub, command->output);
  AddMarkersFlag(*sub, command->markers);
  AddServerFlags(*sub, command->server);
}

}  // namespace dynmesh::cli
