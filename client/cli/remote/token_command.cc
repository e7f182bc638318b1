// dynmesh token: makes a new bearer token, and its line for the server's token file.
#include <memory>
#include <string>

#include "absl/strings/str_format.h"
#include "client/cli/remote/connection.h"
#include "client/cli/remote/remote_commands.h"
#include "proto/codec/token_hash.h"

namespace dynmesh::cli {
namespace {

struct TokenCommand {
  std::string name = "NAME";
  std::string role = "read";
  std::string meshes = "*";
  bool json = false;
};

int Run(const TokenCommand& command) {
  const std::string token = codec::RandomToken();
  if (token.empty()) return ReportError(absl::UnavailableError("the system has no random bits"));
  const std::string hash = codec::ToHex(codec::HashToken(token));
  if (command.json) {
    return Print(JsonObject().AddText("token", token).AddText("sha256", hash).ToLine());
  }
  // The token is alone on its line, so that it can be cut into a file.
  return Print(absl::StrFormat("%s\n# for the server's file of tokens:\n%s %s %s=%s\n", token,
                               command.name, hash, command.role, command.meshes));
}

}  // namespace

void RegisterTokenCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<TokenCommand>();
  CLI::App* const sub = AddCommand(
      app, slot, "token", "Make a random token, and the line for the file of `dynmeshd --tokens`",
      [command] { return Run(*command); });
  sub->add_option("NAME", command->name, "Name of the token's owner, for that line");
  sub->add_option("--role", command->role, "What it may do (default: read)")
      ->check(CLI::IsMember({"read", "edit", "admin"}));
  sub->add_option("--meshes", command->meshes, "With which meshes: an id, or crack-* (default: *)");
  sub->add_flag("--json", command->json, "Print token and hash as JSON");
}

}  // namespace dynmesh::cli
