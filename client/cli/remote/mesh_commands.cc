// dynmesh create|list|delete|export --server ADDR: the meshes of a server.
#include <memory>
#include <optional>
#include <string>

#include "absl/strings/str_format.h"
#include "client/cli/mesh_flags.h"
#include "client/cli/output.h"
#include "client/cli/remote/connection.h"
#include "client/cli/remote/remote_commands.h"
#include "client/cli/selection.h"
#include "client/cli/words.h"
#include "core/io/script/edit_script.h"

namespace dynmesh::cli {
namespace {

struct CreateCommand {
  ServerFlags server;
  std::string id;
  std::string script;
  std::optional<int> dimension;
  MeshFlags mesh;
  std::string request_id;
};

int RunCreate(const CreateCommand& command) {
  MeshOptions options;
  if (!command.script.empty()) {
    const absl::StatusOr<io::EditScript> script = io::ReadEditScript(command.script);
    if (!script.ok()) return ReportServerError(script.status());
    options = script->Options();
    if (command.dimension && *command.dimension != options.dimension) {
      return ReportServerError(absl::InvalidArgumentError(
          absl::StrFormat("--dimension: %s has %d dimensions", command.script, options.dimension)));
    }
  } else if (command.mesh.box.empty()) {
    return ReportServerError(
        absl::InvalidArgumentError("where may features lie? give --box or --like SCRIPT"));
  } else {
    options.dimension = command.dimension.value_or(2);
    options.quality = DefaultQuality(options.dimension);
    options.min_dihedral = DefaultMinDihedral(options.dimension);
  }
  if (auto status = ApplyMeshFlags(command.mesh, options); !status.ok()) {
    return ReportServerError(status);
  }
  const auto client = Connect(command.server);
  if (!client.ok()) return ReportServerError(client.status());
  const auto mesh = (*client)->CreateMesh(command.id, options, command.request_id);
  return mesh.ok() ? Print(MeshLine(*mesh, command.server.json)) : ReportServerError(mesh.status());
}

int RunList(const ServerFlags& flags) {
  const auto client = Connect(flags);
  if (!client.ok()) return ReportServerError(client.status());
  const auto meshes = (*client)->ListMeshes();
  if (!meshes.ok()) return ReportServerError(meshes.status());
  std::string text;
  for (const client::MeshInfo& mesh : *meshes) text += MeshLine(mesh, flags.json);
  return Print(text);
}

struct NamedCommand {
  ServerFlags server;
  std::string id;
  std::string region, open;
  OutputFlags output;
  std::string markers;
};

int RunDelete(const NamedCommand& command) {
  const auto client = Connect(command.server);
  if (!client.ok()) return ReportServerError(client.status());
  const absl::Status status = (*client)->DeleteMesh(command.id);
  if (!status.ok()) return ReportServerError(status);
  return command.server.json ? Print(JsonObject().AddText("deleted", command.id).ToLine())
                             : Print(command.id + " deleted\n");
}

// The mesh, or what --region chooses of it: by ids at the server, any polygon here, since the
// server takes ids only. An error, with a list of what there is, if nothing is chosen.
absl::StatusOr<Mesh> GetPart(client::MeshClient& client, const NamedCommand& command,
                             const mesh_data::RegionChoice& region, const MeshOptions& options) {
  const bool is_opened = !command.open.empty();  // then it takes the whole mesh
  absl::StatusOr<Mesh> part =
      client.GetSnapshot(command.id, is_opened ? std::vector<FeatureId>() : region.in);
  if (!part.ok() || (command.region.empty() && !is_opened)) return part;
  if (!is_opened && !region.in_any && part->simplex_count() != 0) return part;
  // Only the whole mesh says what there is.
  const absl::StatusOr<Mesh> whole =
      region.in_any || is_opened ? part : client.GetSnapshot(command.id);
  if (!whole.ok()) return whole;
  Input nothing_known;
  nothing_known.options = options;
  SelectionFlags flags;
  flags.region = command.region, flags.open = command.open;
  const auto selection = Selection::Parse(flags, nothing_known, false);
  if (!selection.ok()) return selection.status();
  absl::StatusOr<Mesh> chosen = selection->Of(*whole);
  if (!chosen.ok() || !is_opened) return chosen;
  return selection->OpenedOf(*whole);
}

int RunExport(const NamedCommand& command) {
  if (auto status = CheckOutputs(command.output); !status.ok()) return ReportServerError(status);
  MeshLabels labels;
  if (auto status = ParseMarkersFlag(command.markers, labels); !status.ok()) {
    return ReportServerError(status);
  }
  const auto region = ParseRegionFlag(command.region);
  if (!region.ok()) return ReportServerError(region.status());
  const auto client = Connect(command.server);
  if (!client.ok()) return ReportServerError(client.status());
  const auto info = (*client)->GetMesh(command.id);
  if (!info.ok()) return ReportServerError(info.status());
  if (auto status = CheckOutputsOf(info->options, command.output); !status.ok()) {
    return ReportServerError(status);
  }
  const auto mesh = GetPart(**client, command, *region, info->options);
  if (!mesh.ok()) return ReportServerError(mesh.status());
  WarnOfUnknownRegions(*region, *mesh);
  labels.features = std::make_shared<const io::FeatureLabels>(io::FromLabelColumn(mesh->labels));
  labels.is_part = !command.region.empty();
  if (auto status = WriteOutputs(*mesh, info->options, command.output, labels); !status.ok()) {
    return ReportServerError(status);
  }
  if (!command.server.json) {
    return Print(absl::StrFormat("revision %d: %d vertices, %d %s, hash %s\n", mesh->revision,
                                 mesh->vertices.size(), mesh->simplex_count(),
                                 SimplicesWord(mesh->dimension), mesh->hash.ToHex()));
  }
  JsonObject line;
  line.AddText("mesh", command.id)
      .Add("revision", mesh->revision)
      .Add("vertices", mesh->vertices.size())
      .Add("simplices", mesh->simplex_count())
      .Add("subsegments", mesh->subsegments.size())
      .Add("subfacets", mesh->subfacets.size())
      .AddText("hash", mesh->hash.ToHex());
  AddLabels(mesh->labels, line);
  return Print(line.ToLine());
}

}  // namespace

void RegisterCreateCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<CreateCommand>();
  CLI::App* const sub = AddCommand(app, slot, "create", "Create a mesh on a server",
                                   [command] { return RunCreate(*command); });
  sub->add_option("MESH", command->id,
                  "Its id, [a-z][a-z0-9-]{0,62} (default: the server's choice)");
  sub->add_option("--like", command->script, "Take the options of this edit script's mesh line")
      ->type_name("SCRIPT");
  sub->add_option("--dimension", command->dimension, "2 or 3 (default: 2, or the script's)")
      ->type_name("D")
      ->check(CLI::Range(2, 3));
  sub->add_option("--box", command->mesh.box, "Where features may lie")->type_name(kBoxOfEither);
  sub->add_option(
      "--rho", command->mesh.rho,
      "Largest circumradius / shortest edge, 1 to 100, from 1.4142 with criterion thesis "
      "(default: sqrt 2); in 3D 1.2 to 100, from 1.4 with polygons, from 2 with criterion "
      "thesis (default: 2)");
  sub->add_option("--criterion", command->mesh.criterion, "What rho bounds (default: edge)")
      ->type_name("edge|thesis");
  sub->add_option("--max-vertices", command->mesh.max_vertices,
                  "Refuse to make more (default: the server's limit)");
  sub->add_option("--request-id", command->request_id, "Makes a retry safe");
  AddServerFlags(*sub, command->server);
}

