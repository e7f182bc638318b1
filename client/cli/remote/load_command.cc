// dynmesh load MESH INPUT --server ADDR: all features of an input file as one revision.
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "absl/strings/str_format.h"
#include "client/cli/input.h"
#include "client/cli/labels.h"
#include "client/cli/progress_bar.h"
#include "client/cli/remote/connection.h"
#include "client/cli/remote/remote_commands.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::cli {
namespace {

struct LoadCommand {
  ServerFlags server;
  InputFlags reading;
  std::string id;
  std::string input;
  std::string request_id;
  std::optional<std::uint64_t> expected_revision;
  bool create = false;
};

std::string Summarise(const client::LoadResult& result, std::size_t features, double seconds,
                      bool json) {
  if (json) {
    return JsonObject()
        .AddText("event", result.replayed ? "replayed" : "loaded")
        .Add("from_revision", result.from_revision)
        .Add("revision", result.to_revision)
        .Add("features", features)
        .Add("seconds", seconds)
        .Add("operations", result.work.executed)
        .Add("microseconds", result.work.microseconds)
        .Add("validate_microseconds", result.work.validate_microseconds)
        .Add("diff_microseconds", result.work.diff_microseconds)
        .AddText("hash", result.hash.ToHex())
        .ToLine();
  }
  return absl::StrFormat("revision %d: %d features %s in %.3f s, %d operations, hash %s\n",
                         result.to_revision, features,
                         result.replayed ? "had been loaded; asked again" : "loaded", seconds,
                         result.work.executed, result.hash.ToHex());
}

// The mesh's dimension must be the input's. `made`: this command has made the mesh.
absl::Status PrepareMesh(client::MeshClient& client, const LoadCommand& command, const Input& input,
                         bool& made) {
  if (command.create) {
    const absl::Status created = client.CreateMesh(command.id, input.options).status();
    made = created.ok();
    if (created.code() != absl::StatusCode::kAlreadyExists) return created;
  }
  const auto mesh = client.GetMesh(command.id);
  if (!mesh.ok()) return mesh.status();
  if (mesh->options.dimension == input.options.dimension) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat("%s has %d dimensions, the mesh has %d",
                                                    command.input, input.options.dimension,
                                                    mesh->options.dimension));
}

int Run(const LoadCommand& command) {
  const auto client = Connect(command.server);
  if (!client.ok()) return ReportServerError(client.status());
  absl::StatusOr<Input> input = LoadInput(command.input, command.reading);
  if (!input.ok()) return ReportServerError(input.status());
  if (auto status = AddSeedPolygons(*input); !status.ok()) return ReportServerError(status);
  if (input->options.dimension == 3 && !input->holes.empty()) {
    input->warnings.push_back(
        absl::StrFormat("%s: %d seed(s) of 3D holes left out: `dynmesh mesh --inside` uses them",
                        command.input, input->holes.size()));
  }
  for (const std::string& warning : input->warnings) PrintWarning(warning);
  if (const auto left_out = LabelsLeftOut(*input, command.input); !left_out.empty()) {
    PrintWarning(left_out);
  }
  io::SetLabels(*input->labels, input->features);
  bool made = false;
  if (auto s = PrepareMesh(**client, command, *input, made); !s.ok()) return ReportServerError(s);
  ProgressBar bar(ErrorIsTerminal());
  client::LoadParams params;
  params.request_id = command.request_id;
  params.expected_revision = command.expected_revision;
  params.dimension = input->options.dimension;
  params.progress = [&](const client::LoadProgress& p) {
    const bool sending = p.stage == client::LoadProgress::Stage::kSend;
    bar.Show(p.done, sending ? input->features.size() : p.total, WordOf(p.stage));
  };
  const auto start = std::chrono::steady_clock::now();
  const auto result = (*client)->Load(command.id, input->features, params);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  bar.End();
  if (!result.ok()) {
    if (made) WarnOfEmptyMesh(command.id);
    const auto error = codec::GetServiceError(result.status());
    if (!error.has_value()) return ReportError(result.status());
    return ReportError(
        LocateFeatures(WithReason(result.status()), error->Features(), input->where));
  }
  return Print(Summarise(*result, input->features.size(), took.count(), command.server.json));
}

}  // namespace

void RegisterLoadCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<LoadCommand>();
  CLI::App* const sub = AddCommand(app, slot, "load",
                                   "Add all features of a file to a server's mesh, as one revision",
                                   [command] { return Run(*command); });
  sub->add_option("MESH", command->id, "Its id")->required();
  sub->add_option("INPUT", command->input, io::GeometryFormats())->required();
  sub->add_flag("--create", command->create,
                "Create the mesh, with the input's bounds and the usual quality, unless it exists");
  sub->add_option("--request-id", command->request_id,
                  "Loading again with the same, after a broken connection, repeats nothing")
      ->type_name("ID");
  sub->add_option("--expected-revision", command->expected_revision,
                  "Only if the mesh is at this revision")
      ->type_name("N");
  AddInputFlags(*sub, command->reading);
  AddPreparationFlags(*sub, command->reading);
  AddServerFlags(*sub, command->server);
}

}  // namespace dynmesh::cli
