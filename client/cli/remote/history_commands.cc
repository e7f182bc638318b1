// dynmesh features|revert --server ADDR: shows a mesh's features, and reverts to a revision.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/cli/output.h"
#include "client/cli/remote/connection.h"
#include "client/cli/remote/remote_commands.h"
#include "core/io/common/file_writer.h"
#include "core/io/script/edit_script.h"

namespace dynmesh::cli {
namespace {

struct FeaturesCommand {
  ServerFlags server;
  std::string id;
  std::optional<std::uint64_t> revision;
  std::string output;
};

// A script from which `replay` makes the same mesh, and `apply` the same labels.
std::string ScriptOf(const codec::FeaturesAt& found, const MeshOptions& options) {
  std::string text = absl::StrCat(io::FormatMeshLine(options), "\n");
  for (const Feature& feature : found.features) {
    absl::StrAppend(&text, io::FormatEdit(Edit::Add(feature), options.dimension), "\n");
  }
  for (const Feature& feature : found.features) text += io::FormatLabel(feature.id, *feature.label);
  return text;
}

int RunFeatures(const FeaturesCommand& command) {
  const auto client = Connect(command.server);
  if (!client.ok()) return ReportServerError(client.status());
  const auto info = (*client)->GetMesh(command.id);
  if (!info.ok()) return ReportServerError(info.status());
  const auto found = (*client)->GetFeatures(command.id, command.revision);
  if (!found.ok()) return ReportServerError(found.status());
  const std::string script = ScriptOf(*found, info->options);
  if (command.output.empty()) return Print(script);
  io::FileWriter out(command.output);
  out << script;
  if (const absl::Status status = out.Close(); !status.ok()) return ReportServerError(status);
  return command.server.json
             ? Print(JsonObject()
                         .AddText("mesh", command.id)
                         .Add("revision", found->revision)
                         .Add("features", found->features.size())
                         .AddText("hash", found->hash.ToHex())
                         .ToLine())
             : Print(absl::StrCat("revision ", found->revision, ": ", found->features.size(),
                                  " features, hash ", found->hash.ToHex(), "\n"));
}

struct RevertCommand {
  ServerFlags server;
  std::string id;
  std::uint64_t revision = 0;
  client::EditParams params;
};

int RunRevert(const RevertCommand& command) {
  const auto client = Connect(command.server);
  if (!client.ok()) return ReportServerError(client.status());
  client::EditParams params = command.params;
  params.omit_columns = true;
  const auto result = (*client)->RevertTo(command.id, command.revision, params);
  if (!result.ok()) return ReportServerError(result.status());
  const std::string hash = result->diff.hash.ToHex();
  return command.server.json
             ? Print(JsonObject()
                         .AddText("mesh", command.id)
                         .Add("revision", result->diff.to_revision)
                         .Add("reverted_to", command.revision)
                         .AddText("hash", hash)
                         .ToLine())
             : Print(absl::StrCat("revision ", result->diff.to_revision, " is as revision ",
                                  command.revision, ", hash ", hash, "\n"));
}

}  // namespace

void RegisterFeaturesCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<FeaturesCommand>();
  CLI::App* const sub =
      AddCommand(app, slot, "features", "Write the features of a server's mesh as an edit script",
                 [command] { return RunFeatures(*command); });
  sub->add_option("MESH", command->id, "Its id")->required();
  sub->add_option("--revision", command->revision, "Those at an earlier revision (default: now)")
      ->type_name("R");
  sub->add_option("-o,--output", command->output, "The script (default: standard output)")
      ->type_name("FILE");
  AddServerFlags(*sub, command->server);
}

void RegisterRevertCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<RevertCommand>();
  CLI::App* const sub = AddCommand(
      app, slot, "revert", "Give a server's mesh the features of an earlier revision, as a new one",
      [command] { return RunRevert(*command); });
  sub->add_option("MESH", command->id, "Its id")->required();
  sub->add_option("REVISION", command->revision, "The earlier one")->required();
  sub->add_option("--expect", command->params.expected_revision,
                  "Fail unless the mesh is at this revision")
      ->type_name("R");
  sub->add_option("--request-id", command->params.request_id, "Makes a retry safe");
  AddServerFlags(*sub, command->server);
}

}  // namespace dynmesh::cli