void RegisterListCommand(CLI::App& app, CommandSlot& slot) {
  auto flags = std::make_shared<ServerFlags>();
  CLI::App* const sub =
      AddCommand(app, slot, "list", "List a server's meshes", [flags] { return RunList(*flags); });
  AddServerFlags(*sub, *flags);
}

void RegisterDeleteCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<NamedCommand>();
  CLI::App* const sub = AddCommand(app, slot, "delete", "Delete a mesh of a server",
                                   [command] { return RunDelete(*command); });
  sub->add_option("MESH", command->id, "Its id")->required();
  AddServerFlags(*sub, command->server);
}

void RegisterExportCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<NamedCommand>();
  CLI::App* const sub = AddCommand(app, slot, "export", "Write a server's mesh to files",
                                   [command] { return RunExport(*command); });
  sub->add_option("MESH", command->id, "Its id")->required();
  AddRegionFlag(*sub, command->region);
  AddOpenFlag(*sub, command->open);
  AddOutputFlags(*sub, command->output);
  AddMarkersFlag(*sub, command->markers);
  sub->get_option("--output")->required();
  AddServerFlags(*sub, command->server);
}

void RegisterRemoteCommands(CLI::App& app, CommandSlot& slot) {
  RegisterCreateCommand(app, slot);
  RegisterListCommand(app, slot);
  RegisterDeleteCommand(app, slot);
  RegisterApplyCommand(app, slot);
  RegisterLoadCommand(app, slot);
  RegisterWatchCommand(app, slot);
  RegisterExportCommand(app, slot);
  RegisterLfsCommand(app, slot);
  RegisterFeaturesCommand(app, slot);
  RegisterRevertCommand(app, slot);
  RegisterStatsCommand(app, slot);
  RegisterTokenCommand(app, slot);
}

}  // namespace dynmesh::cli
